"""Thrusters."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import positive, size
from gyrostat.spacecraft.actuators.thrusters import Thrusters

ARM = positive("length", None, "Distance of each thruster from the centre of mass.")
FORCE = positive("N", None, "Thrust of each thruster.")
MINIMUM = size(
    "time", 0.0, "Minimum on-time: minimum impulse bit over thrust; a shorter command does nothing."
)


@dataclass(frozen=True, eq=False)
class ThrustersKind(Kind):
    """Twelve thrusters in six pairs without net force, about +x, -x, +y, -y, +z and -z.

    See `gyrostat.spacecraft.Thrusters`; for `[unloading]` or a controller of your own. The command
    is the on-time of each thruster in the control period, s, in the order of the pairs.
    """

    name = "thrusters"
    arm: Annotated[Scalar, ARM]
    force: Annotated[Scalar, FORCE]
    minimum: Annotated[Scalar, MINIMUM]

    def make(self, context: Context) -> Thrusters:
        """Actuator."""
        assert context.period is not None
        return Thrusters.couples(self.arm, self.force, context.period, minimum=self.minimum)
