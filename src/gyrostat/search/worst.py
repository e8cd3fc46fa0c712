"""Search for the worst case within bounds, by CMA-ES and independent noise.

N. Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772; the package `cma` has it. It
uses the order of the responses only. The flights of a start have the same noise, so that they
differ by their values alone.
"""

from collections.abc import Generator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.core.types import Matrix, Vector
from gyrostat.search.largest import Largest
from gyrostat.search.moves import FIRST, Answers, Moves

POPULATION = 64
"""Flights of a generation; SIMD lanes and cores compute them together."""
GENERATIONS = 40
"""Largest number of generations of a start."""
FIRST_STEP = 0.4
"""First standard deviation of a start, relative to the bounds."""
FEWEST, FEWEST_OF_KEY = 10 * POPULATION, 2
"""Fewest flights of a search, and those to be added for each dispersed key."""
INDEPENDENT, MOST_INDEPENDENT = 10, 512
"""Share of the flights that are independent, 1 / INDEPENDENT, and their largest number."""


class Bounds(NamedTuple):
    """Bounds of the dispersions; coordinates are from −1 to 1 within them.

    Attributes:
        limited: Whether the distribution of each key has a lower and an upper limit, (keys,).
        sigma: Bound of the others, standard deviations; of the limited ones, the bound with the
            same probability, unless `ends`.
        ends: Whether the bounds of limited distributions are their limits.
    """

    limited: NDArray[np.bool_]
    sigma: float
    ends: bool

    def normal(self, coordinates: Matrix) -> Matrix:
        """Standard normal numbers of coordinates, (n, keys)."""
        share = 0.5 + coordinates * (0.5 if self.ends else ndtr(self.sigma) - 0.5)
        return np.where(self.limited, ndtri(share), self.sigma * coordinates)

    def draw(self, random: np.random.Generator, count: int) -> Matrix:
        """Standard normal numbers of runs with independent draws within the bounds, (n, keys)."""
        share = ndtr(self.sigma) - 0.5
        half = np.where(self.limited & self.ends, 0.5, share)
        return ndtri(0.5 + half * random.uniform(-1.0, 1.0, (count, len(half))))

    def coordinates(self, normal: Matrix) -> Matrix:
        """Coordinates of standard normal numbers, (n, keys); beyond ±1 outside the bounds."""
        share = (ndtr(normal) - 0.5) / (0.5 if self.ends else ndtr(self.sigma) - 0.5)
        return np.where(self.limited, share, normal / self.sigma)


class Worst(NamedTuple):
    """Worst case.

    Attributes:
        number: Number of the flight: the one with the largest response of all flights.
        response: Its response.
        coordinates: Its coordinates, (keys,), from −1 to 1.
        without: Response with each value at its median and everything else the same, (keys,); NaN
            if it was not flown.
        noise_share: Share of the variance of the response that is due to noise; NaN if the response
            does not vary.
        random: Largest response of the independent flights.
        independent: Number of independent flights.
    """

    number: int
    response: float
    coordinates: Vector
    without: Vector
    noise_share: float
    random: float
    independent: int


def fewest_flights(keys: int) -> int:
    """Fewest flights of a search with this number of dispersed keys."""
    return FEWEST + FEWEST_OF_KEY * keys


def worst_case(bounds: Bounds, runs: int, seed: int) -> Generator[Moves, Answers, Worst]:
    """Search for the largest response.

    Args:
        bounds: Bounds of the dispersions.
        runs: Largest number of flights.
        seed: Seed of the search.

    Yields:
        Flights to simulate, all within the bounds; their answers are sent back.

    Returns:
        The worst case.

    Raises:
        InputError: No independent flight has allowed values.
    """
    largest = Largest()
    return (yield from largest.follow(_search(bounds, runs, seed, largest)))


