"""Conditions on the measured direction of the Sun."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, ClassVar

from gyrostat.control.attitude.sun_condition import SunCondition
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import Context, Kind, part_named
from gyrostat.scenario.schema import direction, positive


@dataclass(frozen=True, eq=False)
class SunSeen(Kind):
    """As `conditions`, and the Sun is seen within an angle of a body axis.

    It needs a `[[sensor]]` named `sun_sensor` or `coarse_sun_sensors`.
    """

    name = "sun_seen"
    is_lost: ClassVar[bool] = False
    needs = frozenset({part_named("sensor", "sun_sensor", "coarse_sun_sensors")})
    axis: Annotated[Vector3, direction("Body axis, of any length.")]
    angle: Annotated[
        Scalar, positive("angle", pi, "Angle from the axis; by default any direction.", most=pi)
    ]

    def make(self, context: Context) -> SunCondition:
        """Condition."""
        return SunCondition(self.axis, self.angle, self.is_lost)


@dataclass(frozen=True, eq=False)
class SunLost(SunSeen):
    """As `conditions`, and the Sun is not seen within an angle of a body axis, as in an eclipse.

    It needs a `[[sensor]]` named `sun_sensor` or `coarse_sun_sensors`.
    """

    name = "sun_lost"
    is_lost = True
