"""Motor constant from current steps, using that friction is continuous across a step."""

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
from gyrostat.identification.read.statistics import noise_level
from gyrostat.identification.result.fit import Fit
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import NORMAL_MAD
from gyrostat.wheel.friction import ViscousCoulomb

MIN_SAMPLES = 5
"""Smallest number of speed samples on either side of a step."""
SMOOTHING = 15
"""Samples in the running mean that determines the sense of rotation."""
CLEAR = 5.0
"""Running mean, in its standard deviations, above which the sense of rotation is known."""
SMALLEST_STEP = 0.05
"""Smallest change of current that counts as a step, relative to the range of the current."""
STEADY = 0.2
"""Largest variation of the current on either side, relative to the step."""
RISE = 3
"""Largest number of samples over which the motor driver may spread a step."""


@dataclass(frozen=True)
class Step:
    """Speed around one step of current, with unchanged sense of rotation.

    Attributes:
        time: Time from the step, (m,), s.
        speed: Measured speed, (m,), rad/s.
        change: Change of the current, A.
        sense: Sense of rotation, +1 or -1.
    """

    time: Vector
    speed: Vector
    change: float
    sense: float


def _edges(current: Vector) -> list[tuple[int, int]]:
    """Edges of the current: first sample that differs from before, first sample of the new level.

    Jumps of equal sign that follow each other closely are one step, spread by the motor driver.
    """
    jump = np.diff(current)
    quiet = NORMAL_MAD * float(np.median(np.abs(jump)))
    large = max(SMALLEST_STEP * float(np.ptp(current)), 6.0 * quiet)
    edges: list[tuple[int, int]] = []
    for at in (np.flatnonzero(np.abs(jump) > large) + 1).tolist():
        spread = edges and at - edges[-1][0] < RISE and jump[at - 1] * jump[edges[-1][1] - 1] > 0.0
        if spread:
            edges[-1] = (edges[-1][0], at)
        else:
            edges.append((at, at))
    return edges


def find_steps(record: Record, noise: float) -> list[Step]:
    """Find steps between intervals of steady current, with the speeds around them.

    Samples shared by two steps are divided in the middle: no sample belongs to two steps.

    Args:
        record: Record of one wheel.
        noise: Standard deviation of a measured speed, rad/s.
    """
    edges = [(0, 0), *_edges(record.current), (len(record.time),) * 2]
    # a cut at separate noisy samples would bias those that remain: use a running mean
    speed = np.interp(record.time, record.time[record.valid], record.speed[record.valid])
    smooth = np.convolve(speed, np.full(SMOOTHING, 1.0 / SMOOTHING), mode="same")
    sense = np.where(np.abs(smooth) > CLEAR * noise, np.sign(smooth), 0.0)
    steps: list[tuple[float, float, float, NDArray[np.intp]]] = []
    for (_, before), (first, at), (after, _) in zip(edges, edges[1:], edges[2:], strict=False):
        sides = [np.arange(before, first), np.arange(at, after)]
        levels = [float(np.mean(record.current[side])) for side in sides]
        change = levels[1] - levels[0]
        swing = max(float(np.ptp(record.current[side])) for side in sides)
        near = [side[record.valid[side]] for side in sides]
        if change == 0.0 or swing > STEADY * abs(change) or min(map(len, near)) < MIN_SAMPLES:
            continue
        direction = np.sign(np.median(speed[near[0][-MIN_SAMPLES:]]))
        # a mean is trusted only if its neighbours' means have the same sense too
        unclear = np.convolve(sense != direction, np.ones(SMOOTHING), mode="same") > 0.5
        masks = [~unclear[side] for side in near]
        index: NDArray[np.intp] = np.concatenate(
            [
                near[0][np.logical_and.accumulate(masks[0][::-1])[::-1]],
                near[1][np.logical_and.accumulate(masks[1])],
            ]
        )
        if min(int(np.sum(index < at)), int(np.sum(index >= at))) < MIN_SAMPLES:
            continue
        if steps and steps[-1][-1][-1] >= index[0]:
            middle = (steps[-1][-1][-1] + index[0]) // 2
            steps[-1] = (*steps[-1][:-1], steps[-1][-1][steps[-1][-1] < middle])
            index = index[index >= middle]
        # a spread step acts like an immediate one at the time that gives the same impulse
        part = (record.current[first:at] - levels[0]) / change
        moment = float(record.time[at]) - float(part @ np.diff(record.time[first : at + 1]))
        steps.append((moment, change, float(direction), index))
    return [
        Step(record.time[index] - moment, record.speed[index], change, direction)
        for moment, change, direction, index in steps
    ]


