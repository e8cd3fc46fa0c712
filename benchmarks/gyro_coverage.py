"""Coverage of the 95 % intervals of gyro parameters on simulated records of known truth.

    python benchmarks/gyro_coverage.py --records 1000

For each case, the share of records whose interval holds the true value, and the share in which the
parameter is called observable. The standard error of a share of 95 % from 1000 records is 0.7 %.
"""

import argparse
import time

import numpy as np

from gyrostat.identification.gyro.fit import axis_noise
from gyrostat.identification.gyro.simulate import simulated_rates

# values relative to an angle random walk of 1 and intervals of 1 s: only ratios matter
CASES = {
    "all five, long": (
        100_000,
        {
            "quantisation": 1.7,
            "angle_walk": 1.0,
            "bias_instability": 0.48,
            "bias_walk": 1e-2,
            "rate_ramp": 2e-4,
        },
    ),
    "noise and walk": (
        20_000,
        {"quantisation": 3.0, "angle_walk": 1.0, "bias_walk": 5e-3, "rate_ramp": 2e-4},
    ),
    "noise and flicker": (20_000, {"angle_walk": 1.0, "bias_instability": 0.3}),
    "walk alone visible": (5_000, {"angle_walk": 1.0, "bias_walk": 0.1}),
    "white noise": (20_000, {"angle_walk": 1.0}),
    "short": (
        2_000,
        {"quantisation": 1.0, "angle_walk": 1.0, "bias_instability": 0.1, "bias_walk": 2e-3},
    ),
}
NAMES = ("quantisation", "angle_walk", "bias_instability", "bias_walk", "rate_ramp")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--case", choices=[*CASES], action="append")
    options = parser.parse_args()
    print("| case | samples | " + " | ".join(NAMES) + " | warnings | s a record |")
    print("|---" * (len(NAMES) + 4) + "|")
    for name in options.case or CASES:
        count, truth = CASES[name]
        generator = np.random.default_rng([options.seed, count, len(name)])
        held, observable, warned = np.zeros(len(NAMES)), np.zeros(len(NAMES)), 0
        spent = 0.0
        for _ in range(options.records):
            rate = simulated_rates(truth, count, 1.0, generator)
            begin = time.process_time()
            found = axis_noise("x", rate, 1.0)
            spent += time.process_time() - begin
            warned += bool(found.warnings)
            for k, parameter in enumerate(NAMES):
                estimate = found.parameters[parameter]
                held[k] += estimate.low <= truth.get(parameter, 0.0) <= estimate.high
                observable[k] += estimate.observable
        cells = [
            f"{100.0 * h / options.records:.1f} ({100.0 * o / options.records:.0f})"
            for h, o in zip(held, observable, strict=True)
        ]
        row = [name, str(count), *cells, str(warned), f"{spent / options.records:.2f}"]
        print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
