"""Confidence intervals of shares of runs, and of shares of time and runs together.

Runs are independent of each other, the samples of a run are not. Every interval therefore comes
from the spread over runs, whatever the number of samples.
"""

from collections.abc import Callable
from math import ceil, exp, log
from typing import cast

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.summary import CONFIDENCE
from gyrostat.core.types import Vector

_TAIL = 0.5 * (1.0 - CONFIDENCE)


def least_runs(level: float) -> int:
    """Number of runs that can show a level: all of them within it give that lower bound.

    The probability that n of n runs are within a bound of true level p is p^n; n is the least with
    p^n <= 2.5 %, the lower tail of an interval of 95 %.
    """
    return ceil(log(_TAIL) / log(level))


def mean_bounds(mean: float, count: int) -> tuple[float, float]:
    """Confidence interval of the expectation of independent values in [0, 1], 95 %.

    W. Hoeffding, "Probability inequalities for sums of bounded random variables", 1963, theorem 1,
    inverted: the expectations whose relative entropy to the mean is at most ln(2 / 5 %) / n. It
    holds for any distribution and any number of values, such as a share of time in each run.

    Args:
        mean: Mean of the values.
        count: Number of values.
    """
    most = -log(_TAIL) / count

    def beyond(share: float) -> float:
        return _entropy(mean, share) - most

    low = exp(-most) if mean == 1.0 else 0.0
    high = 1.0 - exp(-most) if mean == 0.0 else 1.0
    edge = 1e-300
    if 0.0 < mean < 1.0:
        low = _root(beyond, edge, mean) if beyond(edge) > 0.0 else 0.0
        top = float(np.nextafter(1.0, 0.0))
        high = _root(beyond, mean, top) if beyond(top) > 0.0 else 1.0
    return low, high


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq  # slow to import

    return float(cast(float, brentq(function, low, high, xtol=1e-15)))


def _entropy(mean: float, share: float) -> float:
    """Relative entropy of two binary distributions."""
    entropy = mean * log(mean / share) if mean > 0.0 else 0.0
    return entropy + ((1.0 - mean) * log((1.0 - mean) / (1.0 - share)) if mean < 1.0 else 0.0)


def size_at(level: float, shares: Vector, sizes: Vector) -> float:
    """Size at which a rising share reaches a level; NaN above the largest size.

    Between two sizes, the share is interpolated over the logarithm of the size. The smallest size
    is returned where the share of it is sufficient.

    Args:
        level: Level.
        shares: Shares of the values that are not above each size, (sizes,).
        sizes: Sizes, rising, (sizes,).
    """
    last = _reached(level, shares)
    if last is None:
        return float("nan")
    if last == 0:
        return float(sizes[0])
    part = (level - shares[last - 1]) / (shares[last] - shares[last - 1])
    return float(sizes[last - 1] * (sizes[last] / sizes[last - 1]) ** part)


def sizes_around(level: float, shares: Vector, sizes: Vector) -> tuple[float, float]:
    """Neighbouring sizes between which a rising share reaches a level; NaN above the largest size.

    Args:
        level: Level.
        shares: Shares of the values that are not above each size, (sizes,).
        sizes: Sizes, rising, (sizes,).
    """
    last = _reached(level, shares)
    if last is None:
        return float("nan"), float("nan")
    return (float(sizes[last - 1]) if last > 0 else 0.0), float(sizes[last])


def _reached(level: float, shares: Vector) -> int | None:
    """Index of the first share that is at least the level; None without one."""
    reached: NDArray[np.bool_] = shares >= level
    return int(np.argmax(reached)) if reached.any() else None
