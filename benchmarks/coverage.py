"""Coverage of 95 % intervals of identified wheels, over records with effects beside the model.

    python benchmarks/coverage.py [--case usual] [--records 200] [--seed 50000]

Truth is dispersed (`bench_wheels.py`), inertia and current scale by 1 % each. Seeds below 10000
served development; proof uses others. For each parameter: coverage of value ± 1.96 sigma, rms error
in % of the truth, w = mean width over 3.92 rms error; once with inertia and current scale exact
(the same fits against what the wheels show at the nominal inertia and scale, by the exact scaling
law, with the share of the record in sigma), once with both tolerances, and for least squares.
"""

import argparse
import time

import numpy as np
from bench_wheels import INERTIA, NAMES, NOISE_ONLY, STRIBECK_SPEED, USUAL, Effects, records

from gyrostat.core.units import RPM
from gyrostat.identification import identify

TOLERANCE = 0.01
CASES = {
    "noise": NOISE_ONLY,
    "usual": USUAL,
    "weak": Effects(ripple=0.02, drift=0.04, lag=0.02),
    "sine": Effects(ripple=0.05, drift=0.1, lag=0.05, drift_shape="sine"),
    "quiet": Effects(ripple=0.05, drift=0.1, lag=0.05, speed_sigma=1.0 * RPM),
}
HALF_WIDTH = 1.959964


def table(error: np.ndarray, sigma: np.ndarray) -> dict[str, np.ndarray]:
    """Rows of the table from relative errors and sigmas, (records, parameters)."""
    rms = np.sqrt(np.mean(error**2, axis=0))
    return {
        "coverage %": 100.0 * np.mean(np.abs(error) <= HALF_WIDTH * sigma, axis=0),
        "rms error %": 100.0 * rms,
        "w": np.mean(sigma, axis=0) / rms,
    }


def main() -> None:
    """Print the tables of one case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", choices=CASES, default="usual")
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--seed", type=int, default=50000)
    arguments = parser.parse_args()
    tolerance = {"inertia": TOLERANCE, "current_scale": TOLERANCE}
    exact, plain, given, own, white, sigma = [], [], [], [], [], []
    rejected, failed = 0, 0
    started = time.perf_counter()
    drawn = records(arguments.seed, arguments.records, CASES[arguments.case], TOLERANCE)
    for record, truth, apparent in drawn:
        hold = {"stribeck_speed": STRIBECK_SPEED}
        options = {"inertia": INERTIA, "hold": hold, "tolerance": tolerance}
        fit, least = (identify(record, **options, white_noise=flag) for flag in (False, True))
        if not fit.converged:
            failed += 1
            continue
        places = [fit.names.index(name) for name in NAMES]
        true = np.array([truth[name] for name in NAMES])
        shown = np.array([apparent[name] for name in NAMES])
        share = np.sqrt(fit.variance_shares["record"][places])
        given.append((fit.values[places] - true) / true)
        exact.append((fit.values[places] - shown) / shown)
        plain.append((least.values[places] - shown) / shown)
        sigma.append(fit.sigma[places] / true)
        own.append(share * fit.sigma[places] / shown)
        white.append(least.noise_sigma[places] / shown)
        rejected += least.whiteness is not None and not least.whiteness.white
    seconds = time.perf_counter() - started
    columns = (exact, plain, given, own, white, sigma)
    exact, plain, given, own, white, sigma = (np.array(rows) for rows in columns)
    print(f"case {arguments.case}, seed {arguments.seed}: {len(exact)} records, {seconds:.0f} s")
    print(f"{'':34s}" + "".join(f"{name:>16s}" for name in NAMES))
    for title, rows in (
        ("inertia and current scale exact", table(exact, own)),
        (f"tolerances of {100 * TOLERANCE:g} % each", table(given, sigma)),
        ("least squares in white noise", table(plain, white)),
        ("width", {"over white noise": np.mean(own / white, axis=0)}),
    ):
        print(title)
        for label, row in rows.items():
            print(f"  {label:32s}" + "".join(f"{value:16.3g}" for value in row))
    print(f"residuals not white: {rejected} of {len(exact)}; not converged: {failed}")


if __name__ == "__main__":
    main()
