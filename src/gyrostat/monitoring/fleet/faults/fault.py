"""Base of the faults of a flying wheel: an event with a date and a size."""

from abc import ABC, abstractmethod
from collections.abc import MutableMapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.vehicle import FleetWheel


@dataclass(frozen=True)
class Fault(ABC):
    """Fault of one wheel; a kind is a file with a subclass.

    Attributes:
        wheel: Index of the wheel.
        day: Date of the beginning, days from the start of the flight.
        size: Size, whose meaning each kind states.
        duration: Days over which the fault grows; 0 for a step.
        seed: Seed of what is random in it.
    """

    name: ClassVar[str]
    """Name of the class of change."""
    usual_size: ClassVar[float]
    """Size where none is asked for."""
    usual_duration: ClassVar[float] = 0.0

    wheel: int
    day: float
    size: float
    duration: float = 0.0
    seed: int = 0

    @abstractmethod
    def apply(self, slow: MutableMapping[str, Vector], time: Vector, wheel: FleetWheel) -> None:
        """Change the parameters of the wheel in place.

        Args:
            slow: Field of `states.Slow` -> values of this wheel, (N,).
            time: Days from the start of the flight, (N,).
            wheel: Nominal wheel.
        """

    def growth(self, time: Vector) -> Vector:
        """Share of the fault that is reached, from 0 to 1, (N,)."""
        if self.duration <= 0.0:
            return np.where(time >= self.day, 1.0, 0.0)
        return np.clip((time - self.day) / self.duration, 0.0, 1.0)
