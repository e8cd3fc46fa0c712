"""Friction from coast-down records."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.bench.bench_methods import (
    held_values,
    relaxed_time,
    require_held,
    result,
)
from gyrostat.identification.bench.segments import fit_stretches
from gyrostat.identification.read.checks import as_records, check_sigma, check_signals, place
from gyrostat.identification.read.statistics import noise_level, quantum
from gyrostat.identification.result.fit import Fit
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import runs, scatter, trapezoidal
from gyrostat.wheel.friction import ViscousCoulomb

MIN_SAMPLES = 10
"""Smallest number of speed samples in a coast-down; fewer do not determine slope and curvature."""
NO_CURRENT = 1e-3
"""Current, relative to the largest of the record, below which the motor counts as switched off."""
ZERO = 4.0
"""Current, in standard deviations of its noise, below which it counts as zero."""
SLOW = 0.05
"""Speed, relative to the first one, below which a coast-down ends: Stribeck friction may occur."""
TURNING = 5.0
"""Smallest loss of speed in a coast-down, in standard deviations of the speed."""


@dataclass(frozen=True)
class Coast:
    """Interval without current.

    Attributes:
        time: Time from the start of the interval, (m,), s.
        speed: Measured speed, (m,), rad/s, positive in the sense of rotation at the start.
        start: Time of the start in the record, s.
    """

    time: Vector
    speed: Vector
    start: float = 0.0


def slowing_speed(
    time: Vector, initial: float, viscous: float, coulomb: float
) -> tuple[Vector, Matrix]:
    """Speed of a wheel that coasts, and its derivatives, while it turns.

    w = w0 exp(-b t/J) - c/b (1 - exp(-b t/J)).

    Args:
        time: Time, (m,), s.
        initial: Initial speed w0, rad/s.
        viscous: Viscous coefficient over inertia, b/J, 1/s.
        coulomb: Coulomb torque over inertia, c/J, rad/s².

    Returns:
        Speed, (m,), and its derivatives with respect to b/J, c/J and w0, (m, 3).
    """
    decay = np.exp(-viscous * time)
    decay_integral, bend = relaxed_time(time, viscous)
    speed = initial * decay - coulomb * decay_integral
    slopes = np.column_stack([-time * initial * decay - coulomb * bend, -decay_integral, decay])
    return speed, slopes


def coasting_speed(
    time: Vector, initial: float, viscous: float, coulomb: float
) -> tuple[Vector, Matrix]:
    """Speed of a wheel that coasts to rest, and its derivatives: zero after the stop.

    Arguments and results are those of `slowing_speed`.
    """
    speed, slopes = slowing_speed(time, initial, viscous, coulomb)
    turns = speed > 0.0
    return np.where(turns, speed, 0.0), slopes * turns[:, None]


def _switched_off(record: Record) -> list[NDArray[np.intp]]:
    """Intervals, as sample indices, in which the current is zero within noise and quantisation."""
    noise = scatter(record.current)
    least = NO_CURRENT * float(np.max(np.abs(record.current)))
    level = max(least, ZERO * noise, 0.6 * (quantum(record.current) or 0.0))
    off = np.abs(record.current) <= level
    stretches = [np.arange(first, last) for first, last in runs(off)]
    # a small current may be hidden by the noise of separate samples, but not in the mean
    return [
        s
        for s in stretches
        if abs(record.current[s].mean()) <= max(least, ZERO * noise / np.sqrt(len(s)))
    ]


def find_coasts(record: Record, noise: float) -> list[Coast]:
    """Find intervals in which a turning wheel was left without current, until it stops.

    Args:
        record: Record of one wheel.
        noise: Standard deviation of a measured speed, rad/s.
    """
    slowest = max(TURNING * noise, 2.0 * (quantum(record.speed[record.valid]) or 0.0))
    coasts = []
    for stretch in _switched_off(record):
        # the current of a sample is held until the next one, whose speed still belongs to the coast
        stretch = np.append(stretch, stretch[-1] + 1)
        stretch = stretch[stretch < len(record.time)]
        stretch = stretch[record.valid[stretch]]
        if len(stretch) < MIN_SAMPLES:
            continue
        from scipy.ndimage import median_filter  # slow to import and rarely needed

        # noise must not determine the end of the coast: use medians of neighbouring samples
        smooth = median_filter(record.speed[stretch], MIN_SAMPLES // 2, mode="nearest")
        sense = np.sign(smooth[0])
        turning = sense * smooth > max(slowest, SLOW * abs(smooth[0]))
        stretch = stretch[np.logical_and.accumulate(turning)]
        if len(stretch) < MIN_SAMPLES:
            continue
        if sense * (smooth[0] - smooth[len(stretch) - 1]) > TURNING * noise:
            time = record.time[stretch] - record.time[stretch[0]]
            start = float(record.time[stretch[0]])
            coasts.append(Coast(time, sense * record.speed[stretch], start))
    return coasts


def _start(coasts: Sequence[Coast]) -> Vector:
    """Ratios b/J and c/J and initial speeds, by regression on the integrated equation of motion."""
    rows, right = [], []
    for k, coast in enumerate(coasts):
        columns = np.tile(np.eye(len(coasts))[k], (len(coast.time), 1))
        rows.append(np.column_stack([-trapezoidal(coast.speed, coast.time), -coast.time, columns]))
        right.append(coast.speed)
    start = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    return np.concatenate([np.maximum(start[:2], 0.0), start[2:]])


def identify_coast(
    records: Record | Sequence[Record],
    *,
    inertia: float | None,
    hold: Mapping[str, float | None] | None = None,
    speed_sigma: float | None = None,
) -> Fit:
    """Identify viscous and Coulomb friction from coast-downs, with known inertia.

    One of the bench experiments that Carrara and Kuga, "Estimating friction parameters in reaction
    wheels for attitude control", call deterministic methods. Every coast-down has its own initial
    speed; viscous and Coulomb friction are common. The closed solution is fitted by nonlinear least
    squares and ends shortly before the stop, where a Stribeck curve may rise.

    Args:
        records: Records of one wheel.
        inertia: Rotor inertia, kg·m².
        hold: motor_constant, N·m/A, to complete the wheel model; otherwise unused.
        speed_sigma: Standard deviation of the measured speed, rad/s; by default from the residuals.

    Returns:
        The fit. `Fit.predicted` is empty, since only the coast-downs are modelled.

    Raises:
        InputError: No inertia is given, or the records contain no coast-down.
    """
    records = as_records(records)
    check_sigma(speed_sigma)
    check_signals(records)
    held = held_values(ViscousCoulomb, inertia, hold, ("inertia", "motor_constant"))
    scale = require_held(held, "inertia", "a coast shows friction only as a multiple of it (kg·m²)")
    noise = max(noise_level(r.speed[r.valid]) for r in records)
    coasts = [c for r in records for c in find_coasts(r, speed_sigma or noise)]
    if not coasts:
        raise InputError(
            f"{place(records)}: found no coast, expected {MIN_SAMPLES} or more samples without "
            "current in which the wheel slows down"
        )
    start = _start(coasts)
    estimates, outcome = fit_stretches(
        [c.speed for c in coasts],
        lambda k, common, separate: coasting_speed(
            coasts[k].time, separate[0], common[0], common[1]
        ),
        start[:2],
        list(start[2:, None]),
        records=records,
        speed_sigma=speed_sigma,
        noise=noise,
        scale=scale,
        count=2,
    )
    names = ("viscous", "coulomb")
    cure = "record longer coasts from a higher speed"
    return result(
        ViscousCoulomb,
        "coast",
        dict(zip(names, estimates.tolist(), strict=True)),
        held,
        dict.fromkeys(names, cure),
        **outcome,
    )
