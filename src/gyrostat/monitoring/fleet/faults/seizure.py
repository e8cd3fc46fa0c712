"""Seizure: drag that grows until the wheel stops."""

from collections.abc import MutableMapping
from typing import ClassVar

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel


class Seizure(Fault):
    """`size` is the final Coulomb torque as a multiple of the nominal one.

    The drag grows exponentially over `duration`, then the wheel stays at the final drag.
    """

    name: ClassVar[str] = "seizure"
    usual_size: ClassVar[float] = 200.0
    usual_duration: ClassVar[float] = 1.0

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        grown = np.exp(np.log(self.size) * self.growth(time))
        slow["coulomb"] += wheel.coulomb * (grown - 1.0)
