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
    return _besides() + FEWEST * POPULATION * COMMON


def _besides() -> int:
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

    def moves(of: Answers, candidates: Matrix) -> Moves:
        known = of.normal[:, : of.normal.shape[1] - len(start)]
        free = np.repeat(ndtri(share(candidates)), len(known), axis=0)
        normal = np.concatenate([np.tile(known, (len(candidates), 1)), free], axis=1)
        return Moves(normal, np.tile(of.numbers, len(candidates)), 0.0, len(normal))

    def loss(value: Vector) -> tuple[bool, float]:
        beyond = excess(value)
        return (True, beyond) if not beyond <= 0.0 else (False, float(value[0]))

    # before the search: their values may be refused
    last = yield first_moves(PROOF)
    fresh = yield first_moves(PROOF)
    answers = yield moves(common, start[None])
    tried, values = [start], [*_values(answers, 1)]
    strategy = evolution(start, FIRST_STEP, [seed], POPULATION)
    for _ in range((runs - _besides()) // (POPULATION * COMMON)):
        if strategy.stop():
            break
        asked = strategy.ask()
        place = np.clip(np.array(asked)[:, : len(start)], -1.0, 1.0)
        answers = yield moves(common, place)
        found = _values(answers, POPULATION)
        losses = [loss(value) for value in found]
        order = sorted(range(POPULATION), key=losses.__getitem__)
        strategy.tell(asked, np.argsort(order).astype(float).tolist())
        tried += [*place]
        values += [*found]
    places = _finalists(np.array(values)[:, 0], np.array([excess(value) for value in values]))
    places = places or [min(range(len(tried)), key=lambda k: loss(values[k]))]
    # the given numbers are compared too: the result is never worse than they are
    places = [*dict.fromkeys([0, *places])]
    answers = yield moves(last, np.array([tried[k] for k in places]))
    losses = [loss(value) for value in _values(answers, len(places))]
    best = tried[places[min(range(len(places)), key=losses.__getitem__)]]
    one = yield moves(fresh, start[None])
    two = yield moves(fresh, best[None])
    before, after = _values(one, 1)[0], _values(two, 1)[0]
    ratio = _ratio(-one.response[:, 0], -two.response[:, 0], seed)
    return Tuned(start, best, np.array(tried), np.array(values), before, after, ratio)


def _finalists(value: Vector, excess: Vector) -> list[int]:
    """Candidates with the smallest value for each margin to the limits, each once."""
    found = []
    for margin in MARGINS:
        fine = np.flatnonzero(excess <= -margin)
        if len(fine):
            found.append(int(fine[np.argmin(value[fine])]))
    return [*dict.fromkeys(found)]


def _values(answers: Answers, candidates: int) -> Matrix:
    """Values of candidates, (candidates, metrics): the percentile over their runs."""
    metrics = -answers.response.reshape(candidates, -1, answers.response.shape[1])
    return np.quantile(metrics, PERCENT / 100.0, axis=1, method="inverted_cdf")


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
