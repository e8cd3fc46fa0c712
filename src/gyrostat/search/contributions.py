"""Contributions of sources to the mean square of an error, from runs with sources switched off.

The mean square over runs and time is v(S) for the set S of sources that are on. A source i
contributes

    c_i = [v(i) - v(none) + v(all) - v(all but i)] / 2,

the mean of what it adds alone and of what is missing without it. The error of a linear system is a
sum over sources, so that its mean square has products of two sources at most; c_i is then the
Shapley value of the source: the product of two sources is halved between them (L. S. Shapley, "A
value for n-person games", 1953). What the contributions leave over of v(all) - v(none) are the
interactions of three and more sources. The square of the mean error is split off before.

With orders, in which the sources are switched on one after the other, c_i is the mean of what the
source adds in each: the Shapley value of any system, if all orders are taken or a random sample,
here of orders and their reverses (J. Castro, D. Gómez, J. Tejada, "Polynomial calculation of the
Shapley value based on sampling", 2009). Nothing is left over then.

All sets have the same runs, so that intervals are from the differences of each run: jackknife, with
the distribution of Student (B. Efron, C. Stein, "The jackknife estimate of variance", 1981).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.summary import CONFIDENCE, Estimate
from gyrostat.core.field_table import field_table
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

    _repr_html_ = field_table

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

    _repr_html_ = field_table

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
        orders: Orders in which the sources are switched on, each with the places of the sets from
            none to all; an order and its reverse follow each other. Empty: contributions are from
            `alone` and `without`.
        is_every_order: Whether these are all orders.
    """

    names: tuple[str, ...]
    alone: tuple[int, ...]
    without: tuple[int, ...]
    orders: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...] = ()
    is_every_order: bool = False


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
    pairs = _weights(sets, len(mean_square))
    weights = np.mean(pairs, axis=0)
    parts = variance @ weights.T
    spread = np.zeros(len(weights))
    if len(pairs) > 1 and not sets.is_every_order:
        spread = np.std(pairs @ variance[0], axis=0, ddof=1) / np.sqrt(len(pairs))
        spread *= _student(len(pairs) - 1)
    rest = variance[:, WHOLE] - variance[:, NONE] - np.sum(parts, axis=1)
    whole = square[:, WHOLE]
    other = np.stack([bias[:, WHOLE], variance[:, NONE], rest], axis=1)
    mean_parts = np.einsum("ks,rsp->rkp", weights, mean)
    with np.errstate(invalid="ignore", divide="ignore"):
        shares, other_shares = parts / whole[:, None], other / whole[:, None]
    first, second, third = (_estimate(column) for column in other_shares.T)
    return Contributions(
        _positive(_estimate(whole)),
        _positive(_estimate(other[:, 0])),
        _positive(_estimate(other[:, 1])),
        tuple(
            Contribution(
                name,
                _estimate(parts[:, k], spread[k]),
                _estimate(shares[:, k], spread[k] / whole[0] if whole[0] > 0.0 else 0.0),
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


def _weights(sets: Sets, count: int) -> NDArray[np.float64]:
    """Weights of the sets in the contribution of each source, (pairs, sources, sets).

    The contribution of a source is the mean over the pairs, which are samples of the orders.
    """
    sources = len(sets.names)
    if not sets.orders:
        weights = np.zeros((1, sources, count))
        for k in range(sources):
            for place, sign in (
                *((sets.alone[k], 0.5), (NONE, -0.5)),
                *((WHOLE, 0.5), (sets.without[k], -0.5)),
            ):
                weights[0, k, place] += sign
        return weights
    weights = np.zeros((len(sets.orders), sources, count))
    for row, (order, places) in zip(weights, sets.orders, strict=True):
        for source, before, after in zip(order, places[:-1], places[1:], strict=True):
            row[source, after] += 1.0
            row[source, before] -= 1.0
    return weights.reshape(len(sets.orders) // 2, 2, sources, count).mean(axis=1)


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


def _positive(estimate: Estimate) -> Estimate:
    """Estimate of what is not negative: no interval below zero."""
    return estimate._replace(low=min(max(estimate.low, 0.0), estimate.value))


def _estimate(values: Vector, spread: float = 0.0) -> Estimate:
    """Estimate from the values of all runs and of all but one, (1 + runs,).

    Args:
        values: Values.
        spread: Half of the interval that is due to the choice of the orders.
    """
    runs = len(values) - 1
    others = values[1:]
    sigma = np.sqrt((runs - 1) / runs * np.sum((others - np.mean(others)) ** 2))
    half = float(np.hypot(_student(runs - 1) * sigma, spread))
    value = float(values[0])
    return Estimate(value, value - half, value + half)


def _student(freedom: int) -> float:
    """Half of the interval of a mean in standard deviations."""
    from scipy.special import stdtrit  # slow to import

    return float(stdtrit(freedom, 0.5 * (1.0 + CONFIDENCE)))
