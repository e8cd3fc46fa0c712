"""Segmentation of a noisy speed signal into straight lines."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.telemetry import Record

LINE_PARAMETERS = 4
"""Parameters of one line in the Bayesian criterion: level, slope, scatter and end."""
LONGEST_SEARCH = 3000
"""Largest number of points in the search; longer records are reduced by averaging neighbours."""
ROWS = 16
"""Number of line ends whose costs are computed in one call."""
JUMP_SAMPLES = 5
"""Number of samples on either side from which a jump between two lines is computed."""
CLEAR_MOTION = 5.0
"""Standard deviations above which the rise of a line, or a jump, is certain."""


@dataclass(frozen=True)
class Line:
    """Part of a record in which the speed follows a straight line.

    Attributes:
        index: Indices of its valid samples, (m,).
        rise: Speed difference from the first to the last sample of the line, rad/s.
        scatter: Standard deviation of the speeds about the line, rad/s.
    """

    index: NDArray[np.intp]
    rise: float
    scatter: float


def _line_costs(sums: Matrix, start: int, stop: int, floor: float) -> Matrix:
    """Minus twice the log-likelihood of one line over the points first..last-1, for many of them.

    Args:
        sums: Cumulative sums of 1, t, t², w, t w and w², (6, n + 1).
        start: First index after the last point.
        stop: Index after the largest index after the last point.
        floor: Smallest scatter that is distinguished, rad/s.

    Returns:
        Costs, (stop - start, stop - 1), for every last and first, without common constants;
        undefined unless first < last.
    """
    count, t, tt, w, tw, ww = sums[:, start:stop, None] - sums[:, None, : stop - 1]
    count = np.maximum(count, 1.0)
    spread_t = tt - t * t / count
    along = tw - t * w / count
    slope_part = np.divide(along**2, spread_t, out=np.zeros_like(along), where=spread_t > 0.0)
    misfit = np.maximum(ww - w * w / count - slope_part, 0.0)
    return count * np.log(np.maximum(misfit / count, floor**2))


def _cuts(time: Vector, speed: Vector, floor: float) -> list[int]:
    """Indices that end the best straight lines, by optimal partitioning (exact).

    Jackson et al. (2005), "An algorithm for optimal partitioning of data on an interval", with the
    normal likelihood of a line of unknown scatter and the Bayesian penalty.
    """
    size = len(time)
    t, w = time - time.mean(), speed - speed.mean()
    rows = np.vstack([np.ones(size), t, t * t, w, t * w, w * w])
    sums = np.column_stack([np.zeros(6), np.cumsum(rows, axis=1)])
    penalty = LINE_PARAMETERS * np.log(size)
    best = np.zeros(size + 1)
    origin = np.zeros(size + 1, dtype=int)
    for start in range(1, size + 1, ROWS):
        stop = min(start + ROWS, size + 1)
        costs = _line_costs(sums, start, stop, floor)
        for last in range(start, stop):
            totals = best[:last] + costs[last - start, :last] + penalty
            origin[last] = int(totals.argmin())
            best[last] = totals[origin[last]]
    ends = [size]
    while ends[-1] > 0:
        ends.append(int(origin[ends[-1]]))
    return ends[-2::-1]


def straight_lines(record: Record, start: int, stop: int, floor: float) -> list[Line]:
    """Divide a part of a record into the straight lines that explain its speed best.

    Args:
        record: Record; missing speeds are skipped.
        start: Index of the first sample.
        stop: Index after the last sample.
        floor: Noise of the speed, rad/s: smaller scatter is not distinguished.
    """
    index = start + np.flatnonzero(record.valid[start:stop])
    if len(index) == 0:
        return []
    block = -(-len(index) // LONGEST_SEARCH)
    edges = np.arange(0, len(index), block)
    counts = np.diff(np.append(edges, len(index)))
    time = np.add.reduceat(record.time[index], edges) / counts
    speed = np.add.reduceat(record.speed[index], edges) / counts
    cuts = [0, *_cuts(time, speed, floor / np.sqrt(block))]
    return [_line(record, index[a * block : b * block]) for a, b in pairwise(cuts)]


def _line(record: Record, index: NDArray[np.intp]) -> Line:
    t = record.time[index] - record.time[index].mean()
    w = record.speed[index]
    slope = float(t @ w / (t @ t)) if len(index) > 1 else 0.0
    misfit = w - w.mean() - slope * t
    scatter = float(np.sqrt(misfit @ misfit / max(len(index) - 2, 1)))
    return Line(index, slope * float(t[-1] - t[0]), scatter)


def fastest_acceleration(record: Record, lines: list[Line], floor: float) -> float:
    """Largest significant acceleration of the lines of a record, rad/s²; zero if there is none.

    Args:
        record: Record of the lines.
        lines: Lines in time order.
        floor: Noise of the speed, rad/s.
    """
    accelerations = [0.0]
    for line in lines:
        if len(line.index) > 2 and abs(line.rise) > CLEAR_MOTION * max(line.scatter, floor):
            accelerations.append(abs(line.rise) / np.ptp(record.time[line.index]))
    for before, after in pairwise(lines):
        old, new = before.index[-JUMP_SAMPLES:], after.index[:JUMP_SAMPLES]
        jump = abs(record.speed[new].mean() - record.speed[old].mean())
        noise = max(before.scatter, after.scatter, floor)
        if jump > CLEAR_MOTION * noise * np.sqrt(1.0 / len(old) + 1.0 / len(new)):
            accelerations.append(jump / (record.time[new].mean() - record.time[old].mean()))
    return float(max(accelerations))
