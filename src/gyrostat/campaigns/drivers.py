"""What drives each metric: rank correlations, and the level that chance alone would exceed.

A report tests every drawn key against every metric, a few hundred pairs. The chance level holds for
all of them together: where no key has any influence, one campaign in twenty names a driver at all.
It comes from permutations of the runs (P. H. Westfall and S. S. Young, "Resampling-based multiple
testing", 1993, single-step maxT), which keep the dependence among keys and among metrics, ties, and
the runs that lack a metric; no distribution is assumed.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from gyrostat.core.types import Matrix, Vector

LEVEL = 0.05
"""Probability that a campaign without any driver names one."""
PERMUTATIONS = 999
MOST_RUNS = 2000
"""Runs that are permuted, chosen at random from more: the level in standard units is the same."""
_AT_ONCE = 4_000_000
"""Numbers in memory at a time."""


class Drivers(NamedTuple):
    """Rank correlations of a campaign.

    Attributes:
        rank_correlation: (keys, metrics) Spearman's, over the runs that have the metric; NaN for
            values or metrics that are the same in all, and below three runs.
        chance_level: (metrics,) Size that a rank correlation must exceed to name a driver, at most
            1; NaN where a metric has no rank correlation.
    """

    rank_correlation: Matrix
    chance_level: Vector

    def named(self) -> NDArray[np.bool_]:
        """(keys, metrics) Whether a key is named as a driver of a metric."""
        return np.abs(self.rank_correlation) > self.chance_level


class _Group(NamedTuple):
    """Metrics that the same runs have.

    Attributes:
        columns: Their numbers.
        has: (runs,) Whether a run has them.
        keys: (runs that have them, keys) Ranks, centred, of unit length; 0 where all are equal.
        metrics: (runs that have them, columns) The same of the metrics.
    """

    columns: list[int]
    has: NDArray[np.bool_]
    keys: Matrix
    metrics: Matrix


def find_drivers(drawn: Matrix, metrics: Matrix) -> Drivers:
    """Rank correlation of every key with every metric, and what chance makes of so many.

    Args:
        drawn: (runs, keys) Drawn values.
        metrics: (runs, metrics) Values of the metrics, NaN where a run has none.
    """
    rho = np.full((drawn.shape[1], metrics.shape[1]), np.nan)
    spread = np.full(metrics.shape[1], np.nan)
    for group in _groups(drawn, metrics):
        varies = np.any(group.keys != 0.0, axis=0)[:, None] & np.any(group.metrics != 0.0, axis=0)
        found = np.clip(group.keys.T @ group.metrics, -1.0, 1.0)
        rho[:, group.columns] = np.where(varies, found, np.nan)
        # of the rank correlation of independent values, ties or not
        spread[group.columns] = np.where(np.any(varies, axis=0), _spread(group), np.nan)
    if not np.any(np.isfinite(rho)):
        return Drivers(rho, spread)
    # a hair above, for what differs by its rounding alone
    level = spread * _critical(drawn, metrics) * (1.0 + 1e-9)
    return Drivers(rho, np.minimum(level, 1.0))


def _spread(group: _Group) -> float:
    return 1.0 / np.sqrt(len(group.metrics) - 1.0)


def _groups(drawn: Matrix, metrics: Matrix) -> Iterator[_Group]:
    has = np.isfinite(metrics)
    patterns, kinds = np.unique(has, axis=1, return_inverse=True)
    for kind, pattern in enumerate(patterns.T):
        if np.sum(pattern) >= 3:
            columns = np.flatnonzero(kinds.ravel() == kind).tolist()
            chosen = metrics[pattern][:, columns]
            yield _Group(columns, pattern, _scores(drawn[pattern]), _scores(chosen))


def _scores(values: Matrix) -> Matrix:
    ranks = rankdata(values, axis=0)
    ranks -= 0.5 * (len(values) + 1.0)
    length = np.sqrt(np.sum(ranks**2, axis=0))
    return ranks / np.where(length > 0.0, length, 1.0)


def _critical(drawn: Matrix, metrics: Matrix) -> float:
    """Largest rank correlation over its spread that one shuffled campaign in twenty exceeds."""
    random = np.random.default_rng(0)
    if len(drawn) > MOST_RUNS:
        chosen = random.choice(len(drawn), MOST_RUNS, replace=False)
        drawn, metrics = drawn[chosen], metrics[chosen]
    groups = list(_groups(drawn, metrics))
    runs = len(drawn)
    together = max(1, _AT_ONCE // max(runs * metrics.shape[1], 1))
    largest = np.zeros(PERMUTATIONS)
    for first in range(0, PERMUTATIONS, together):
        count = min(together, PERMUTATIONS - first)
        order = random.permuted(np.tile(np.arange(runs), (count, 1)), axis=1)
        for group in groups:
            # a permutation of all runs is one of those that have the metric, too
            place = np.full(runs, -1)
            place[group.has] = np.arange(len(group.metrics))
            own = place[order]
            own = own[own >= 0].reshape(count, -1).T
            # one product of matrices for all permutations
            shuffled = group.metrics[own].reshape(len(own), -1)
            sizes = np.abs(group.keys.T @ shuffled).reshape(-1, count, len(group.columns))
            part = largest[first : first + count]
            np.maximum(part, np.max(sizes, axis=(0, 2)) / _spread(group), out=part)
    return float(np.sort(largest)[-round(LEVEL * (PERMUTATIONS + 1))])