def _start(steps: Sequence[Step]) -> tuple[float, list[Vector]]:
    """Ratio k_m/J, and speed and acceleration at each step, from straight lines on both sides."""
    first = []
    for step in steps:
        kick = step.change * np.maximum(step.time, 0.0)
        rows = np.column_stack([kick, np.ones(len(kick)), step.time])
        first.append(np.linalg.lstsq(rows, step.speed, rcond=None)[0])
    return float(np.median([fit[0] for fit in first])), [fit[1:] for fit in first]


def identify_torque_step(
    records: Record | Sequence[Record],
    *,
    inertia: float | None,
    hold: Mapping[str, float | None] | None = None,
    speed_sigma: float | None = None,
) -> Fit:
    """Identify the motor constant from steps of current, with known inertia.

    J (dw/dt after - dw/dt before) = k_m (I after - I before), because friction depends on speed and
    speed does not jump. One of the bench experiments that Carrara and Kuga, "Estimating friction
    parameters in reaction wheels for attitude control", call deterministic methods. Each step has
    its own speed and acceleration. The curvature that viscous friction causes on both sides is
    common to all steps of one sense of rotation and is estimated with them, so that long intervals
    can be used.

    Args:
        records: Records of one wheel.
        inertia: Rotor inertia, kg·m².
        hold: May only repeat the inertia.
        speed_sigma: Standard deviation of the measured speed, rad/s; by default from the residuals.

    Returns:
        The fit, with the motor constant only, without friction.

    Raises:
        InputError: No inertia is given, or the records contain no step of current with unchanged
            sense of rotation.
    """
    records = as_records(records)
    check_sigma(speed_sigma)
    check_signals(records)
    held = held_values(ViscousCoulomb, inertia, hold, ("inertia",))
    scale = require_held(
        held, "inertia", "a step shows the motor constant only as a multiple (kg·m²)"
    )
    noise = max(noise_level(r.speed[r.valid]) for r in records)
    steps = [s for r in records for s in find_steps(r, speed_sigma or noise)]
    if not steps:
        raise InputError(
            f"{place(records)}: found no step of current, expected one with {MIN_SAMPLES} or more "
            "speeds of the same sense on either side and a steady current there"
        )
    senses = sorted({step.sense for step in steps})
    motor, separate = _start(steps)

    def model(k: int, common: Vector, separate: Vector) -> tuple[Vector, Matrix]:
        step = steps[k]
        viscous = 1 + senses.index(step.sense)
        decay_integral, bend = relaxed_time(step.time, float(common[viscous]))
        kick = step.change * (step.time >= 0.0)
        rate = separate[1] + common[0] * kick
        slopes = np.zeros((len(decay_integral), len(common) + 2))
        slopes[:, 0] = kick * decay_integral
        slopes[:, viscous] = rate * bend
        slopes[:, -2:] = np.column_stack([np.ones_like(decay_integral), decay_integral])
        return separate[0] + rate * decay_integral, slopes

    (estimate,), outcome = fit_stretches(
        [step.speed for step in steps],
        model,
        np.array([motor, *[0.0] * len(senses)]),
        separate,
        records=records,
        speed_sigma=speed_sigma,
        noise=noise,
        scale=scale,
        count=1,
    )
    return result(
        ViscousCoulomb,
        "torque-step",
        {"motor_constant": float(estimate)},
        held,
        {"motor_constant": "record more and larger steps of current at speed"},
        **outcome,
    )
