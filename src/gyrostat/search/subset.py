"""Subset simulation: a small failure probability as a product of larger conditional ones.

S.-K. Au and J. L. Beck, "Estimation of small failure probabilities in high dimensions by subset
simulation", Probabilistic Engineering Mechanics 16, 2001. The chains of a level move by conditional
sampling with an adaptive step, I. Papaioannou, W. Betz, K. Zwirglmaier and D. Straub, "MCMC
algorithms for subset simulation", Probabilistic Engineering Mechanics 41, 2015, section 4: in
standard normal space, x' = √(1 − σ²) x + σ ξ leaves the normal distribution unchanged (it is the
preconditioned Crank-Nicolson proposal), and a proposal is accepted if it stays in the level. The
noise moves with it: each part of a run has its own independent noise, which is drawn again with
probability 1 − √(1 − σ²); a linear function of many parts then has the same correlation with its
former value as x' with x.
"""

from collections.abc import Generator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.search.moves import Answers, Moves, first_moves

STEPS = 5
"""Flights of a chain; its inverse is the conditional probability of a level."""
ACCEPTED = 0.44
"""Share of accepted proposals to which the step is adapted; optimal for one dimension."""
FIRST_STEP = 0.6
"""Step before the first adaptation."""
LEVELS = 9
"""Largest number of levels: probabilities down to 5⁻⁹ = 5e-7 and, with the share of failures in
the last one, below."""
REACHED, STUCK, TOO_RARE = "reached", "stuck", "too rare"
"""How a replication ends."""
FEWEST = 5
"""Fewest flights above a level from which the next one can start."""


class Level(NamedTuple):
    """Level of a subset simulation.

    Attributes:
        bound: Response that its flights reach.
        probability: Probability of reaching it, given the level before.
        accepted: Share of accepted proposals; NaN for the first level.
        normal: Standard normal numbers of its flights, (n, keys).
        response: Their responses, (n,).
        numbers: Numbers of their flights, (n,).
        ancestors: Index of the flight of the first level from which each descends, (n,).
    """

    bound: float
    probability: float
    accepted: float
    normal: Matrix
    response: Vector
    numbers: NDArray[np.int64]
    ancestors: NDArray[np.int64]


class Replication(NamedTuple):
    """Result of one subset simulation.

    Attributes:
        levels: Levels, the first with independent draws.
        probability: Estimated probability of a response above 0; NaN if it was not reached.
        variation: Coefficient of variation that the correlations within its own chains explain.
        ended: `REACHED`, `STUCK` (the responses do not rise any further) or `TOO_RARE`.
    """

    levels: tuple[Level, ...]
    probability: float
    variation: float
    ended: str


def flights_of(chains: int) -> int:
    """Largest number of flights of a replication with this number of chains."""
    return chains * (STEPS + (STEPS - 1) * LEVELS)


def subset_simulation(chains: int, seed: list[int]) -> Generator[Moves, Answers, Replication]:
    """Estimate the probability that the response is positive.

    Args:
        chains: Chains in each level; a level has `STEPS` flights for each.
        seed: Seed of the proposals.

    Yields:
        Flights to simulate; their answers are sent back.

    Returns:
        The estimate.
    """
    random = np.random.default_rng(seed)
    count, step = chains * STEPS, FIRST_STEP
    answers = yield first_moves(count)
    level = Level(
        *(-np.inf, 1.0, np.nan, answers.normal, answers.response, answers.numbers),
        np.arange(count),
    )
    levels, squares = [level], []
    while True:
        bound, ended = _next_bound(level)
        failures = level.response > 0.0
        in_level = failures if ended else level.response >= bound
        if ended is None and len(levels) > LEVELS:
            ended, in_level = (REACHED if np.any(failures) else TOO_RARE), failures
        squares.append(_squared_variation(in_level, chains, independent=len(levels) == 1))
        share = float(np.mean(in_level))
        if ended is not None:
            product = float(np.prod([each.probability for each in levels]))
            probability = product * share if ended == REACHED else np.nan
            return Replication(tuple(levels), probability, float(np.sqrt(sum(squares))), ended)
        indices = _starts(np.flatnonzero(in_level), chains, random)
        level, step = yield from _level(level, bound, share, indices, step, random)
        levels.append(level)


def _next_bound(level: Level) -> tuple[float, str | None]:
    """Response that the next level has to reach, and how the simulation ends, if it does."""
    response = np.sort(level.response)[::-1]
    bound = response[len(response) // STEPS - 1]
    if bound > 0.0:
        return 0.0, REACHED
    higher = level.response[level.response > level.bound]
    if bound <= level.bound:  # too many equal responses
        if len(higher) < FEWEST:
            return 0.0, REACHED if np.any(level.response > 0.0) else STUCK
        bound = np.min(higher)
    return float(bound), None


def _starts(
    indices: NDArray[np.int64], chains: int, random: np.random.Generator
) -> NDArray[np.int64]:
    """Flights from which the chains start, each at most once if there are enough."""
    if len(indices) >= chains:
        return random.permutation(indices)[:chains]
    return np.concatenate([indices, random.choice(indices, chains - len(indices))])


def _level(
    previous: Level,
    bound: float,
    share: float,
    indices: NDArray[np.int64],
    step: float,
    random: np.random.Generator,
) -> Generator[Moves, Answers, tuple[Level, float]]:
    """Chains of a level from the given flights of the level before; also the adapted step."""
    normal, response = previous.normal[indices], previous.response[indices]
    numbers, ancestors = previous.numbers[indices], previous.ancestors[indices]
    spread = np.minimum(np.std(normal, axis=0), 1.0)
    rows, rates = [(normal, response, numbers)], []
    for turn in range(1, STEPS):
        sigma = np.minimum(step * spread, 1.0)
        noise = random.standard_normal(normal.shape)
        proposed = np.sqrt(1.0 - sigma**2) * normal + sigma * noise
        replaced = 1.0 - np.sqrt(1.0 - min(step, 1.0) ** 2)
        answers = yield Moves(proposed, numbers, replaced, len(indices))
        fine = answers.response >= bound
        normal = np.where(fine[:, None], answers.normal, normal)
        response = np.where(fine, answers.response, response)
        numbers = np.where(fine, answers.numbers, numbers)
        rows.append((normal, response, numbers))
        rates.append(float(np.mean(fine)))
        step = float(np.clip(step * np.exp((rates[-1] - ACCEPTED) / np.sqrt(turn)), 0.01, 2.0))
    normal, response, numbers = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    rate, ancestors = float(np.mean(rates)), np.tile(ancestors, STEPS)
    return Level(bound, share, rate, normal, response, numbers, ancestors), step


def _squared_variation(in_level: NDArray[np.bool_], chains: int, *, independent: bool) -> float:
    """Squared coefficient of variation of the share of flights that reach a level.

    Au and Beck, equations 27 to 29: the correlation within chains makes it larger.
    """
    share = float(np.mean(in_level))
    if not 0.0 < share < 1.0:
        return 0.0
    square = (1.0 - share) / (share * len(in_level))
    if independent:
        return square
    steps = in_level.reshape(-1, chains).astype(float) - share
    lags = range(1, len(steps))
    covariance = [float(np.mean(steps[lag:] * steps[:-lag])) for lag in lags]
    weights = [1.0 - lag / len(steps) for lag in lags]
    excess = 2.0 * float(np.dot(weights, covariance)) / (share * (1.0 - share))
    return square * max(1.0 + excess, 1.0)
