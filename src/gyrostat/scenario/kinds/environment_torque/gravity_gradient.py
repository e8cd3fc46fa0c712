"""Gravity gradient torque."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.circular_orbit import EitherOrbit
from gyrostat.scenario.component import Context
from gyrostat.scenario.schema import size
from gyrostat.spacecraft import GravityGradient


@dataclass(frozen=True, eq=False)
class GravityGradientKind(EitherOrbit):
    """Gravity gradient torque along [orbit], or in a circular Earth orbit.

    See `gyrostat.spacecraft.GravityGradient`.
    """

    name = "gravity_gradient"
    scale: Annotated[Scalar, size("1", 1.0, "Factor on the torque.", source="torque")]

    def make(self, context: Context) -> GravityGradient:
        """Torque."""
        return GravityGradient(context.orbit or self.circular(), self.scale)
