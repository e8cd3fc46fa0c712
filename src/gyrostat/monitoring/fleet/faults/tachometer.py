"""Tachometer that misses pulses."""

from collections.abc import MutableMapping
from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel


class Tachometer(Fault):
    """`size` is the relative error of the measured speed."""

    name: ClassVar[str] = "tachometer fault"
    usual_size: ClassVar[float] = -0.02
    usual_duration: ClassVar[float] = 0.0

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        del wheel
        slow["tachometer"] += self.size * self.growth(time)
