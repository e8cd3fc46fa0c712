"""What many runs say: percentiles with their confidence, and what drives each metric."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, spearmanr

from gyrostat._types import Matrix, Vector

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
    true percentile is binomial.

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
        float(ordered[max(int(np.ceil(share * count)), 1) - 1]),
        float(ordered[first - 1]) if first >= 1 else np.nan,
        float(ordered[last - 1]) if last <= count else np.nan,
    )


def rank_correlation(drawn: Matrix, metric: Vector) -> Vector:
    """Spearman's rank correlation of each drawn value with a metric, (keys,).

    Args:
        drawn: (runs, keys).
        metric: (runs,), NaN where a run has none.

    Returns:
        NaN for all where fewer than three runs have the metric or it is the same in all.
    """
    fine = np.isfinite(metric)
    found = np.full(drawn.shape[1], np.nan)
    if np.sum(fine) < 3 or np.ptp(metric[fine]) == 0.0:
        return found
    for k, values in enumerate(drawn.T):
        if np.ptp(values[fine]) > 0.0:
            found[k] = spearmanr(values[fine], metric[fine])[0]
    return found


def chance_level(runs: int) -> float:
    """Rank correlation that independent values exceed by chance in one case of twenty."""
    return 1.96 / np.sqrt(max(runs - 1, 1))
