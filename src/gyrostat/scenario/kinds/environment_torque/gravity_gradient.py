"""Gravity gradient torque."""

from dataclasses import dataclass

from gyrostat.scenario.circular_orbit import EitherOrbit
from gyrostat.scenario.component import Context
from gyrostat.spacecraft import GravityGradient


@dataclass(frozen=True, eq=False)
class GravityGradientKind(EitherOrbit):
    """Gravity gradient torque along [orbit], or in a circular Earth orbit.

    See `gyrostat.spacecraft.GravityGradient`.
    """

    name = "gravity_gradient"

    def make(self, context: Context) -> GravityGradient:
        """Torque."""
        return GravityGradient(context.orbit or self.circular())
