"""Static minus Coulomb torque after one record of profile 2 and one designed record.

    python benchmarks/next_record.py [--records 200] [--seed 80000] [--duration 60] [--ripple 0]
        [--unknown]

Wheels with dispersed parameters, flown by the integrator of `bench_wheels.py`; the static torque
lies 1 to 30 % above the Coulomb torque (log-uniform), which covers the 3 % of Carrara and Kuga. For
each wheel: profile 2 (300 s at 10 Hz, 5 rpm noise), identification, design of the next record from
this fit alone, that record, and identification of both. A ripple is stated to design and
identification unless `--unknown` is given. Printed by excess of the static torque:
share of wheels at 3 sigma, and the actual error against the predicted and the reported sigma.
"""

import argparse
import sys
import time
from itertools import pairwise

import numpy as np
from bench_wheels import INERTIA, RATE, STRIBECK_SPEED, simulator

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.experiment.current_profiles import Limits
from gyrostat.identification.experiment.experiment_design import design_record
from gyrostat.identification.experiment.known_wheel import KnownWheel
from gyrostat.telemetry import Record

NOISE, WANTED = 5.0 * RPM, "static-coulomb"
EDGES = (0.01, 0.02, 0.03, 0.05, 0.1, 0.3)
CLEAR = 3.0
RMS = np.sqrt(0.625)
"""Of the ripple of `bench_wheels.py`, two harmonics, over its amplitude."""


def drawn(random: np.random.Generator, ripple: float) -> np.ndarray:
    """Parameters of one wheel, as `simulator` takes them, (13,)."""
    motor = 0.0228 * random.uniform(0.8, 1.25)
    viscous = 4.83e-6 * random.uniform(0.6, 1.6)
    coulomb = 0.8795e-3 * random.uniform(0.7, 1.4)
    static = coulomb * (1.0 + np.exp(random.uniform(np.log(EDGES[0]), np.log(EDGES[-1]))))
    phases = random.uniform(0.0, 6.283, 2)
    own = [motor, INERTIA, viscous, coulomb, static, ripple * coulomb, random.integers(2, 9)]
    return np.array([*own, *phases, 0.0, 0.0, 0.0, 0.5])


def measured(wheel: np.ndarray, current: np.ndarray, random: np.random.Generator) -> Record:
    """Record of a wheel that starts from rest."""
    still = np.zeros((1, len(current)))
    speed = np.asarray(simulator()(wheel[None], current[None], still, still))[0]
    clock = np.arange(len(current)) / RATE
    noise = NOISE * random.standard_normal(len(current))
    return Record("bench", clock, current, speed + noise, clock >= 0.0)


def profile_2(wheel: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Steps of 30 s of random amplitude and alternating sense, 300 s, A."""
    step = np.minimum(np.arange(3001) // 300, 9)
    levels = random.uniform(1.55, 3.9, 10) * (-1.0) ** np.arange(10)
    return (wheel[3] / wheel[0] * levels)[step]


def contrast(fit) -> tuple[float, float]:
    """Static minus Coulomb torque of a fit with its sigma, N·m."""
    place = [fit.names.index(n) for n in ("static", "coulomb")]
    sign = np.array([1.0, -1.0])
    return float(sign @ fit.values[place]), float(
        np.sqrt(sign @ fit.covariance[np.ix_(place, place)] @ sign)
    )


def one_wheel(
    seed: int, number: int, duration: float, ripple: float, unknown: bool
) -> list[float] | None:
    """Row of the table for one wheel; None if a step gives no valid result."""
    random = np.random.default_rng([seed, number])
    wheel = drawn(random, ripple)
    options = {"inertia": INERTIA, "hold": {"stribeck_speed": STRIBECK_SPEED}, "speed_sigma": NOISE}
    first = measured(wheel, profile_2(wheel, random), random)
    stated = ripple * RMS if ripple > 0.0 and not unknown else None
    try:
        before = identify(first, ripple=stated, **options)
        limits = Limits(duration, RATE, float(np.abs(first.current).max()))
        started = time.perf_counter()
        design = design_record(
            KnownWheel.from_fit(before),
            [WANTED],
            limits,
            speed_sigma=NOISE,
            ripple=stated,
            seed=number,
        )
        seconds = time.perf_counter() - started
        second = measured(wheel, design.current, random)
        after = identify([first, second], ripple=stated, **options)
    except InputError as error:
        print(f"wheel {number}: {error}", file=sys.stderr)
        return None
    if not after.converged:
        return None
    truth, (value, sigma) = wheel[4] - wheel[3], contrast(after)
    share, predicted = truth / wheel[3], design.wanted[0].after
    return [share, value - truth, sigma, value / sigma, predicted, contrast(before)[1], seconds]


def show(rows: np.ndarray) -> None:
    """Print the table of all wheels."""
    share, error, sigma, clear, predicted, before, seconds = rows.T
    print(f"{len(rows)} wheels, {np.median(seconds):.1f} s each design")
    names = (
        "static/coulomb - 1",
        "wheels",
        "at 3 sigma",
        "sigma before",
        "predicted",
        "reported",
        "rms error",
        "in 1.96 sigma",
    )
    print("".join(f"{name:>20s}" for name in names))
    for low, high in [*pairwise(EDGES), (EDGES[0], EDGES[-1])]:
        own = (share >= low) & (share < high)
        if own.any():
            cells = (
                f"{100 * low:.0f} to {100 * high:.0f} %",
                str(own.sum()),
                f"{100 * np.mean(clear[own] >= CLEAR):.0f} %",
                f"{1e6 * np.median(before[own]):.1f}",
                f"{1e6 * np.median(predicted[own]):.1f}",
                f"{1e6 * np.median(sigma[own]):.1f}",
                f"{1e6 * np.sqrt(np.mean(error[own] ** 2)):.1f}",
                f"{100 * np.mean(np.abs(error[own]) <= 1.96 * sigma[own]):.0f} %",
            )
            print("".join(f"{cell:>20s}" for cell in cells))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--seed", type=int, default=80000)
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--ripple", type=float, default=0.0, help="amplitude over Coulomb torque")
    parser.add_argument("--unknown", action="store_true", help="state no ripple")
    given = parser.parse_args()
    rows = [
        one_wheel(given.seed, k, given.duration, given.ripple, given.unknown)
        for k in range(given.records)
    ]
    print(f"seed {given.seed}, {given.duration:g} s, ripple {given.ripple:g}")
    print(f"{sum(row is None for row in rows)} without a valid result")
    show(np.array([row for row in rows if row is not None]))


if __name__ == "__main__":
    main()
