"""Motion of a drive over the sample intervals of a record: measured, or predicted."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from gyrostat.core.types import Vector
from gyrostat.telemetry import Record

FEWEST = 8
"""Smallest number of speeds of a segment."""
LOST, UNEVEN = 1.5, 0.1
"""Interval with a lost row, in usual ones; share of such intervals above which they are usual."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion over n successive sample intervals.

    Attributes:
        mean_speed: Mean speed of each interval, (n,), rad/s.
        speed: Speed at the samples, (n + 1,), rad/s, whose sign is that of the friction.
    """

    mean_speed: Vector
    speed: Vector


@dataclass(frozen=True, eq=False)
class Drive:
    """Part of a record without gaps.

    Attributes:
        time: Sample times, (n + 1,), s.
        current: Mean current of each interval, (n,), A.
        measured: Measured motion; its speed is smoothed over `smoothing` samples.
        reference: Mean commanded speed of each interval, (n,), rad/s.
        present: Whether the speed of the interval was measured, (n,).
        differenced: Whether the speed is a difference of the angle, also in the control law.
    """

    time: Vector
    current: Vector
    measured: Motion
    reference: Vector
    present: NDArray[np.bool_]
    differenced: bool

    @property
    def interval(self) -> float:
        """Median sample interval, s."""
        return float(np.median(np.diff(self.time)))


def smoothed(mean_speed: Vector, samples: int) -> Vector:
    """Speed at the samples from the mean speeds of the intervals between them, (n + 1,), rad/s.

    A parabola through the next intervals (Savitzky and Golay 1964), which keeps a constant
    acceleration.

    Args:
        mean_speed: Mean speeds, (n,), rad/s.
        samples: Intervals of the parabola.
    """
    inner = 0.5 * (mean_speed[1:] + mean_speed[:-1])
    nodes = np.concatenate([mean_speed[:1], inner, mean_speed[-1:]])
    length = min(2 * (samples // 2) + 1, 2 * ((len(nodes) - 1) // 2) + 1)
    return np.asarray(savgol_filter(nodes, length, 2)) if length >= 5 else nodes


def commanded_speed(record: Record, part: slice) -> Vector | None:
    """Mean commanded speed of the intervals of a segment, (n,), rad/s; None without a reference."""
    if record.reference is not None:
        return np.diff(record.reference[part]) / np.diff(record.time[part])
    return None if record.setpoint is None else record.setpoint[part][:-1]


def _cut_at_lost_rows(record: Record) -> Record:
    """Record that restarts after every longer interval: in a closed loop, the current changes.

    A record of uneven times has no lost rows.
    """
    steps = np.diff(record.time)
    longer = np.append(False, steps > LOST * np.median(steps))
    if np.mean(longer[1:]) > UNEVEN:
        return record
    before = False if record.restart is None else record.restart
    return replace(record, restart=longer | before)


def drives(record: Record, hold: str) -> list[Drive]:
    """Segments of a record; without a reference, the commanded speed is zero.

    Args:
        record: Record.
        hold: Current between samples, "zero-order" or "linear".
    """
    parts = []
    for part in _cut_at_lost_rows(record).segments:
        time, current, valid = record.time[part], record.current[part], record.valid[part]
        reference = commanded_speed(record, part)
        if valid.sum() < FEWEST:
            continue
        reference = np.zeros(len(time) - 1) if reference is None else reference
        speed = np.interp(time, time[valid], record.speed[part][valid])
        if record.averaged:
            mean_speed, present = speed[1:], valid[1:]
        else:
            mean_speed, present = 0.5 * (speed[1:] + speed[:-1]), valid[1:] & valid[:-1]
        means = current[:-1] if hold == "zero-order" else 0.5 * (current[1:] + current[:-1])
        motion = Motion(mean_speed, smoothed(mean_speed, 1))
        parts.append(Drive(time, means, motion, reference, present, record.averaged))
    return parts
