"""Change of the motor constant."""

from collections.abc import MutableMapping
from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel


class MotorConstant(Fault):
    """`size` is the relative change of the torque per ampere."""

    name: ClassVar[str] = "motor constant"
    usual_size: ClassVar[float] = -0.02
    usual_duration: ClassVar[float] = 0.0

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        del wheel
        slow["gain"][:] = (1.0 + slow["gain"]) * (1.0 + self.size * self.growth(time)) - 1.0
