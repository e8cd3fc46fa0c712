"""Numbers of a scenario or spacecraft, as the checks of unlikely ones look at them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.requirement import Requirement
from gyrostat.scenario.scenario import AXES, INERTIA, Dispersion
from gyrostat.scenario.schema import Key
from gyrostat.spacecraft.spacecraft import check_inertia, check_rotors
from gyrostat.wheel.friction_laws import Law

Lines = Iterator[tuple[str, str]]
"""Pairs of a key, and what is unlikely about its number."""


def inertia_of(values: Mapping[str, float]) -> Matrix:
    """Body inertia from its keys, (3, 3), kg·m²."""
    matrix = np.zeros((3, 3))
    for end in INERTIA:
        row, column = (AXES.index(axis) for axis in end)
        matrix[row, column] = matrix[column, row] = values[f"body.inertia.{end}"]
    return matrix


def check_inertias(
    values: Mapping[str, float], wheels: Iterable[str], axes: Sequence[Sequence[float]]
) -> None:
    """Validate that the body inertia, with the rotors locked, is one that a body can have.

    Args:
        values: Full key -> number, SI.
        wheels: Names of the wheels.
        axes: Spin axes of the wheels, (wheels, 3).

    Raises:
        InputError: It is not positive definite, not that of a body, or not above that of the
            rotors.
    """
    inertia = inertia_of(values)
    check_inertia(inertia)
    rotors = np.array([values[f"wheel.{wheel}.inertia"] for wheel in wheels])
    check_rotors(inertia, np.array(axes).T, rotors)


@dataclass(frozen=True)
class Numbers:
    """Numbers that belong together.

    Attributes:
        values: Full key -> number, SI.
        wheels: Names of the wheels.
        axes: Spin axes of the wheels, (wheels, 3).
        law: Friction law of the wheels.
        surfaces: Facets, see `Scenario.surfaces`.
        sensors: Kind of the sensors; empty for a spacecraft alone.
        entries: Full key -> schema entry; empty for a spacecraft alone.
        dispersions: Dispersions of the scenario.
        requirements: Pointing requirements of the scenario.
        command_delay: Control periods until a command reaches the wheels.
    """

    values: Mapping[str, float]
    wheels: tuple[str, ...]
    axes: tuple[tuple[float, ...], ...]
    law: Law
    surfaces: tuple[tuple[float, ...], ...] = ()
    sensors: str = ""
    entries: Mapping[str, Key] = field(default_factory=dict)
    dispersions: tuple[Dispersion, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    command_delay: int = 0

    def of_wheels(self, name: str, default: float = inf) -> Vector:
        """Value of each wheel, (wheels,)."""
        return np.array([self.values.get(f"wheel.{w}.{name}", default) for w in self.wheels])

    def inertia_locked(self) -> Matrix:
        """Inertia with all rotors locked to the body, (3, 3), kg·m²."""
        axes = np.array(self.axes)
        return inertia_of(self.values) + (axes.T * self.of_wheels("inertia")) @ axes
