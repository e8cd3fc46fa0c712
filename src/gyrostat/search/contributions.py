"""Contributions of sources to the mean square of an error, from runs with sources switched off.

The mean square over runs and time is v(S) for the set S of sources that are on. A source i
contributes

    c_i = [v(i) - v(none) + v(all) - v(all but i)] / 2,

the mean of what it adds alone and of what is missing without it. The error of a linear system is a
sum over sources, so that its mean square has products of two sources at most; c_i is then the
Shapley value of the source: the product of two sources is halved between them (L. S. Shapley, "A
value for n-person games", 1953). What the contributions leave over of v(all) - v(none) are the
interactions of three and more sources. The square of the mean error is split off before.

All sets have the same runs, so that intervals are from the differences of each run: jackknife, with
the distribution of Student (B. Efron, C. Stein, "The jackknife estimate of variance", 1981).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.summary import CONFIDENCE, Estimate
from gyrostat.core.types import Matrix, Vector

WHOLE, NONE = 0, 1
"""Places of the sets with all sources on and all sources off."""
RESAMPLED = 999
"""Number of bootstrap samples of an interval."""


class Contribution(NamedTuple):
    """Contribution of a source to a mean square.

    Attributes:
        name: Name of the source.
        mean_square: Contribution to the variance about the mean error.
        share: The same relative to the mean square of the whole error.
        alone: What the source adds alone.
        missing: What is missing without it; the difference to `alone` is its interaction with all
            others.
        bias: Contribution to the mean error, (parts,).
    """

    name: str
    mean_square: Estimate
    share: Estimate
    alone: Estimate
    missing: Estimate
    bias: tuple[Estimate, ...]


class Contributions(NamedTuple):
    """Mean square of an error and what it consists of: bias, lag, sources and interaction.

    Attributes:
        whole: Mean square of the whole error.
        bias: Square of the mean error over runs and time.
        lag: Variance about the mean with all sources off.
        sources: Contributions of the sources to the variance.
        interaction: Interactions of three and more sources.
        shares: Shares of bias, lag and interaction in the whole.
        mean: Mean error, (parts,).
        lag_mean: Mean error with all sources off, (parts,).
    """

    whole: Estimate
    bias: Estimate
    lag: Estimate
    sources: tuple[Contribution, ...]
    interaction: Estimate
    shares: tuple[Estimate, Estimate, Estimate]
    mean: tuple[Estimate, ...]
    lag_mean: tuple[Estimate, ...]


class Sets(NamedTuple):
    """Places of the sets of sources among the simulated ones.

    Attributes:
        names: Names of the sources.
        alone: Place of the set in which each source is on alone.
        without: Place of the set in which each source is off alone.
    """

    names: tuple[str, ...]
    alone: tuple[int, ...]
    without: tuple[int, ...]


def contributions(sets: Sets, mean_square: Matrix, means: NDArray[np.float64]) -> Contributions:
    """Split the mean square of an error into the contributions of sources.

    Args:
        sets: Sets of sources.
        mean_square: Mean square over the time of each run, (sets, runs).
        means: Mean over the time of each run, (sets, runs, parts).
    """
    square, mean, bias = _left_out(mean_square), _left_out(means), _squared_mean(means)
    variance = square - bias
    alone = variance[:, [*sets.alone]] - variance[:, [NONE]]
    missing = variance[:, [WHOLE]] - variance[:, [*sets.without]]
    parts = 0.5 * (alone + missing)
    rest = variance[:, WHOLE] - variance[:, NONE] - np.sum(parts, axis=1)
    whole = square[:, WHOLE]
    other = np.stack([bias[:, WHOLE], variance[:, NONE], rest], axis=1)
    mean_parts = 0.5 * (
        mean[:, [*sets.alone]] - mean[:, [NONE]] + mean[:, [WHOLE]] - mean[:, [*sets.without]]
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        shares, other_shares = parts / whole[:, None], other / whole[:, None]
    first, second, third = (_estimate(column) for column in other_shares.T)
    return Contributions(
        _estimate(whole),
        _estimate(other[:, 0]),
        _estimate(other[:, 1]),
        tuple(
            Contribution(
                name,
                _estimate(parts[:, k]),
                _estimate(shares[:, k]),
                _estimate(alone[:, k]),
                _estimate(missing[:, k]),
                tuple(_estimate(column) for column in mean_parts[:, k].T),
            )
            for k, name in enumerate(sets.names)
        ),
        _estimate(other[:, 2]),
        (first, second, third),
        tuple(_estimate(column) for column in mean[:, WHOLE].T),
        tuple(_estimate(column) for column in mean[:, NONE].T),
    )


def missing_without(mean_square: Matrix, places: Sequence[int]) -> list[Estimate]:
    """Mean square of the whole error minus that of each of other sets, (sets, runs)."""
    square = _left_out(mean_square)
    return [_estimate(square[:, WHOLE] - square[:, place]) for place in places]


def statistic_without(values: Matrix, level: float | None, seed: int) -> list[Estimate]:
    """Statistic of a metric over runs: of the whole, and of the whole minus that of each set.

    Intervals are percentiles of bootstrap samples of the runs, which all sets have in common.

    Args:
        values: Metric of each run, (sets, runs); the first set is the whole.
        level: Share of the runs that do not exceed the statistic; None: their mean.
        seed: Seed of the samples.
    """
    runs = values.shape[1]
    random = np.random.default_rng(seed)
    picked = np.concatenate([np.arange(runs)[None], random.integers(runs, size=(RESAMPLED, runs))])

    def statistic(row: Vector) -> Vector:
        if level is None:
            return np.mean(row[picked], axis=1)
        return np.quantile(row[picked], level, axis=1, method="inverted_cdf")

    whole = statistic(values[WHOLE])
    results = [whole, *(whole - statistic(row) for row in values[1:])]
    tail = 0.5 * (1.0 - CONFIDENCE)
    return [
        Estimate(float(each[0]), *np.quantile(each[1:], [tail, 1.0 - tail]).tolist())
        for each in results
    ]


def _left_out(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means over runs, (1 + runs, sets, ...): of all runs, then without each of them."""
    runs = values.shape[1]
    total = np.sum(values, axis=1)
    others = (total[:, None] - values) / (runs - 1)
    return np.moveaxis(np.concatenate([total[:, None] / runs, others], axis=1), 1, 0)


def _squared_mean(means: NDArray[np.float64]) -> Matrix:
    """Squared mean error without bias, (1 + runs, sets): the mean product of two different runs.

    In the order of `_left_out`.
    """
    runs = means.shape[1]
    total, squares = np.sum(means, axis=1), np.sum(means**2, axis=(1, 2))
    one = (np.sum(total**2, axis=-1) - squares) / (runs * (runs - 1))
    rest, rest_squares = total[:, None] - means, squares[:, None] - np.sum(means**2, axis=2)
    others = (np.sum(rest**2, axis=-1) - rest_squares) / ((runs - 1) * (runs - 2))
    return np.concatenate([one[:, None], others], axis=1).T


def _estimate(values: Vector) -> Estimate:
    """Estimate from the values of all runs and of all but one, (1 + runs,)."""
    from scipy.special import stdtrit  # slow to import

    runs = len(values) - 1
    others = values[1:]
    sigma = np.sqrt((runs - 1) / runs * np.sum((others - np.mean(others)) ** 2))
    half = float(stdtrit(runs - 1, 0.5 * (1.0 + CONFIDENCE)) * sigma)
    value = float(values[0])
    return Estimate(value, value - half, value + half)
