"""Base of plants around a gyrostat."""

from typing import Any

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Vector3
from gyrostat.core.checked import Checked
from gyrostat.spacecraft.spacecraft import Spacecraft


class GyrostatWrapper(Checked):
    """Plant that adds something to a gyrostat, and is otherwise that gyrostat.

    Attributes:
        gyrostat: Wrapped plant.
    """

    gyrostat: eqx.AbstractVar[Any]

    @property
    def spacecraft(self) -> Spacecraft:
        """Body and wheels."""
        return self.gyrostat.spacecraft

    @property
    def failures(self) -> Any:
        """Wheel failures; see `Gyrostat`."""
        return self.gyrostat.failures

    def rate(self, state: Any) -> Vector3:
        """Body rate in body axes, (3,), rad/s."""
        return self.gyrostat.rate(state)

    def balanced_rate(self, state: Any) -> Vector3:
        """Body rate without the jitter of wheel imbalance, in body axes, (3,), rad/s."""
        return getattr(self.gyrostat, "balanced_rate", self.gyrostat.rate)(state)

    def diverged(self, state: Any) -> Bool[Array, ""]:
        """See `Gyrostat.diverged`."""
        return self.gyrostat.diverged(state)

    def record(self, state: Any, command: Any) -> Any:
        """Record of the gyrostat."""
        return self.gyrostat.record(state, command)
