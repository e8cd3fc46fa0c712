"""Search for the best values of free numbers, by CMA-ES on common runs, and a proof on fresh ones.

All candidates are flown with the same dispersed values and the same noise (common random numbers:
A. M. Law, "Simulation Modeling and Analysis", section 11.2), so that they differ by their free
numbers alone. A candidate that violates a limit is worse than any that does not (K. Deb, "An
efficient constraint handling method for genetic algorithms", 2000). It meets a limit if all of its
common runs do: then 95 % of all runs do with a confidence of 1 - 0.95^64 = 96 % (S. S. Wilks,
"Determination of sample sizes for setting tolerance limits", 1941). The 95 % percentile of the
common runs would be too low for the best of many candidates that are at the limit.
"""

from collections.abc import Callable, Generator
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from gyrostat.campaigns.search.moves import Answers, Moves, first_moves
from gyrostat.campaigns.search.worst import evolution
from gyrostat.core.types import Matrix, Vector

COMMON, PROOF = 64, 256
"""Number of common runs of all candidates, and of fresh runs of the proof."""
POPULATION, FEWEST = 16, 3
"""Candidates of a generation, and fewest generations."""
FIRST_STEP = 0.3
"""First standard deviation, relative to the bounds."""
PERCENT = 95.0
"""Percentage of the runs that stay below the value by which a candidate is judged."""
RESAMPLED = 999
"""Number of bootstrap samples of an interval."""


class Tuned(NamedTuple):
    """Best candidate.

    Attributes:
        start: Coordinates of the given numbers, (free,), from −1 to 1.
        best: Coordinates of the best candidate, (free,).
        tried: Coordinates of all candidates, (candidates, free).
        values: Their values on the common runs, (candidates, metrics); see `judged`.
        before: Values of the given numbers on fresh runs, (metrics,).
        after: Values of the best candidate on the same runs, (metrics,).
        ratio: `after` over `before` of the first metric, with the ends of its 95 % interval, (3,).
    """

    start: Vector
    best: Vector
    tried: Matrix
    values: Matrix
    before: Vector
    after: Vector
    ratio: Vector


def fewest_flights() -> int:
    """Fewest flights of a search."""
    return 2 * COMMON + 3 * PROOF + FEWEST * POPULATION * COMMON


def tune(
    start: Vector,
    share: Callable[[Matrix], Matrix],
    excess: Callable[[Vector], float],
    runs: int,
    seed: int,
) -> Generator[Moves, Answers, Tuned]:
    """Search for the smallest value of the first metric within the limits of the others.

    The responses of a flight are its metrics with the opposite sign, (n, metrics).

    Args:
        start: Coordinates of the given numbers, (free,), from −1 to 1.
        share: Coordinates -> uniform numbers of the free numbers, which are the last dispersed
            ones.
        excess: Values of a candidate, (metrics,) -> how far it is beyond its limits; not positive
            within them.
        runs: Largest number of flights.
        seed: Seed of the search.

    Yields:
        Flights to simulate; their answers are sent back.

    Returns:
        The best candidate.
    """
    common = yield first_moves(COMMON)

    def moves(of: Answers, candidates: Matrix) -> Moves:
        known = of.normal[:, : of.normal.shape[1] - len(start)]
        free = np.repeat(ndtri(share(candidates)), len(known), axis=0)
        normal = np.concatenate([np.tile(known, (len(candidates), 1)), free], axis=1)
        return Moves(normal, np.tile(of.numbers, len(candidates)), 0.0, len(normal))

    def loss(value: Vector) -> tuple[bool, float]:
        beyond = excess(value)
        return (True, beyond) if not beyond <= 0.0 else (False, float(value[0]))

    # before the search: their values may be refused
    fresh = yield first_moves(PROOF)
    answers = yield moves(common, start[None])
    tried, values = [start], [*judged(_metrics(answers, 1))]
    strategy = evolution(start, FIRST_STEP, [seed], POPULATION)
    left = runs - 2 * COMMON - 3 * PROOF
    for _ in range(left // (POPULATION * COMMON)):
        if strategy.stop():
            break
        asked = strategy.ask()
        place = np.clip(np.array(asked)[:, : len(start)], -1.0, 1.0)
        answers = yield moves(common, place)
        found = judged(_metrics(answers, POPULATION))
        losses = [loss(value) for value in found]
        order = sorted(range(POPULATION), key=losses.__getitem__)
        strategy.tell(asked, np.argsort(order).astype(float).tolist())
        tried += [*place]
        values += [*found]
    best = tried[min(range(len(tried)), key=lambda k: loss(values[k]))]
    one = yield moves(fresh, start[None])
    two = yield moves(fresh, best[None])
    before, after = (percentile(_metrics(each, 1))[0] for each in (one, two))
    ratio = _ratio(-one.response[:, 0], -two.response[:, 0], seed)
    return Tuned(start, best, np.array(tried), np.array(values), before, after, ratio)


def percentile(metrics: Matrix) -> Matrix:
    """Values that `PERCENT` of the runs do not exceed, from (candidates, runs, metrics)."""
    return np.quantile(metrics, PERCENT / 100.0, axis=1, method="inverted_cdf")


def judged(metrics: Matrix) -> Matrix:
    """Values by which candidates are judged, (candidates, metrics).

    Args:
        metrics: Metrics of the common runs, (candidates, runs, metrics).

    Returns:
        The percentile of the first metric, and the largest values of those with limits.
    """
    return np.concatenate([percentile(metrics[..., :1]), np.max(metrics[..., 1:], axis=1)], axis=1)


def _metrics(answers: Answers, candidates: int) -> Matrix:
    return -answers.response.reshape(candidates, -1, answers.response.shape[1])


def _ratio(one: Vector, two: Vector, seed: int) -> Vector:
    """Ratio of the percentiles of paired runs, with the ends of its bootstrap interval."""
    random = np.random.default_rng([seed, 1])
    place = np.concatenate(
        [np.arange(len(one))[None], random.integers(len(one), size=(RESAMPLED, len(one)))]
    )
    level = {"q": PERCENT / 100.0, "axis": 1, "method": "inverted_cdf"}
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.quantile(two[place], **level) / np.quantile(one[place], **level)
    if not np.any(np.isfinite(ratio[1:])):
        return np.full(3, np.nan)
    low, high = np.nanquantile(ratio[1:], [0.025, 0.975])
    return np.array([ratio[0], low, high])
