"""Promised sigma of a designed record against the errors of the product's own fit.

    python benchmarks/designed_records.py [--records 400] [--seed 91000] [--duration 60]
        [--wanted static-coulomb viscous all] [--ripple 0.03] [--state-ripple]
        [--state-drift] [--bare]

One wheel for each design, flown by the integrator of `bench_wheels.py`: profile 2 (300 s at 10 Hz),
identification, and the design of the next record from this fit alone. Then both records are
repeated with new noise, phases of the ripple and drifts. Each time the first record promises a
sigma for the designed one, and both are identified together. What a first record shows of ripple
and drift differs from one to the next, and with it the promise: each error is therefore compared
with the promise of its own first record. Columns: median sigma before, median promise with its
first and ninth decile, median sigma reported, root mean square of the errors against the truth, of
the errors over their promises (z promise) and over the reported sigmas (z reported), intervals
that contain the truth. Ripple (two harmonics), drift of viscous and dry friction, and rounding of
current and speed are on, unless `--bare` leaves white noise only.
"""

import argparse
import sys
import time
from dataclasses import replace

import numpy as np
from bench_wheels import INERTIA, RATE, STRIBECK_SPEED, simulator
from next_record import RMS, drawn, profile_2

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.experiment.current_profiles import Limits
from gyrostat.identification.experiment.design import Design
from gyrostat.identification.experiment.experiment_design import design_record
from gyrostat.identification.experiment.known_wheel import KnownWheel
from gyrostat.identification.experiment.record_information import information_gained
from gyrostat.identification.uncertainty.sigmas import square_root
from gyrostat.telemetry import Record

NAMES = ("motor_constant", "viscous", "coulomb", "static")
NOISE, SPEED_STEP, CURRENT_STEP = 1.0 * RPM, 0.4 * RPM, 1e-3
MOST_LEVELS = 20
WHEELS = 16
"""Wheels drawn from the first fit, over which a promise is the median."""
VISCOUS_DRIFT, DRY_DRIFT = 0.05, 0.02


def measured(
    wheel: np.ndarray, current: np.ndarray, random: np.random.Generator, *, bare: bool
) -> Record:
    """Record of a wheel from rest, at random phases of its ripple, with drift and rounding."""
    wheel = wheel.copy()
    wheel[7:9] += random.uniform(0.0, 2.0 * np.pi, 2)
    if not bare:
        # a drive sets a level to a fraction of its step: the error of rounding is another each time
        levels, index = np.unique(current, return_inverse=True)
        if len(levels) <= MOST_LEVELS:
            levels = levels + (levels != 0.0) * CURRENT_STEP * random.uniform(
                -0.5, 0.5, len(levels)
            )
            current = levels[index]
    share = np.linspace(-1.0, 1.0, len(current))
    signs = random.choice([-1.0, 1.0], 2) * (not bare)
    drifts = (VISCOUS_DRIFT * signs[0] * share, DRY_DRIFT * signs[1] * share)
    speed = np.asarray(simulator()(wheel[None], current[None], *(d[None] for d in drifts)))[0]
    speed = speed + NOISE * random.standard_normal(len(current))
    clock = np.arange(len(current)) / RATE
    if not bare:
        speed = SPEED_STEP * np.round(speed / SPEED_STEP)
        current = CURRENT_STEP * np.round(current / CURRENT_STEP)
    return Record("bench", clock, current, speed, clock >= 0.0)


