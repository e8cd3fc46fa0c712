"""Random draws of each run, as functions of seed and run number.

Random bits are from a counter-based generator keyed by seed, run and dispersion (Salmon et al.,
"Parallel random numbers: as easy as 1, 2, 3", 2011; JAX's threefry). The values of a run depend on
nothing else, and an additional dispersion does not change the draws of the others. The key of a
dispersion is 128 bits of the SHA-256 digest of its first scenario key, so that draws are
independent.
"""

import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.errors import InputError
from gyrostat.core.threefry import Words, threefry
from gyrostat.core.types import Matrix
from gyrostat.runs.run_relations import run_relations
from gyrostat.scenario.kinds.distributions import distributions_of
from gyrostat.scenario.kinds.orbits import check_own_orbits, has_own_orbits
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario

AT_ONCE = 4096
"""Number of runs that are validated at a time, which bounds the memory."""
_NOISE, _VALUES = 0, 1


def _code(key: str) -> list[int]:
    """Four words of 32 bits that identify a key."""
    return np.frombuffer(hashlib.sha256(key.encode()).digest()[:16], "<u4").tolist()


def draw(scenario: Scenario, seed: int, runs: ArrayLike) -> tuple[Matrix, Words]:
    """Draw the dispersed values of runs.

    Args:
        scenario: Scenario with dispersions.
        seed: Seed of the campaign.
        runs: Indices of the runs, (n,).

    Returns:
        Values, (n, keys), in the order of `scenario.dispersed`, SI; random keys of the noise as
        words, (n,).
    """
    return values_at(scenario, shares(scenario, seed, runs)), noise_keys(seed, runs)


def shares(scenario: Scenario, seed: int, runs: ArrayLike) -> Matrix:
    """Uniform random numbers of runs, between 0 and 1, (n, keys), in the order of `draw`."""
    dispersions = scenario.dispersions
    size = max((len(d.keys) for d in dispersions), default=1)
    keys = threefry(seed, runs)
    dispersion_keys = np.repeat(threefry(keys, _VALUES)[:, None], len(dispersions), axis=1)
    for word in np.array([_code(d.keys[0]) for d in dispersions]).reshape(-1, 4).T:
        dispersion_keys = threefry(dispersion_keys, word)
    bits = threefry(dispersion_keys[..., None], np.arange(size))
    # midpoints of 2^53 equal intervals of [0, 1], so that neither 0 nor 1 is drawn
    share: Matrix = ((bits >> np.uint64(11)).astype(np.float64) + 0.5) * 2.0**-53
    columns = [share[:, k, : len(dispersion.keys)] for k, dispersion in enumerate(dispersions)]
    return np.concatenate([np.zeros((len(keys), 0)), *columns], axis=1)


def values_at(scenario: Scenario, share: Matrix) -> Matrix:
    """Transform independent uniform numbers to dispersed values.

    Args:
        scenario: Scenario with dispersions.
        share: Numbers between 0 and 1, (n, keys), in the order of `scenario.dispersed`.

    Returns:
        Values, (n, keys), SI.
    """
    ends = np.cumsum([len(dispersion.keys) for dispersion in scenario.dispersions])
    parts = np.split(share, ends, axis=1)
    pairs = zip(distributions_of(scenario), parts[:-1], strict=True)
    columns = [distribution.quantile(part) for distribution, part in pairs]
    return np.concatenate([np.zeros((len(share), 0)), *columns], axis=1)


def noise_keys(seed: int, runs: ArrayLike) -> Words:
    """Random keys of the noise of runs, (n,); see `draw`."""
    return threefry(threefry(seed, runs), _NOISE)


def check_draws(scenario: Scenario, seed: int, runs: int) -> None:
    """Validate the drawn values of all runs before the campaign starts.

    Raises:
        InputError: A drawn value is not allowed, an inertia is impossible, or events change their
            order.
    """
    relations = dispersed_relations(scenario)
    for first in range(0, runs, AT_ONCE):
        numbers = range(first, min(first + AT_ONCE, runs))
        check_values(scenario, numbers, draw(scenario, seed, np.array(numbers))[0], relations)


def dispersed_relations(scenario: Scenario) -> list[Relation]:
    """Relations of the values of each run, in which some dispersed one takes part."""
    dispersed = {*scenario.dispersed}
    return [each for each in run_relations(scenario) if not dispersed.isdisjoint(each.keys)]


def check_values(
    scenario: Scenario, numbers: range, values: Matrix, relations: Sequence[Relation]
) -> None:
    """Validate dispersed values.

    Args:
        scenario: Scenario with dispersions.
        numbers: Numbers of the runs, for messages.
        values: Values, (n, keys).
        relations: `dispersed_relations` of the scenario, which take milliseconds to make.

    Raises:
        InputError: As for `check_draws`.
    """
    entries = numbers_of(scenario)
    for key, column in zip(scenario.dispersed, values.T, strict=True):
        entry = entries[key]
        # the allowed values are one interval, so that the extremes suffice
        for index in (np.argmin(column), np.argmax(column)):
            value = float(column[index])
            if not entry.allows(value) or not np.isfinite(value):
                raise InputError(
                    f"dispersion of {key}: found {value:g} in run {numbers[int(index)]}, "
                    f"expected {entry.range(value)}: use less spread, or a distribution with limits"
                )
    columns = dict(zip(scenario.dispersed, values.T, strict=True))
    if has_own_orbits(scenario.dispersed):
        check_own_orbits(scenario, values)
    every = {**scenario.values, **columns}
    for relation in relations:
        holds = relation.holds(every)
        if not np.all(holds):
            keys = [key for key in relation.keys if key in columns]
            row = int(np.argmin(np.broadcast_to(holds, len(numbers))))
            of_run = {key: np.broadcast_to(every[key], len(numbers))[row] for key in relation.keys}
            raise InputError(
                f"dispersion of {', '.join(keys)}: in run {numbers[row]}, "
                f"{relation.message(of_run)}: use less spread"
            )