def _search(
    bounds: Bounds, runs: int, seed: int, largest: Largest
) -> Generator[Moves, Answers, Worst]:
    """See `worst_case`; `largest` follows the search."""
    keys, count = len(bounds.limited), min(runs // INDEPENDENT, MOST_INDEPENDENT)
    # trailing zeros would give the random numbers of a start
    normal = bounds.draw(np.random.default_rng([seed, 0, 1]), count)
    answers = yield Moves(normal, np.full(count, FIRST), 1.0, count)
    indices = np.flatnonzero(answers.numbers >= 0)
    if len(indices) == 0:
        raise InputError(
            "--within: found no allowed run within the bounds, expected narrower bounds"
        )
    random = largest.response
    # the same values with the noise of another flight
    repeats = yield Moves(answers.normal, np.roll(answers.numbers, 1), 0.0, count)
    share = noise_share(answers.response, repeats.response)
    order = indices[np.argsort(-answers.response[indices], kind="stable")]
    final, spare = runs // INDEPENDENT, min(2 * keys, runs // 8)
    budget, start = runs - 2 * count - final - keys - spare, 0
    while budget >= POPULATION:
        # by turns from an independent flight and from the worst so far
        number = order[start // 2 % len(order)]
        centre, noise = answers.normal[number], int(answers.numbers[number])
        if start % 2 == 1:
            centre, noise = largest.normal, largest.number
        generations = min(GENERATIONS, budget // POPULATION)
        flights = yield from _start(bounds, centre, noise, generations, [seed, start])
        budget, start = budget - flights, start + 1
    # the values of the worst case with the noise of independent runs
    copies = np.tile(largest.normal, (final, 1))
    yield Moves(copies, np.full(final, largest.number), 1.0, final)
    without = yield from _influence(largest, spare + budget)
    coordinates = np.clip(bounds.coordinates(largest.normal), -1.0, 1.0)
    about = (share, random, len(indices))
    return Worst(largest.number, largest.response, coordinates, without, *about)


def _influence(largest: Largest, spare: int) -> Generator[Moves, Answers, Vector]:
    """Response of the worst case with each value at its median, (keys,).

    If one of these flights is worse, it is the worst case, and they are repeated with its values.

    Args:
        largest: The worst case.
        spare: Number of flights for repetitions.
    """
    keys = len(largest.normal)
    while True:
        number = largest.number
        normal = np.where(np.eye(keys, dtype=bool), 0.0, largest.normal)
        answers = yield Moves(normal, np.full(keys, number), 0.0, keys)
        if largest.number == number:
            return np.where(answers.numbers < 0, np.nan, answers.response)
        if spare < keys:  # known are the values that are at their median
            return np.where(largest.normal == 0.0, largest.response, np.nan)
        spare -= keys


def at_bound(place: float, near: float) -> str | None:
    """Bound at which a coordinate is, in words; None for one whose size is below `near`."""
    if abs(place) < near:
        return None
    return "upper bound" if place > 0.0 else "lower bound"


def _start(
    bounds: Bounds, normal: Vector, noise: int, generations: int, seed: list[int]
) -> Generator[Moves, Answers, int]:
    """CMA-ES around a flight with the noise of this flight; returns the number of flights."""
    centre = np.clip(bounds.coordinates(normal), -0.9, 0.9)
    strategy = evolution(centre, FIRST_STEP, seed)
    for generation in range(generations):
        if strategy.stop():
            return max(generation, 1) * POPULATION
        samples: Sequence[Vector] = strategy.ask()
        coordinates = np.clip(np.array(samples)[:, : len(centre)], -1.0, 1.0)
        parents = np.full(POPULATION, noise)
        answers = yield Moves(bounds.normal(coordinates), parents, 0.0, POPULATION)
        strategy.tell(samples, _order(-answers.response))
    return generations * POPULATION


def evolution(centre: Vector, step: float, seed: list[int], population: int = POPULATION) -> Any:
    """Evolution strategy in the coordinates −1 to 1."""
    cma = library()
    random = np.random.default_rng(seed)
    options = {
        "bounds": [-1.0, 1.0],
        "popsize": population,
        "randn": lambda *shape: random.standard_normal(shape),
        "seed": np.nan,  # the generator of NumPy is not touched
        "verbose": -10,
        # ranks do not fall from one generation to the next; a small step ends a start
        "tolfun": 0.0,
        "tolfunhist": 0.0,
        "tolstagnation": 10**6,
        "tolx": 1e-3,
    }
    # the strategy needs two dimensions; a second one has no effect
    centre = np.append(centre, np.zeros(max(2 - len(centre), 0)))
    return cma.CMAEvolutionStrategy(centre, step, options)


def library() -> Any:
    """The package `cma`; raises `InputError` without it."""
    try:
        import cma  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise missing("search", "cma", "search") from None
    return cma


def _order(loss: Vector) -> list[float]:
    """Ranks of losses, which may be infinite."""
    return np.unique(loss, return_inverse=True)[1].astype(float).tolist()


def noise_share(first: Vector, other: Vector) -> float:
    """Share of the variance that is due to noise, from two responses to the same values, (n,).

    One minus the intraclass correlation; the mean of both is subtracted from both.
    """
    fine = np.isfinite(first) & np.isfinite(other)
    if np.sum(fine) < 3:
        return np.nan
    response, repeat = first[fine], other[fine]
    middle = np.mean([response, repeat])
    total = np.mean((response - middle) ** 2 + (repeat - middle) ** 2)
    if total == 0.0:
        return np.nan
    return float(
        np.clip(1.0 - 2.0 * np.mean((response - middle) * (repeat - middle)) / total, 0.0, 1.0)
    )
