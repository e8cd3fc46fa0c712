"""Statistics over runs: percentiles with confidence intervals."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.runs.metrics.percentiles import rank

CONFIDENCE = 0.95


class Estimate(NamedTuple):
    """Estimate with the ends of its 95 % confidence interval.

    Attributes:
        value: Estimate; NaN without values.
        low: Lower end of the interval; NaN if there are too few runs for a bound.
        high: Upper end of the interval; NaN if there are too few runs for a bound.
    """

    value: float
    low: float
    high: float


def percentile_of(values: Vector, percent: float) -> Estimate:
    """Percentile with a confidence interval; see `percentiles_of`."""
    return percentiles_of(values, (percent,))[0]


def percentiles_of(values: Vector, percents: Sequence[float]) -> list[Estimate]:
    """Percentiles, each with a confidence interval by order statistics; no distribution is assumed.

    H. A. David and H. N. Nagaraja, "Order Statistics", section 7.1: the number of runs below the
    true percentile has a binomial distribution. The value is by the rank definition, see `rank`.

    Args:
        values: Values of a metric, (runs,), NaN for missing ones.
        percents: Percentages, between 0 and 100.
    """
    ordered = values[np.isfinite(values)]
    ordered.sort()
    return [_of_ordered(ordered, percent) for percent in percents]


def _of_ordered(ordered: Vector, percent: float) -> Estimate:
    """Percentile of values in rising order."""
    count, share = len(ordered), percent / 100.0
    if count == 0:
        return Estimate(np.nan, np.nan, np.nan)
    tail = 0.5 * (1.0 - CONFIDENCE)
    first = _binomial_quantile(tail, count, share)
    last = _binomial_quantile(1.0 - tail, count, share) + 1
    return Estimate(
        float(ordered[rank(percent, count) - 1]),
        float(ordered[first - 1]) if first >= 1 else np.nan,
        float(ordered[last - 1]) if last <= count else np.nan,
    )


def share_bounds(inside: int, count: int) -> tuple[float, float]:
    """95 % confidence interval of a share of the runs, by C. J. Clopper and E. S. Pearson, 1934.

    Args:
        inside: Number of runs that count.
        count: Number of runs.
    """
    from scipy.special import betaincinv  # slow to import

    tail = 0.5 * (1.0 - CONFIDENCE)
    low = betaincinv(inside, count - inside + 1, tail) if inside > 0 else 0.0
    high = betaincinv(inside + 1, count - inside, 1.0 - tail) if inside < count else 1.0
    return float(low), float(high)


def _binomial_quantile(level: float, count: int, share: float) -> int:
    """Smallest number of successes whose cumulative probability is at least `level`."""
    from scipy.special import bdtr, bdtrik  # slow to import

    most = int(np.ceil(bdtrik(level, count, share)))
    # the inverse of the continuous function may be rounded up
    return most - 1 if most > 0 and bdtr(most - 1.0, count, share) >= level else most
