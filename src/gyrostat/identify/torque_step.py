"""Motor constant from steps of current: across a step the friction is the same on both sides."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat._types import Matrix, Vector
from gyrostat.errors import InputError
from gyrostat.friction import ViscousCoulomb
from gyrostat.identify.checks import check_signals
from gyrostat.identify.dedicated import (
    as_records,
    check_sigma,
    held_values,
    place,
    relaxed_time,
    required,
    result,
    serial_sigma,
)
from gyrostat.identify.fit import Fit
from gyrostat.identify.least_squares import Prior, minimise
from gyrostat.identify.loss import Quadratic
from gyrostat.identify.statistics import NORMAL_MAD, noise_level, whiteness
from gyrostat.telemetry import Record

MIN_SAMPLES = 5
"""Fewest speeds on either side of a step."""
SMOOTHING = 15
"""Speeds in the running mean that tells the sense of rotation."""
CLEAR = 5.0
"""Standard deviations by which a speed must differ from zero to have a sense of rotation."""
SMALLEST_STEP = 0.05
"""Share of the range of the current below which a change is not taken for a step."""
STEADY = 0.2
"""Share of a step by which the current may vary on either side of it."""

FINEST = 1e-9
"""Smallest level of the whitened residuals."""


@dataclass(frozen=True)
class Step:
    """The surroundings of one step of current, the sense of rotation unchanged.

    Attributes:
        time: (m,) s from the step.
        speed: (m,) measured, rad/s.
        change: of the current, A.
    """

    time: Vector
    speed: Vector
    change: float


def find_steps(record: Record, noise: float) -> list[Step]:
    """Find steps of a current that is otherwise steady, with the speeds around them.

    No speed belongs to two steps: what two of them share is divided in its middle.

    Args:
        record: of one wheel.
        noise: standard deviation of a measured speed, rad/s.
    """
    jump = np.diff(record.current)
    quiet = NORMAL_MAD * float(np.median(np.abs(jump)))
    large = max(SMALLEST_STEP * float(np.ptp(record.current)), 6.0 * quiet)
    edges = [0, *(np.flatnonzero(np.abs(jump) > large) + 1), len(record.time)]
    # cut by single noisy speeds, the last ones kept would all err one way: a running mean tells
    speed = np.interp(record.time, record.time[record.valid], record.speed[record.valid])
    smooth = np.convolve(speed, np.full(SMOOTHING, 1.0 / SMOOTHING), mode="same")
    sense = np.where(np.abs(smooth) > CLEAR * noise, np.sign(smooth), 0.0)
    found: list[tuple[int, float, NDArray[np.intp]]] = []
    for before, at, after in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
        sides = [np.arange(before, at), np.arange(at, after)]
        levels = [float(np.mean(record.current[side])) for side in sides]
        change = levels[1] - levels[0]
        swing = max(float(np.ptp(record.current[side])) for side in sides)
        near = [side[record.valid[side]] for side in sides]
        if change == 0.0 or swing > STEADY * abs(change) or min(map(len, near)) < MIN_SAMPLES:
            continue
        turning = np.sign(np.median(speed[near[0][-MIN_SAMPLES:]]))
        # a mean is only clear of a change of sense where its neighbours' means are
        unclear = np.convolve(sense != turning, np.ones(SMOOTHING), mode="same") > 0.5
        same = [~unclear[side] for side in near]
        kept = np.concatenate(
            [
                near[0][np.logical_and.accumulate(same[0][::-1])[::-1]],
                near[1][np.logical_and.accumulate(same[1])],
            ]
        )
        if min(int(np.sum(kept < at)), int(np.sum(kept >= at))) < MIN_SAMPLES:
            continue
        if found and found[-1][2][-1] >= kept[0]:
            middle = (found[-1][2][-1] + kept[0]) // 2
            found[-1] = (*found[-1][:2], found[-1][2][found[-1][2] < middle])
            kept = kept[kept >= middle]
        found.append((at, change, kept))
    return [
        Step(record.time[kept] - record.time[at], record.speed[kept], change)
        for at, change, kept in found
    ]


def identify_torque_step(
    records: Record | Sequence[Record],
    *,
    inertia: float | None,
    hold: Mapping[str, float | None] | None = None,
    speed_sigma: float | None = None,
) -> Fit:
    """Identify the motor constant from steps of current at known inertia.

    J (dw/dt after - dw/dt before) = k_m (I after - I before), since friction depends on the speed,
    which does not jump. One of the dedicated experiments that Carrara and Kuga, "Estimating
    friction parameters in reaction wheels for attitude control", compare with as deterministic
    methods. Each step has its own speed and acceleration; the bend that viscous friction puts into
    the speed on both sides is common and estimated with them, so that long stretches may be used.

    Args:
        records: of one wheel.
        inertia: kg·m².
        hold: may only repeat the inertia.
        speed_sigma: standard deviation of the measured speed, rad/s, otherwise from the residuals.

    Returns:
        The fit: the motor constant alone, no friction.

    Raises:
        InputError: no inertia, or no step of current in the records across which the wheel keeps
            its sense of rotation.
    """
    records = as_records(records)
    check_sigma(speed_sigma)
    check_signals(records)
    held = held_values(ViscousCoulomb, inertia, hold, ("inertia",))
    scale = required(held, "inertia", "a step shows the motor constant only as a multiple (kg·m²)")
    seen = max(noise_level(r.speed[r.valid]) for r in records)
    steps = [s for r in records for s in find_steps(r, speed_sigma or seen)]
    if not steps:
        raise InputError(
            f"{place(records)}: found no step of current, expected one with {MIN_SAMPLES} or more "
            "speeds of the same sense on either side and a steady current there"
        )
    sigma = speed_sigma or max(seen, 1e-6 * max(float(np.max(np.abs(s.speed))) for s in steps))

    def evaluate(x: Vector) -> tuple[Vector, Matrix]:
        residuals, rows = [], []
        for k, step in enumerate(steps):
            place_of = [0, 1, 2 + 2 * k, 3 + 2 * k]
            relaxed, bend = relaxed_time(step.time, float(x[0]))
            kick = step.change * (step.time >= 0.0)
            rate = x[3 + 2 * k] + x[1] * kick
            block = np.zeros((len(step.time), len(x)))
            block[:, place_of] = np.column_stack(
                [rate * bend, kick * relaxed, np.ones_like(relaxed), relaxed]
            )
            residuals.append((step.speed - x[2 + 2 * k] - rate * relaxed) / sigma)
            rows.append(block / sigma)
        return np.concatenate(residuals), np.vstack(rows)

    start = np.zeros(2 + 2 * len(steps))
    unknown = Prior(np.zeros(len(start)), np.full(len(start), np.inf))
    # without viscous friction the problem is linear: its solution is where the bend starts
    residual, rows = evaluate(start)
    start[1:] = np.linalg.lstsq(rows[:, 1:], residual, rcond=None)[0]
    solution = minimise(evaluate, start, unknown, Quadratic())
    assert solution is not None  # every start is admissible here
    freedom = max(len(solution.residual) - len(start), 1)
    spread = 1.0
    if speed_sigma is None:
        spread = max(float(np.sqrt(solution.residual @ solution.residual / freedom)), FINEST)
    return result(
        ViscousCoulomb,
        "torque-step",
        {"motor_constant": scale * float(solution.x[1])},
        (scale * spread) ** 2 * solution.covariance()[1:2, 1:2],
        held,
        {"motor_constant": "record more and larger steps of current at speed"},
        serial_sigma=scale * serial_sigma(solution, [len(s.time) for s in steps])[1:2],
        converged=solution.converged,
        iterations=solution.iterations,
        samples=len(solution.residual),
        speed_sigma=speed_sigma or spread * sigma,
        records=records,
        predicted=(),
        predicted_sigma=(),
        whiteness=whiteness(solution.residual),
    )
