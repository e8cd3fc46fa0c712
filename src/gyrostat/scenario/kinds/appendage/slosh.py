"""Propellant in motion."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.appendage_kind import AppendageKind
from gyrostat.scenario.schema import direction, positive, vector


@dataclass(frozen=True, eq=False)
class Slosh(AppendageKind):
    """Propellant as a mass on a spring along a line (`gyrostat.spacecraft.spring_mass`)."""

    name = "slosh"
    mass: Annotated[Scalar, positive("mass", None, "Mass that moves.", source="slosh")]
    position: Annotated[Vector3, vector("length", "Position of the mass at rest, body axes.")]
    direction: Annotated[Vector3, direction("Direction of its motion, of any length.", 0.0)]
