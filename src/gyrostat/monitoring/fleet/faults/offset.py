"""Torque that does not change its sign with the speed, or an offset of the current."""

from collections.abc import MutableMapping
from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel


class Offset(Fault):
    """`size` is the torque, as a share of the nominal Coulomb torque."""

    name: ClassVar[str] = "offset"
    usual_size: ClassVar[float] = 0.1
    usual_duration: ClassVar[float] = 0.0

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        slow["offset"] += self.size * wheel.coulomb * self.growth(time)
