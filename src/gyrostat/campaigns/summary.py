"""Statistics over runs: percentiles with confidence intervals, and drivers of each metric."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from gyrostat.campaigns.percentiles import rank
from gyrostat.core.types import Vector

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Percentile:
    """A percentile of a metric over the runs, and where it lies with 95 % confidence.

    Attributes:
        percent: of the runs below it.
        value: of the sample; NaN where there is none.
        low: end of the interval; NaN where so few runs do not bound it.
        high: the other end.
    """

    percent: float
    value: float
    low: float
    high: float


def percentile_of(values: Vector, percent: float) -> Percentile:
    """A percentile by order statistics, which assume no distribution.

    H. A. David and H. N. Nagaraja, "Order Statistics", section 7.1: the number of runs below the
    true percentile is binomial. The value is that of the rank definition, see `rank`.

    Args:
        values: (runs,) of a metric, NaN where a run has none.
        percent: between 0 and 100.
    """
    ordered = np.sort(values[np.isfinite(values)])
    count, share = len(ordered), percent / 100.0
    if count == 0:
        return Percentile(percent, np.nan, np.nan, np.nan)
    tail = 0.5 * (1.0 - CONFIDENCE)
    first = int(binom.ppf(tail, count, share))
    last = int(binom.ppf(1.0 - tail, count, share)) + 1
    return Percentile(
        percent,
        float(ordered[rank(percent, count) - 1]),
        float(ordered[first - 1]) if first >= 1 else np.nan,
        float(ordered[last - 1]) if last <= count else np.nan,
    )
