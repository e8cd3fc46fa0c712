"""Stiction: a breakaway torque that shows at zero crossings."""

from collections.abc import MutableMapping
from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel


class Stiction(Fault):
    """`size` is the growth of the breakaway torque, as a share of the nominal Coulomb torque."""

    name: ClassVar[str] = "stiction"
    usual_size: ClassVar[float] = 1.0
    usual_duration: ClassVar[float] = 0.0

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        slow["excess"] += self.size * wheel.coulomb * self.growth(time)
