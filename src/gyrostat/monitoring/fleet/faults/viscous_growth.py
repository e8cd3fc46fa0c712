"""Growth of the viscous coefficient."""

from collections.abc import MutableMapping
from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel


class ViscousGrowth(Fault):
    """`size` is the relative growth."""

    name: ClassVar[str] = "viscous growth"
    usual_size: ClassVar[float] = 0.2
    usual_duration: ClassVar[float] = 30.0

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        del wheel
        slow["viscous"] *= 1.0 + self.size * self.growth(time)
