"""Friction from coast-down records."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.bench_methods import held_values, relaxed_time, required, result
from gyrostat.identification.checks import as_records, check_sigma, check_signals, place
from gyrostat.identification.fit import Fit
from gyrostat.identification.segments import fit_stretches
from gyrostat.identification.statistics import NORMAL_MAD, noise_level, quantum
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import ViscousCoulomb

MIN_SAMPLES = 10
"""Fewest speeds of a coast: fewer show neither its slope nor its bend."""
NO_CURRENT = 1e-3
"""Share of the largest current of a record below which the motor counts as switched off."""
ZERO = 4.0
"""Standard deviations of its noise within which a current counts as zero."""
SLOW = 0.05
"""Share of its first speed below which a coast is left out: friction may rise again there."""
TURNING = 5.0
"""Standard deviations of the speed that a coast must lose for its slope to mean anything."""


@dataclass(frozen=True)
class Coast:
    """A stretch without current.

    Attributes:
        time: (m,) s from its start.
        speed: (m,) size of the measured speed in the sense of rotation at its start, rad/s.
    """

    time: Vector
    speed: Vector


def coasting_speed(
    time: Vector, initial: float, viscous: float, coulomb: float
) -> tuple[Vector, Matrix]:
    """Speed of a wheel that coasts to rest, and its derivatives.

    w = w0 exp(-b t/J) - c/b (1 - exp(-b t/J)) until it is zero, and zero from then on.

    Args:
        time: (m,) s.
        initial: w0, rad/s.
        viscous: b/J, 1/s.
        coulomb: c/J, rad/s².

    Returns:
        The speed, (m,), and its derivatives with respect to b/J, c/J and w0, (m, 3).
    """
    decay = np.exp(-viscous * time)
    lost, bend = relaxed_time(time, viscous)
    speed = initial * decay - coulomb * lost
    slopes = np.column_stack([-time * initial * decay - coulomb * bend, -lost, decay])
    turns = speed > 0.0
    return np.where(turns, speed, 0.0), slopes * turns[:, None]


def _switched_off(record: Record) -> list[NDArray[np.intp]]:
    """Stretches, as sample numbers, in which the current is zero but for its noise and rounding."""
    second = np.abs(np.diff(record.current, 2))
    noise = NORMAL_MAD * float(np.median(second)) / np.sqrt(6.0) if len(second) else 0.0
    least = NO_CURRENT * float(np.max(np.abs(record.current)))
    level = max(least, ZERO * noise, 0.6 * (quantum(record.current) or 0.0))
    off = np.abs(record.current) <= level
    edges = np.flatnonzero(np.diff(np.concatenate([[False], off, [False]]).astype(int)))
    stretches = [np.arange(first, last) for first, last in edges.reshape(-1, 2)]
    # small currents are within the noise one by one, but not in the mean
    return [
        s
        for s in stretches
        if abs(record.current[s].mean()) <= max(least, ZERO * noise / np.sqrt(len(s)))
    ]


def find_coasts(record: Record, noise: float) -> list[Coast]:
    """Find where a turning wheel was left without current, as far as it keeps turning.

    Args:
        record: of one wheel.
        noise: standard deviation of a measured speed, rad/s.
    """
    slowest = max(TURNING * noise, 2.0 * (quantum(record.speed[record.valid]) or 0.0))
    coasts = []
    for stretch in _switched_off(record):
        # the current of a sample holds until the next one, whose speed still belongs to the coast
        stretch = np.append(stretch, stretch[-1] + 1)
        stretch = stretch[stretch < len(record.time)]
        stretch = stretch[record.valid[stretch]]
        if len(stretch) < MIN_SAMPLES:
            continue
        from scipy.ndimage import median_filter  # slow to import, and rarely needed

        # noise must not choose where the coast ends: medians over neighbours tell
        smooth = median_filter(record.speed[stretch], MIN_SAMPLES // 2, mode="nearest")
        sense = np.sign(smooth[0])
        turning = sense * smooth > max(slowest, SLOW * abs(smooth[0]))
        stretch = stretch[np.logical_and.accumulate(turning)]
        if len(stretch) < MIN_SAMPLES:
            continue
        if sense * (smooth[0] - smooth[len(stretch) - 1]) > TURNING * noise:
            time = record.time[stretch] - record.time[stretch[0]]
            coasts.append(Coast(time, sense * record.speed[stretch]))
    return coasts


def _start(coasts: Sequence[Coast]) -> Vector:
    """b/J, c/J and the initial speeds by linear regression on the integrated equation of motion."""
    rows, right = [], []
    for k, coast in enumerate(coasts):
        steps = 0.5 * (coast.speed[1:] + coast.speed[:-1]) * np.diff(coast.time)
        own = np.zeros((len(coast.time), len(coasts)))
        own[:, k] = 1.0
        rows.append(np.column_stack([-np.append(0.0, np.cumsum(steps)), -coast.time, own]))
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
    """Identify viscous and Coulomb friction from coast-downs at known inertia.

    One of the dedicated experiments that Carrara and Kuga, "Estimating friction parameters in
    reaction wheels for attitude control", compare with as deterministic methods. Every coast has
    its own initial speed; viscous and Coulomb friction are common. Nonlinear least squares on the
    closed solution, until shortly before the stop: a Stribeck curve may rise there.

    Args:
        records: of one wheel.
        inertia: kg·m².
        hold: motor_constant, N·m/A, to complete the wheel model; it is not used otherwise.
        speed_sigma: standard deviation of the measured speed, rad/s, otherwise from the residuals.

    Returns:
        The fit; `Fit.predicted` is empty, since only the coasts are modelled.

    Raises:
        InputError: no inertia, or no coast in the records.
    """
    records = as_records(records)
    check_sigma(speed_sigma)
    check_signals(records)
    held = held_values(ViscousCoulomb, inertia, hold, ("inertia", "motor_constant"))
    scale = required(held, "inertia", "a coast shows friction only as a multiple of it (kg·m²)")
    seen = max(noise_level(r.speed[r.valid]) for r in records)
    coasts = [c for r in records for c in find_coasts(r, speed_sigma or seen)]
    if not coasts:
        raise InputError(
            f"{place(records)}: found no coast, expected {MIN_SAMPLES} or more samples without "
            "current in which the wheel slows down"
        )
    start = _start(coasts)
    fitted = fit_stretches(
        [c.speed for c in coasts],
        lambda k, common, own: coasting_speed(coasts[k].time, own[0], common[0], common[1]),
        start[:2],
        list(start[2:, None]),
        speed_sigma,
        seen,
    )
    viscous, coulomb = scale * fitted.solution.x[:2]
    cure = "record longer coasts from a higher speed"
    return result(
        ViscousCoulomb,
        "coast",
        {"viscous": float(viscous), "coulomb": float(coulomb)},
        held,
        {"viscous": cure, "coulomb": cure},
        records=records,
        **fitted.outcome(scale, [0, 1], speed_sigma, seen, place(records)),
    )
