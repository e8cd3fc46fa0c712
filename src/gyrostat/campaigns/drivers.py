"""Drivers of each metric: rank correlations with the drawn values, and their significance level.

A report tests every drawn key against every metric, a few hundred pairs. The significance level
(chance level) holds for all of them together: if no key has any influence, a driver is named in one
of twenty campaigns. The level is computed by permutations of the runs (P. H. Westfall and S. S.
Young, "Resampling-based multiple testing", 1993, single-step maxT). They preserve the dependence
among keys and among metrics, ties, and missing metrics; no distribution is assumed.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.ranks import Ranks, doubled_ranks
from gyrostat.core.types import Matrix, Vector

LEVEL = 0.05
"""Probability that a driver is named in a campaign without drivers."""
PERMUTATIONS = 999
MOST_RUNS = 2000
"""Largest number of runs that are permuted. Of more runs, a random subset is used: the level in
units of the standard deviation is the same."""
_AT_ONCE = 4_000_000
"""Number of elements in memory at a time."""


class Drivers(NamedTuple):
    """Rank correlations of a campaign.

    Attributes:
        rank_correlation: Spearman's rank correlation over the runs that have the metric, (keys,
            metrics); NaN if values or metrics are equal in all runs, and for less than three runs.
        chance_level: Absolute rank correlation above which a key is named as a driver, (metrics,),
            at most 1; NaN for a metric without rank correlation.
    """

    rank_correlation: Matrix
    chance_level: Vector

    def named(self) -> NDArray[np.bool_]:
        """Whether each key is named as a driver of each metric, (keys, metrics)."""
        return np.abs(self.rank_correlation) > self.chance_level


class _Group(NamedTuple):
    """Metrics that are available in the same runs.

    Attributes:
        columns: Indices of the metrics.
        has: Whether each run has these metrics, (runs,).
        keys: Ranks of the drawn values, centred, of unit length, (runs that have the metrics,
            keys); 0 if all are equal.
        metrics: Ranks of the metrics likewise, (runs that have the metrics, columns).
    """

    columns: list[int]
    has: NDArray[np.bool_]
    keys: Matrix
    metrics: Matrix


def find_drivers(drawn: Matrix, metrics: Matrix) -> Drivers:
    """Compute the rank correlation of every key with every metric, and the significance levels.

    Args:
        drawn: Drawn values, (runs, keys).
        metrics: Values of the metrics, (runs, metrics), NaN for missing ones.
    """
    return drivers_of([*drawn.T], [*metrics.T])


def drivers_of(drawn: Sequence[Vector], metrics: Sequence[Vector]) -> Drivers:
    """See `find_drivers`; only one column is in memory at a time.

    Args:
        drawn: Drawn values of each key, (keys,) of (runs,).
        metrics: Values of each metric, (metrics,) of (runs,), NaN for missing ones.
    """
    rho = np.full((len(drawn), len(metrics)), np.nan)
    spread = np.full(len(metrics), np.nan)
    for has, columns in _patterns(metrics):
        count = int(np.sum(has))
        if count < 3:
            continue
        with Ranks(count) as ranks:
            for key in range(len(drawn)):
                ranks.add(partial(_present, drawn, key, has))
            for column in columns:
                ranks.add(partial(_present, metrics, column, has))
            found, varies = _correlation(ranks, len(drawn), len(columns))
        rho[:, columns] = np.where(varies, np.clip(found, -1.0, 1.0), np.nan)
        # standard deviation of the rank correlation of independent values, with or without ties
        spread[columns] = np.where(np.any(varies, axis=0), _spread(count), np.nan)
    if not np.any(np.isfinite(rho)):
        return Drivers(rho, spread)
    # margin for rounding errors
    level = spread * _critical(drawn, metrics) * (1.0 + 1e-9)
    return Drivers(rho, np.minimum(level, 1.0))


def _present(columns: Sequence[Vector], column: int, has: NDArray[np.bool_]) -> Vector:
    """Values of some runs; without a copy if they are all."""
    values = columns[column]
    return values if np.all(has) else values[has]


def _each(columns: Sequence[Vector]) -> Iterator[Vector]:
    return (columns[k] for k in range(len(columns)))


def _patterns(metrics: Sequence[Vector]) -> Iterator[tuple[NDArray[np.bool_], list[int]]]:
    """As `alike`, column by column, with one bit in memory for each run and metric."""
    kinds: dict[bytes, list[int]] = {}
    runs = 0
    for column in range(len(metrics)):
        has = np.isfinite(metrics[column])
        runs = len(has)
        kinds.setdefault(np.packbits(has).tobytes(), []).append(column)
    for bits, columns in kinds.items():
        yield np.unpackbits(np.frombuffer(bits, np.uint8), count=runs).astype(bool), columns


def _correlation(ranks: Ranks, keys: int, metrics: int) -> tuple[Matrix, NDArray[np.bool_]]:
    """Correlation of keys and metrics, and whether both vary, (keys, metrics)."""
    columns = range(keys + metrics)
    squares = np.zeros(keys + metrics)
    for part in ranks.centred(columns):
        squares += np.sum(part**2, axis=0)
    length = np.sqrt(squares)
    length = np.where(length > 0.0, length, 1.0)
    product = np.zeros((keys, metrics))
    of_keys, of_metrics = columns[:keys], columns[keys:]
    for key_part, part in zip(ranks.centred(of_keys), ranks.centred(of_metrics), strict=True):
        product += (key_part / length[:keys]).T @ (part / length[keys:])
    varies = squares > 0.0
    return product, varies[:keys, None] & varies[keys:]


def _spread(count: int) -> float:
    return 1.0 / np.sqrt(count - 1.0)


def alike(metrics: Matrix) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.int64]]]:
    """Runs that have the same metrics, (runs,), and indices of these metrics.

    Args:
        metrics: Values of the metrics, (runs, metrics), NaN for missing ones.
    """
    return ((has, np.array(columns)) for has, columns in _patterns([*metrics.T]))


def _groups(drawn: Matrix, metrics: Matrix) -> Iterator[_Group]:
    for has, columns in alike(metrics):
        if np.sum(has) >= 3:
            values = metrics[has][:, columns]
            yield _Group(columns.tolist(), has, _scores(drawn[has]), _scores(values))


def _scores(values: Matrix) -> Matrix:
    ranks = np.stack([0.5 * doubled_ranks(column) for column in values.T], axis=1)
    ranks -= 0.5 * (len(values) + 1.0)
    length = np.sqrt(np.sum(ranks**2, axis=0))
    return ranks / np.where(length > 0.0, length, 1.0)


def _critical(drawn_columns: Sequence[Vector], metric_columns: Sequence[Vector]) -> float:
    """Largest standardised rank correlation that one of twenty permuted campaigns exceeds."""
    random = np.random.default_rng(0)
    count = len(metric_columns[0])
    sample: slice | NDArray[np.int64] = slice(None)
    if count > MOST_RUNS:
        sample = random.choice(count, MOST_RUNS, replace=False)
    drawn, metrics = (
        np.stack([each[sample] for each in _each(columns)], axis=1)
        for columns in (drawn_columns, metric_columns)
    )
    groups = list(_groups(drawn, metrics))
    runs = len(drawn)
    batch = max(1, _AT_ONCE // max(runs * metrics.shape[1], 1))
    largest = np.zeros(PERMUTATIONS)
    for first in range(0, PERMUTATIONS, batch):
        count = min(batch, PERMUTATIONS - first)
        order = random.permuted(np.tile(np.arange(runs), (count, 1)), axis=1)
        for group in groups:
            # a permutation of all runs also permutes the runs that have the metric
            row_of_run = np.full(runs, -1)
            row_of_run[group.has] = np.arange(len(group.metrics))
            rows = row_of_run[order]
            rows = rows[rows >= 0].reshape(count, -1).T
            # one matrix product for all permutations
            shuffled = group.metrics[rows].reshape(len(rows), -1)
            sizes = np.abs(group.keys.T @ shuffled).reshape(-1, count, len(group.columns))
            part = largest[first : first + count]
            np.maximum(part, np.max(sizes, axis=(0, 2)) / _spread(len(group.metrics)), out=part)
    return float(np.sort(largest)[-round(LEVEL * (PERMUTATIONS + 1))])
