"""Motor constant from current steps, across which friction is continuous."""

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
from gyrostat.identification.statistics import NORMAL_MAD, noise_level
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import ViscousCoulomb

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
RISE = 3
"""Samples over which a drive may spread a step of current."""


@dataclass(frozen=True)
class Step:
    """The surroundings of one step of current, the sense of rotation unchanged.

    Attributes:
        time: (m,) s from the step.
        speed: (m,) measured, rad/s.
        change: of the current, A.
        sense: of rotation, +1 or -1.
    """

    time: Vector
    speed: Vector
    change: float
    sense: float


def _edges(current: Vector) -> list[tuple[int, int]]:
    """Steps of a current: first sample that differs from before, and first that is as after.

    Jumps of one sign that follow each other closely are one step, which a drive has spread.
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
    """Find steps of a current that is otherwise steady, with the speeds around them.

    No speed belongs to two steps: what two of them share is divided in its middle.

    Args:
        record: of one wheel.
        noise: standard deviation of a measured speed, rad/s.
    """
    edges = [(0, 0), *_edges(record.current), (len(record.time),) * 2]
    # cut by single noisy speeds, the last ones kept would all err one way: a running mean tells
    speed = np.interp(record.time, record.time[record.valid], record.speed[record.valid])
    smooth = np.convolve(speed, np.full(SMOOTHING, 1.0 / SMOOTHING), mode="same")
    sense = np.where(np.abs(smooth) > CLEAR * noise, np.sign(smooth), 0.0)
    found: list[tuple[float, float, float, NDArray[np.intp]]] = []
    for (_, before), (first, at), (after, _) in zip(edges, edges[1:], edges[2:], strict=False):
        sides = [np.arange(before, first), np.arange(at, after)]
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
        kept: NDArray[np.intp] = np.concatenate(
            [
                near[0][np.logical_and.accumulate(same[0][::-1])[::-1]],
                near[1][np.logical_and.accumulate(same[1])],
            ]
        )
        if min(int(np.sum(kept < at)), int(np.sum(kept >= at))) < MIN_SAMPLES:
            continue
        if found and found[-1][-1][-1] >= kept[0]:
            middle = (found[-1][-1][-1] + kept[0]) // 2
            found[-1] = (*found[-1][:-1], found[-1][-1][found[-1][-1] < middle])
            kept = kept[kept >= middle]
        # a step that is spread acts like one at once at the time that gives the same impulse
        part = (record.current[first:at] - levels[0]) / change
        moment = float(record.time[at]) - float(part @ np.diff(record.time[first : at + 1]))
        found.append((moment, change, float(turning), kept))
    return [
        Step(record.time[kept] - moment, record.speed[kept], change, turning)
        for moment, change, turning, kept in found
    ]


def _start(steps: Sequence[Step]) -> tuple[float, list[Vector]]:
    """k_m/J, and speed and acceleration at each step, as straight lines on both sides give them."""
    first = []
    for step in steps:
        kick = step.change * np.maximum(step.time, 0.0)
        rows = np.column_stack([kick, np.ones(len(kick)), step.time])
        first.append(np.linalg.lstsq(rows, step.speed, rcond=None)[0])
    return float(np.median([own[0] for own in first])), [own[1:] for own in first]


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
    the speed on both sides is common to all steps of one sense of rotation and estimated with them,
    so that long stretches may be used.

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
    senses = sorted({step.sense for step in steps})
    motor, own = _start(steps)

    def model(k: int, common: Vector, own: Vector) -> tuple[Vector, Matrix]:
        step = steps[k]
        viscous = 1 + senses.index(step.sense)
        relaxed, bend = relaxed_time(step.time, float(common[viscous]))
        kick = step.change * (step.time >= 0.0)
        rate = own[1] + common[0] * kick
        slopes = np.zeros((len(relaxed), len(common) + 2))
        slopes[:, 0] = kick * relaxed
        slopes[:, viscous] = rate * bend
        slopes[:, -2:] = np.column_stack([np.ones_like(relaxed), relaxed])
        return own[0] + rate * relaxed, slopes

    fitted = fit_stretches(
        [step.speed for step in steps],
        model,
        np.array([motor, *[0.0] * len(senses)]),
        own,
        speed_sigma,
        seen,
    )
    return result(
        ViscousCoulomb,
        "torque-step",
        {"motor_constant": scale * float(fitted.solution.x[0])},
        held,
        {"motor_constant": "record more and larger steps of current at speed"},
        records=records,
        **fitted.outcome(scale, [0], speed_sigma, seen, place(records)),
    )
