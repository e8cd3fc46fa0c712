"""Search for the best values of free numbers, by CMA-ES on common runs, and a proof on fresh ones.

All candidates are flown with the same dispersed values and the same noise (common random numbers:
A. M. Law, "Simulation Modeling and Analysis", section 11.2), so that they differ by their free
numbers alone. A candidate that violates a limit is worse than any that does not (K. Deb, "An
efficient constraint handling method for genetic algorithms", 2000).

The best of many candidates on few common runs often exceeds its limits in others, because it was
chosen for these runs. The best candidates with several margins to the limits are therefore compared
again, on more runs.
"""

from collections.abc import Callable, Generator
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from gyrostat.core.types import Matrix, Vector
from gyrostat.search.moves import Answers, Moves, first_moves
from gyrostat.search.worst import evolution

COMMON, PROOF = 64, 256
"""Number of common runs of all candidates, and of those of the last comparison and of the proof."""
MARGINS = (0.0, 0.02, 0.05, 0.1, 0.2)
"""Relative margins to the limits of the candidates of the last comparison."""
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
        values: Their values on the common runs, (candidates, metrics).
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
    return _overhead() + FEWEST * POPULATION * COMMON


def _overhead() -> int:
    """Largest number of flights besides those of the generations."""
    return 2 * COMMON + (5 + len(MARGINS)) * PROOF


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

    def moves(base: Answers, candidates: Matrix) -> Moves:
        dispersions = base.normal[:, : base.normal.shape[1] - len(start)]
        free = np.repeat(ndtri(share(candidates)), len(dispersions), axis=0)
        normal = np.concatenate([np.tile(dispersions, (len(candidates), 1)), free], axis=1)
        return Moves(normal, np.tile(base.numbers, len(candidates)), 0.0, len(normal))

    def loss(value: Vector) -> tuple[bool, float]:
        violation = excess(value)
        return (True, violation) if not violation <= 0.0 else (False, float(value[0]))

    # before the search: their values may be refused
    comparison = yield first_moves(PROOF)
    proof = yield first_moves(PROOF)
    answers = yield moves(common, start[None])
    tried, values = [start], [*_percentiles(answers, 1)]
    strategy = evolution(start, FIRST_STEP, [seed], POPULATION)
    for _ in range((runs - _overhead()) // (POPULATION * COMMON)):
        if strategy.stop():
            break
        samples = strategy.ask()
        coordinates = np.clip(np.array(samples)[:, : len(start)], -1.0, 1.0)
        answers = yield moves(common, coordinates)
        scores = _percentiles(answers, POPULATION)
        losses = [loss(value) for value in scores]
        order = sorted(range(POPULATION), key=losses.__getitem__)
        strategy.tell(samples, np.argsort(order).astype(float).tolist())
        tried += [*coordinates]
        values += [*scores]
    finalists = _finalists(np.array(values)[:, 0], np.array([excess(value) for value in values]))
    finalists = finalists or [min(range(len(tried)), key=lambda k: loss(values[k]))]
    # the given numbers are compared too: the result is never worse than they are
    finalists = [*dict.fromkeys([0, *finalists])]
    answers = yield moves(comparison, np.array([tried[k] for k in finalists]))
    losses = [loss(value) for value in _percentiles(answers, len(finalists))]
    best = tried[finalists[min(range(len(finalists)), key=losses.__getitem__)]]
    reference = yield moves(proof, start[None])
    optimum = yield moves(proof, best[None])
    before, after = _percentiles(reference, 1)[0], _percentiles(optimum, 1)[0]
    ratio = _ratio(-reference.response[:, 0], -optimum.response[:, 0], seed)
    return Tuned(start, best, np.array(tried), np.array(values), before, after, ratio)


def _finalists(value: Vector, excess: Vector) -> list[int]:
    """Candidates with the smallest value for each margin to the limits, each once."""
    sets = [np.flatnonzero(excess <= -margin) for margin in MARGINS]
    return [*dict.fromkeys(int(fine[np.argmin(value[fine])]) for fine in sets if len(fine))]


def _percentiles(answers: Answers, candidates: int) -> Matrix:
    """Values of candidates, (candidates, metrics): the percentile over their runs."""
    metrics = -answers.response.reshape(candidates, -1, answers.response.shape[1])
    return np.quantile(metrics, PERCENT / 100.0, axis=1, method="inverted_cdf")


def _ratio(reference: Vector, optimum: Vector, seed: int) -> Vector:
    """Ratio of the percentiles of paired runs, with the ends of its bootstrap interval."""
    random = np.random.default_rng([seed, 1])
    indices = np.concatenate(
        [
            np.arange(len(reference))[None],
            random.integers(len(reference), size=(RESAMPLED, len(reference))),
        ]
    )
    level = {"q": PERCENT / 100.0, "axis": 1, "method": "inverted_cdf"}
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.quantile(optimum[indices], **level) / np.quantile(reference[indices], **level)
    if not np.any(np.isfinite(ratio[1:])):
        return np.full(3, np.nan)
    low, high = np.nanquantile(ratio[1:], [0.025, 0.975])
    return np.array([ratio[0], low, high])
