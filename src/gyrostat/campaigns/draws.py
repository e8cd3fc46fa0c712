"""Random draws of each run, as functions of seed and run number.

Random bits are from a counter-based generator keyed by seed, run and dispersion (Salmon et al.,
"Parallel random numbers: as easy as 1, 2, 3", 2011; JAX's threefry). The values of a run depend on
nothing else, and an additional dispersion does not change the draws of the others. The key of a
dispersion is 128 bits of the SHA-256 digest of its first scenario key, so that draws are
independent.
"""

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.errors import InputError
from gyrostat.core.threefry import Words, threefry
from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.designs import phase_starts
from gyrostat.scenario.kinds.distributions import distributions_of
from gyrostat.scenario.kinds.orbits import check_own_orbits, has_own_orbits
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.scenario import INERTIA, Scenario
from gyrostat.scenario.structure import measured_names, structure_of
from gyrostat.spacecraft import check_inertia
from gyrostat.wheel.array import LIMIT_TOLERANCE

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
    for first in range(0, runs, AT_ONCE):
        numbers = range(first, min(first + AT_ONCE, runs))
        check_values(scenario, numbers, draw(scenario, seed, np.array(numbers))[0])


def check_values(scenario: Scenario, numbers: range, values: Matrix) -> None:
    """Validate dispersed values.

    Args:
        scenario: Scenario with dispersions.
        numbers: Numbers of the runs, for messages.
        values: Values, (n, keys).

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
    _check_combinations(scenario, numbers, values)


def _check_combinations(scenario: Scenario, numbers: range, values: Matrix) -> None:
    columns = dict(zip(scenario.dispersed, values.T, strict=True))
    _check_speeds(scenario, numbers, columns)
    _check_sensing(scenario, numbers, columns)
    if has_own_orbits(scenario.dispersed):
        check_own_orbits(scenario, values)
    if any(key.startswith("body.inertia.") for key in scenario.dispersed):
        _check_inertias(scenario, numbers, columns)
    if not any(key.startswith("event.") for key in scenario.dispersed):
        return
    structure = structure_of(scenario)
    for number, row in zip(numbers, values.tolist(), strict=True):
        of_run = {**scenario.values, **dict(zip(scenario.dispersed, row, strict=True))}
        starts = phase_starts(structure, of_run)
        if starts != sorted(starts):
            raise InputError(
                f"dispersion of event times: found events in another order in run {number}, "
                "expected times that do not overlap"
            )


def _check_inertias(scenario: Scenario, numbers: range, columns: Mapping[str, Vector]) -> None:
    """Validate the inertia of the body in all runs at once; raises `InputError`."""
    keys = [f"body.inertia.{end}" for end in INERTIA]
    values = [columns.get(key, scenario.values[key]) for key in keys]
    xx, yy, zz, xy, xz, yz = np.broadcast_arrays(*values)
    matrices = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
    try:
        check_inertia(matrices)
    except InputError:  # find the run
        for number, matrix in zip(numbers, matrices, strict=True):
            try:
                check_inertia(matrix)
            except InputError as error:
                raise InputError(f"dispersion of body.inertia in run {number}: {error}") from None


def _check_speeds(scenario: Scenario, numbers: range, columns: Mapping[str, Vector]) -> None:
    """Validate that no wheel starts above its momentum limit; raises `InputError`."""
    for wheel in scenario.wheels:
        speed, inertia, limit = (
            columns.get(key, scenario.values[key])
            for key in (f"wheel.{wheel}.{n}" for n in ("speed", "inertia", "momentum_limit"))
        )
        beyond = np.abs(inertia * speed) > limit * (1.0 + LIMIT_TOLERANCE)
        _refuse(beyond, numbers, f"wheel.{wheel}", "a start beyond its momentum limit")


def _check_sensing(scenario: Scenario, numbers: range, columns: Mapping[str, Vector]) -> None:
    """Validate the times of sensor faults and the limits of the guard; raises `InputError`."""
    faults = [f"event.{event.name}" for event in scenario.events if event.sensor is not None]
    pairs = {key: (f"{key}.time", f"{key}.until", "an end before the start") for key in faults}
    if scenario.guard is not None:
        for name in measured_names(scenario):
            key = f"guard.{name}"
            pairs[key] = (f"{key}_lower", f"{key}_upper", "an upper limit below the lower one")
    for key, (low, high, fault) in pairs.items():
        least, most = (columns.get(end, scenario.values[end]) for end in (low, high))
        _refuse(least >= most, numbers, key, fault)


def _refuse(is_wrong: Any, numbers: range, key: str, fault: str) -> None:
    """Raise `InputError` for the first run in which a dispersion is wrong, if there is one."""
    if np.any(is_wrong):
        run = numbers[int(np.argmax(np.broadcast_to(is_wrong, len(numbers))))]
        raise InputError(f"dispersion of {key}: found {fault} in run {run}, expected less spread")
