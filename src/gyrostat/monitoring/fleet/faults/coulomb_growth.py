"""Growth of the Coulomb torque."""

from collections.abc import MutableMapping
from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel


class CoulombGrowth(Fault):
    """`size` is the relative growth."""

    name: ClassVar[str] = "Coulomb growth"
    usual_size: ClassVar[float] = 0.1
    usual_duration: ClassVar[float] = 30.0

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        del wheel
        slow["coulomb"] *= 1.0 + self.size * self.growth(time)
