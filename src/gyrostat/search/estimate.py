"""Failure probability from independent replications, its interval, and reasons to doubt it.

The interval is that of the mean of a log-normal distribution, U. Olsson, "Confidence intervals for
the mean of a log-normal distribution", Journal of Statistics Education 13, 2005 (modified Cox
method): the estimates of replications are positive and skewed. Few replications may agree by
chance; their variance is therefore taken to be at least the one that the chains of each explain.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import bdtr, bdtrc, chdtri, ndtri, stdtrit

from gyrostat.campaigns.summary import CONFIDENCE, share_bounds
from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.search.subset import REACHED, STUCK, TOO_RARE, Replication

WIDEST = 12.0
"""Largest ratio of the ends of an interval that is trusted."""
DOUBT = 1e-3
"""Probability below which a disagreement is not chance."""
SLOWEST = 0.15
"""Least share of accepted proposals of a level whose chains are trusted."""
FEWEST_ANCESTORS = 2
"""Fewest independent flights, in each replication on average, from which the failures descend."""


@dataclass(frozen=True)
class Rarity(Described):
    """Failure probability of a run.

    Attributes:
        probability: Mean of the replications; None if the failure was not reached.
        low: Lower end of the 95 % confidence interval; None without a probability.
        high: Upper end.
        variation: Coefficient of variation of the probability; None without a probability.
        doubts: Reasons not to trust the result, or why there is no probability; empty if there are
            none.
        below: Upper limit of the failure probability, 95 % confidence, if the failure was not
            reached; None with a probability.
    """

    probability: float | None
    low: float | None
    high: float | None
    variation: float | None
    doubts: tuple[str, ...]
    below: float | None = None


def rarity(replications: Sequence[Replication]) -> Rarity:
    """Combine independent replications."""
    probabilities = np.array([each.probability for each in replications])
    if not np.all(np.isfinite(probabilities)):
        doubts = tuple(_early_ends(replications))
        return Rarity(None, None, None, None, doubts, _limit(replications))
    low, high = interval(probabilities, _chain_variance(replications))
    mean = float(np.mean(probabilities))
    variation = float(np.std(probabilities, ddof=1) / np.sqrt(len(probabilities)) / mean)
    doubts = (
        *_disagreement(replications, low, high),
        *_slow_chains(replications),
        *_first_level(replications, low, high),
    )
    return Rarity(mean, low, high, variation, doubts)


def _limit(replications: Sequence[Replication]) -> float:
    """Upper limit of the failure probability if not all replications reach the failure.

    The estimate of a replication that ended earlier would have been at most the probability of its
    last level, and the largest estimate of all is below the true value only if each is. For
    log-normal estimates of variance v of their logarithms and mean p, the largest of n is below
    p exp(-v / 2 + z √v) with probability Φ(z)^n. The independent runs give another limit.
    """
    estimates = [each.probability for each in replications]
    estimates += [_last_probability(each) for each in replications if each.ended != REACHED]
    square, tail = _chain_variance(replications), 0.5 * (1.0 - CONFIDENCE)
    quantile = ndtri(tail ** (1.0 / len(replications)))
    high = np.nanmax(estimates) * np.exp(0.5 * square - quantile * np.sqrt(square))
    failures, count = _independent(replications)
    return float(min(high, share_bounds(failures, count)[1]))


def _last_probability(replication: Replication) -> float:
    """Estimated probability of the last level of a replication."""
    return float(np.prod([level.probability for level in replication.levels]))


def _independent(replications: Sequence[Replication]) -> tuple[int, int]:
    """Number of failures among the independent runs, and number of these runs."""
    responses = np.concatenate([each.levels[0].response for each in replications])
    return int(np.sum(responses > 0.0)), len(responses)


def interval(found: Vector, least: float = 0.0) -> tuple[float, float]:
    """95 % confidence interval of the mean of positive estimates.

    Args:
        found: Estimates, (replications,).
        least: Least variance of the logarithm of an estimate.
    """
    logs, count = np.log(found), len(found)
    square = max(float(np.var(logs, ddof=1)), least)
    middle = float(np.mean(logs)) + 0.5 * square
    half = stdtrit(count - 1, 0.5 * (1.0 + CONFIDENCE))
    half *= np.sqrt(square / count + 0.5 * square**2 / (count - 1))
    return float(np.exp(middle - half)), float(min(np.exp(middle + half), 1.0))


def _chain_variance(replications: Sequence[Replication]) -> float:
    """Variance of the logarithm of an estimate that the chains of the replications explain."""
    return float(np.mean([np.log1p(each.variation**2) for each in replications]))


def _early_ends(replications: Sequence[Replication]) -> list[str]:
    """Reasons of the replications that did not reach the failure."""
    count = len(replications)
    stuck = sum(each.ended == STUCK for each in replications)
    rare = [each for each in replications if each.ended == TOO_RARE]
    doubts = []
    if stuck:
        doubts.append(
            f"in {stuck} of {count} replications the metric does not come closer to the failure: "
            "the dispersions and the noise may not be able to cause it, or the metric has steps"
        )
    if rare:
        probability = max(map(_last_probability, rare))
        doubts.append(
            f"{len(rare)} of {count} replications end before the failure, at a probability of "
            f"about {probability:.0e}"
        )
    return doubts


def _disagreement(replications: Sequence[Replication], low: float, high: float) -> list[str]:
    """Whether the replications disagree more than their own chains explain."""
    logs = np.log([each.probability for each in replications])
    variance, count = _chain_variance(replications), len(logs)
    limit = chdtri(count - 1, DOUBT) / (count - 1)
    if high / low > WIDEST:
        return [
            f"the replications disagree: {np.exp(np.min(logs)):.1e} to {np.exp(np.max(logs)):.1e}; "
            "some may have missed a failure region: give more runs"
        ]
    # the chains of a replication have common ancestors, so that their own estimate is too small
    if np.var(logs, ddof=1) > 2.0 * limit * max(variance, 1e-12):
        return [
            "the replications differ by more than their chains explain: a failure region may have "
            "been missed"
        ]
    return []


def _slow_chains(replications: Sequence[Replication]) -> list[str]:
    """Whether chains hardly move, or failures descend from few independent flights."""
    levels = [level for each in replications for level in each.levels[1:]]
    if not levels:
        return []
    doubts = []
    if min(level.accepted for level in levels) < SLOWEST:
        doubts.append(
            f"only {min(level.accepted for level in levels):.0%} of the moves of a level were "
            "accepted: the chains hardly move"
        )
    last_levels = [each.levels[-1] for each in replications]
    ancestors = [len(np.unique(level.ancestors[level.response > 0.0])) for level in last_levels]
    if np.mean(ancestors) < FEWEST_ANCESTORS:
        doubts.append("almost all failures of a replication descend from one flight")
    return doubts


def _first_level(replications: Sequence[Replication], low: float, high: float) -> list[str]:
    """Whether the failures among the independent runs contradict the interval."""
    failures, count = _independent(replications)
    too_many = failures > 0 and bdtrc(failures - 1, count, high) < DOUBT
    if too_many or bdtr(failures, count, low) < DOUBT:
        return [
            f"{failures} of {count} independent runs fail, which contradicts the estimate: a "
            "failure region may have been missed"
        ]
    return []
