"""Two thousand profile-2 records from the paper's start: convergence, iterations, honest sigmas.

python benchmarks/recovery.py [--records 2000] [--workers 2]
"""

import argparse
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3
TRUE = np.array([0.0228, 4.83e-6, 0.8795e-3, 0.9055e-3])
NAMES = ("motor_constant", "viscous", "coulomb", "static")
PRIOR = {
    name: (mean * INERTIA, sigma * INERTIA)
    for name, mean, sigma in zip(
        NAMES, (18.0, 0.00344, 0.5863, 0.0), (5.0, 0.002, 0.3, 0.6), strict=True
    )
}


def one(seed):
    """Error, formal sigma, iterations and convergence of one record."""
    wheel = Wheel(
        inertia=INERTIA,
        motor_constant=TRUE[0],
        friction=Stribeck(*TRUE[1:], stribeck_speed=0.418879),
    )
    record = bench_record(
        wheel,
        "steps",
        duration=299.9,
        telemetry=Telemetry(speed_sigma=5.0 * RPM),
        amplitudes=CurrentRange(0.06, 0.15),
        seed=seed,
    )
    fit = identify(
        record,
        inertia=INERTIA,
        prior=PRIOR,
        hold={"initial_speed": 0.0},
        speed_sigma=5.0 * RPM,
    )
    return fit.values - TRUE, fit.sigma, fit.iterations, fit.converged


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--records", type=int, default=2000)
    arguments.add_argument("--workers", type=int, default=2)
    options = arguments.parse_args()
    before = time.perf_counter()
    with ProcessPoolExecutor(options.workers) as pool:
        results = list(pool.map(one, range(options.records), chunksize=50))
    elapsed = time.perf_counter() - before
    error, sigma, iterations, converged = (np.array(v) for v in zip(*results, strict=True))
    print(f"records {options.records}, wall time {elapsed:.0f} s with {options.workers} processes")
    print(f"converged {converged.mean():.4f}, iterations at most {iterations.max()}, ", end="")
    print(f"median {np.median(iterations):.0f}, above 12: {(iterations > 12).sum()} ", end="")
    print(f"(first 1000 records: at most {iterations[:1000].max()})")
    print("| parameter | std of error | mean sigma | std of error / sigma | mean error / sigma |")
    print("|---|---|---|---|---|")
    for k, name in enumerate(NAMES):
        relative = error[:, k] / sigma[:, k]
        print(
            f"| {name} | {error[:, k].std():.4g} | {sigma[:, k].mean():.4g} | "
            f"{relative.std():.3f} | {relative.mean():+.3f} |"
        )


if __name__ == "__main__":
    main()
