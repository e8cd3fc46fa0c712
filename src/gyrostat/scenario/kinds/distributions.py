"""Distributions of dispersed values, found in their folder."""

from collections.abc import Mapping

import numpy as np

from gyrostat.core.classes_of import classes_of
from gyrostat.core.errors import InputError
from gyrostat.scenario.distribution import Distribution
from gyrostat.scenario.kinds import dispersion as folder
from gyrostat.scenario.scenario import Dispersion, Scenario

DISTRIBUTIONS: Mapping[str, type[Distribution]] = {
    kind.name: kind for kind in classes_of(folder, Distribution)
}
"""Name -> distribution."""
NAMED = tuple(name for name, kind in DISTRIBUTIONS.items() if kind.parameters())
"""Distributions that a scenario file can name; the others are made from files."""


def distribution_of(dispersion: Dispersion, values: Mapping[str, float]) -> Distribution:
    """Distribution of a dispersion.

    Args:
        dispersion: Dispersion.
        values: Nominal values of the scenario, SI.

    Raises:
        InputError: There is no such distribution, or it has other parameters.
    """
    label = f"dispersion of {', '.join(dispersion.keys)}"
    kind = DISTRIBUTIONS.get(dispersion.distribution)
    if kind is None:
        raise InputError(
            f"{label}: found distribution {dispersion.distribution!r}, expected one of "
            f"{', '.join(DISTRIBUTIONS)}"
        )
    names = kind.parameters()
    lengths = {len(row) for row in dispersion.parameters}
    if len(dispersion.parameters) != len(dispersion.keys) or (names and lengths != {len(names)}):
        raise InputError(
            f"{label}: found parameters {dispersion.parameters}, expected "
            f"({', '.join(names) or 'a row'}) for each key"
        )
    nominal = np.array([values[key] for key in dispersion.keys], float)
    return kind.of(nominal, np.array(dispersion.parameters, float))


def distributions_of(scenario: Scenario) -> list[Distribution]:
    """Distribution of each dispersion of a scenario.

    Raises:
        InputError: A dispersion cannot be.
    """
    distributions = []
    for dispersion in scenario.dispersions:
        distribution = distribution_of(dispersion, scenario.values)
        for name, expected in distribution.faults():
            raise InputError(
                f"dispersion of {', '.join(dispersion.keys)}: found {dispersion.distribution} with "
                f"{name} of {dispersion.parameters}, expected {expected}"
            )
        distributions.append(distribution)
    return distributions
