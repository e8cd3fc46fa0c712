"""Torque bursts of an unstable cage."""

from collections.abc import MutableMapping
from typing import ClassVar

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.vehicle import FleetWheel

PER_DAY = 6.0
LENGTH = 20.0 / 1440.0
"""Mean duration of a burst, days."""


class TorqueBursts(Fault):
    """`size` is the size of the added drag noise in a burst, as a share of the Coulomb torque.

    Bursts begin as a Poisson process, six a day, and last 20 minutes in the mean (exponential).
    """

    name: ClassVar[str] = "torque bursts"
    usual_size: ClassVar[float] = 0.3

    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """See `Fault.apply`."""
        for day in range(int(time[0]) - 1, int(time[-1]) + 1):
            if day < int(self.day):
                continue
            random = np.random.default_rng([self.seed, day, 11])
            count = random.poisson(PER_DAY)
            begin = np.maximum(day + random.uniform(0.0, 1.0, count), self.day)
            end = begin + random.exponential(LENGTH, count)
            for first, last in zip(begin, end, strict=True):
                there = (time >= first) & (time < last)
                slow["burst"][there] = self.size * wheel.coulomb * self.growth(time[there])