def one_design(given: argparse.Namespace, number: int, text: str) -> None:
    """Design one record, simulate it and print its rows."""
    random = np.random.default_rng([given.seed, number])
    ripple = 0.0 if given.bare else given.ripple
    wheel = drawn(random, ripple)
    stated = ripple * RMS if given.state_ripple else None
    options = {"inertia": INERTIA, "hold": {"stribeck_speed": STRIBECK_SPEED}, "ripple": stated}
    first_current = profile_2(wheel, random)
    before = identify(measured(wheel, first_current, random, bare=given.bare), **options)
    known = KnownWheel.from_fit(before)
    if given.state_drift:
        known = replace(known, drifts=((VISCOUS_DRIFT, 0.0), (DRY_DRIFT, 0.0)))
    combinations = list(NAMES) if text == "all" else [text]
    limits = Limits(given.duration, RATE, float(np.abs(first_current).max()))
    design = design_record(
        known, combinations, limits, speed_sigma=known.speed_sigma, ripple=stated, seed=number
    )
    started, failed, rows = time.perf_counter(), 0, []
    truth = np.array([wheel[k] for k in (0, 2, 3, 4)])
    for _ in range(given.records):
        pair = [
            measured(wheel, current, random, bare=given.bare)
            for current in (first_current, design.current)
        ]
        try:
            alone, fit = identify(pair[0], **options), identify(pair, **options)
            promises = promised(KnownWheel.from_fit(alone), design, given, stated)
        except InputError as error:
            print(f"{text}: {error}", file=sys.stderr)
            failed += 1
            continue
        failed += not fit.converged
        if fit.converged:
            before, sigma = ([f.sigma[n] for n in NAMES] for f in (alone, fit))
            error = np.array([fit.parameters[n] for n in NAMES]) - truth
            rows.append([before, promises, sigma, error])
    seconds = (time.perf_counter() - started) / given.records
    print(f"{text}: {design.shape.family}, {len(rows)} fits, {failed} failed, {seconds:.1f} s")
    befores, promises, sigmas, errors = np.array(rows).transpose(1, 0, 2)
    for k, name in enumerate(NAMES):
        promise, sigma, error = promises[:, k], sigmas[:, k], errors[:, k]
        cells = (
            plain(float(np.median(befores[:, k]))),
            plain(float(np.median(promise))),
            *(plain(float(each)) for each in np.quantile(promise, [0.1, 0.9])),
            plain(float(np.median(sigma))),
            plain(rms(error)),
            f"{rms(error / promise):.2f}",
            f"{rms(error / sigma):.2f}",
            f"{100.0 * np.mean(np.abs(error) < 1.96 * sigma):.0f} %",
        )
        print(f"  {name:16s}" + "".join(f"{cell:>12s}" for cell in cells), flush=True)


def promised(
    known: KnownWheel, design: Design, given: argparse.Namespace, ripple: float | None
) -> list[float]:
    """Sigma of each parameter that a fit of the first record promises for the designed one."""
    if given.state_drift:
        known = replace(known, drifts=((VISCOUS_DRIFT, 0.0), (DRY_DRIFT, 0.0)))
    torque = (known.ripple if ripple is None else ripple) * known.dry_torque()
    every = list(known.values)
    gained = information_gained(
        known.model,
        known.draws(WHEELS, np.random.default_rng(0), torque),
        design.current[None],
        design.time,
        places=[every.index(name) for name in known.names],
        root=square_root(known.covariance),
        speed_sigma=known.speed_sigma or NOISE,
        effects=known.effects(torque),
    )
    sigma = np.sqrt(np.diagonal(gained.covariance[0, :, -1], axis1=-2, axis2=-1))
    return [float(np.median(sigma[:, known.names.index(name)])) for name in NAMES]


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def plain(value: float) -> str:
    """Three digits."""
    return f"{value:.3g}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=400)
    parser.add_argument("--seed", type=int, default=91000)
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--wanted", nargs="+", default=["static-coulomb", "viscous", "all"])
    parser.add_argument("--ripple", type=float, default=0.03, help="amplitude over Coulomb torque")
    parser.add_argument("--state-ripple", action="store_true")
    parser.add_argument("--state-drift", action="store_true", help="state the drift to the design")
    parser.add_argument("--bare", action="store_true", help="white noise only")
    given = parser.parse_args()
    header = ("before", "promised", "first decile", "ninth", "reported", "rms error")
    header = (*header, "z promise", "z reported", "covered")
    print(f"{'':18s}" + "".join(f"{name:>12s}" for name in header))
    for number, text in enumerate(given.wanted):
        one_design(given, number, text)


if __name__ == "__main__":
    main()
