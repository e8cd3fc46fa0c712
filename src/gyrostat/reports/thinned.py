"""Curves with fewer points."""

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector


def thinned(x: Vector, y: Vector, most: int) -> tuple[Vector, Vector]:
    """A curve with a largest number of points, and the same smallest and largest values.

    Of each interval its first points with the smallest and the largest value are kept, in order.
    """
    if len(x) <= most:
        return x, y
    count = most // 2
    size, longer = divmod(len(x), count)
    edge = longer * (size + 1)
    # the first intervals have one point more
    indices = [*_extremes(y[:edge], size + 1), *(edge + each for each in _extremes(y[edge:], size))]
    places = np.unique(np.concatenate(indices))
    return x[places], y[places]


def _extremes(y: Vector, size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Places of the first smallest and the first largest finite value of each interval.

    Args:
        y: Values of all intervals, one after the other.
        size: Number of values in an interval. Intervals without a finite value are left out.
    """
    rows = y.reshape(-1, size)
    fine = np.isfinite(rows)
    start, has_values = size * np.arange(len(rows)), fine.any(axis=1)
    least = start + np.argmin(np.where(fine, rows, np.inf), axis=1)
    largest = start + np.argmax(np.where(fine, rows, -np.inf), axis=1)
    return least[has_values], largest[has_values]
