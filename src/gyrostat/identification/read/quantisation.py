"""Find the step to which a signal was rounded, and what the rounding left unknown."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.telemetry import Record

SAME = 0.01
"""Distance from a multiple of the step, in steps, below which a value is one."""
FINEST = 2e-5
"""Smallest step that is sought, relative to the range of a signal: a finer one has no effect."""
EXACT = (1e-14, 1e-7)
"""Errors of a value by the format of its number, double and single, relative to the range."""
FEWEST_LEVELS, FEWEST_STEPS = 4, 20
"""Smallest number of distinct values with zero, and smallest range in steps, of a signal whose
rounding is recognised. A few round set points, such as 60 and 150 mA, have a common step too."""
HELD = 4
"""Smallest number of intervals at one value for which a current counts as held."""
MOST_LEVELS = 48
"""Largest number of held values with an error of their own, those held longest."""


def rounding_step(values: Vector) -> float | None:
    """Largest step of which all values of a signal are multiples.

    Args:
        values: Samples, (m,), in any unit.

    Returns:
        The step in the same unit; None if the samples were not rounded, or to so fine or so coarse
        a step that it cannot be told.
    """
    levels = np.unique(np.append(values, 0.0))
    if len(levels) < FEWEST_LEVELS:
        return None
    extent = float(levels[-1] - levels[0])
    levels = (levels - levels[0]) / extent
    for error in EXACT:
        step = _common_step(np.unique(np.diff(levels)), error)
        # the whole range is free of the rounding errors of the gap that gave the step
        count = round(1.0 / step) if step else 0
        apart = count * levels
        if count >= FEWEST_STEPS and np.max(np.abs(apart - np.round(apart))) < SAME:
            return extent / count
    return None


def _common_step(gaps: Vector, error: float) -> float:
    """Greatest common divisor by Euclid's algorithm, 0 for none; values relative to the range.

    Args:
        gaps: Distinct differences of neighbouring values, (k,).
        error: Error of a value. The quotients amplify it to error / divisor.
    """
    step = 0.0
    for gap in gaps[gaps > error].tolist():
        a, b = gap, step
        while b > error / a:
            a, b = b, abs(a - b * round(a / b))
            if a < max(FINEST, error / (SAME * a)):
                return 0.0
        # a large multiple of the step has the smallest relative error
        step = gap / round(gap / a)
    return step


def _runs(levels: Vector) -> list[tuple[int, int]]:
    """Start and end (exclusive) of each run of equal values."""
    edges = np.flatnonzero(np.diff(levels) != 0.0) + 1
    bounds = [0, *edges.tolist(), len(levels)]
    return list(pairwise(bounds))


def _passed(levels: Vector, first: int, last: int) -> bool:
    """Whether a signal comes from one neighbouring level and leaves to the other."""
    if first == 0 or last == len(levels):
        return False
    before, after = levels[first] - levels[first - 1], levels[last] - levels[last - 1]
    return bool(abs(before) == 1.0 and before == after)


def held_levels(
    records: Sequence[Record], step: float
) -> tuple[list[NDArray[np.int_]], list[Vector], int]:
    """Which error of rounding acts in each sample interval.

    A current that is held at one value has one unknown error, which is the same whenever the value
    is held again. A current that passes a value, or that changes from sample to sample, has errors
    with zero mean.

    Args:
        records: Records of one drive.
        step: Step of the current, A.

    Returns:
        For each record the number of the held value in each interval, -1 elsewhere, (N - 1,); for
        each record the number of samples whose error is common, beside those, (N - 1,); and the
        number of held values.
    """
    lengths: dict[float, int] = {}
    levels = [np.round(record.current / step) for record in records]
    every = [
        [run for run in _runs(each[:-1]) if run[1] - run[0] >= HELD and not _passed(each, *run)]
        for each in levels
    ]
    for each, held in zip(levels, every, strict=True):
        for first, last in held:
            lengths[each[first]] = lengths.get(each[first], 0) + last - first
    order = sorted(lengths, key=lambda level: -lengths[level])[:MOST_LEVELS]
    number = {level: k for k, level in enumerate(order)}
    numbers, common = [], []
    for each, held in zip(levels, every, strict=True):
        index, size = np.full(len(each) - 1, -1), np.ones(len(each) - 1)
        for first, last in held:
            index[first:last] = number.get(each[first], -1)
            size[first:last] = last - first
        numbers.append(index)
        common.append(np.where(index < 0, size, 0.0))
    return numbers, common, len(order)


def repetitions(record: Record, step: float) -> Vector:
    """Number of samples of a rounded speed that share one error, (N,); 1 where it is passed.

    Args:
        record: Record of the speed.
        step: Step of the speed, rad/s.
    """
    size = np.ones(len(record.time))
    index = np.flatnonzero(record.valid)
    levels = np.round(record.speed[index] / step)
    for first, last in _runs(levels):
        if not _passed(levels, first, last):
            size[index[first:last]] = last - first
    return size
