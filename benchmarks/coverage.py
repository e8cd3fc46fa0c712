"""Coverage of 95 % intervals of identified wheels, over records with effects beside the model.

    python benchmarks/coverage.py [--case usual] [--records 200] [--seed 50000]

Truth is dispersed (`bench_wheels.py`). Seeds below 10000 served development; proof uses others.
For each parameter: coverage of value ± 1.96 sigma; rms error in % of the truth, of the result and
of plain least squares; w = mean width over 3.92 rms error; mean width over that of white noise
alone, and the coverage of `sigma_noise` about the least-squares values.
"""

import argparse
import time

import numpy as np
from bench_wheels import INERTIA, NAMES, NOISE_ONLY, STRIBECK_SPEED, USUAL, Effects, records

from gyrostat.identify import identify
from gyrostat.units import RPM

CASES = {
    "noise": (NOISE_ONLY, 0.0),
    "usual": (USUAL, 0.0),
    "tolerances": (USUAL, 0.01),
    "weak": (Effects(ripple=0.02, drift=0.04, lag=0.02), 0.0),
    "sine": (Effects(ripple=0.05, drift=0.1, lag=0.05, drift_shape="sine"), 0.0),
    "quiet": (Effects(ripple=0.05, drift=0.1, lag=0.05, speed_sigma=1.0 * RPM), 0.0),
}
HALF_WIDTH = 1.959964


def main() -> None:
    """Print the table of one case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", choices=CASES, default="usual")
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--seed", type=int, default=50000)
    arguments = parser.parse_args()
    effects, tolerance = CASES[arguments.case]
    tolerances = {"inertia": tolerance, "current_scale": tolerance}
    error, plain, sigma, white = [], [], [], []
    rejected, failed = 0, 0
    started = time.perf_counter()
    for record, truth in records(arguments.seed, arguments.records, effects, tolerance):
        fit = identify(
            record,
            inertia=INERTIA,
            hold={"stribeck_speed": STRIBECK_SPEED},
            tolerance=tolerances,
        )
        if not fit.converged:
            failed += 1
            continue
        places = [fit.names.index(name) for name in NAMES]
        true = np.array([truth[name] for name in NAMES])
        error.append((fit.values[places] - true) / true)
        plain.append((fit.least_squares[places] - true) / true)
        sigma.append(fit.sigma[places] / true)
        white.append(fit.noise_sigma[places] / true)
        rejected += fit.whiteness is not None and not fit.whiteness.white
    error, plain, sigma, white = (np.array(rows) for rows in (error, plain, sigma, white))
    rms = np.sqrt(np.mean(error**2, axis=0))
    relative = {
        "coverage %": 100.0 * np.mean(np.abs(error) <= HALF_WIDTH * sigma, axis=0),
        "rms error %": 100.0 * rms,
        "rms error % of least squares": 100.0 * np.sqrt(np.mean(plain**2, axis=0)),
        "w": np.mean(sigma, axis=0) / rms,
        "width over white": np.mean(sigma, axis=0) / np.mean(white, axis=0),
        "coverage % of sigma_noise": 100.0 * np.mean(np.abs(plain) <= HALF_WIDTH * white, axis=0),
    }
    seconds = time.perf_counter() - started
    print(f"case {arguments.case}, seed {arguments.seed}: {len(error)} records, {seconds:.0f} s")
    print(f"{'':30s}" + "".join(f"{name:>16s}" for name in NAMES))
    for label, row in relative.items():
        print(f"{label:30s}" + "".join(f"{value:16.3g}" for value in row))
    print(f"residuals not white: {rejected} of {len(error)}; not converged: {failed}")


if __name__ == "__main__":
    main()
