"""Friction feed-forward from a Kalman filter without a friction model."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control import FrictionFilterFeedForward
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import FrictionTorqueFilter
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import positive


@dataclass(frozen=True, eq=False)
class FrictionFilter(Kind):
    """Friction feed-forward from a Kalman filter.

    It estimates the friction torque from the measured momentum and the commanded torque of each
    wheel, without a friction model (`gyrostat.control.FrictionFilterFeedForward`).
    """

    name = "friction_filter"
    momentum_sigma: Annotated[
        Scalar, positive("momentum", None, "Standard deviation of a measured wheel momentum.")
    ]
    torque_drift: Annotated[Scalar, positive("N·m/√s", None, "Random walk of the friction torque.")]
    initial_sigma: Annotated[
        Scalar,
        positive(
            "1",
            0.1,
            "Initial standard deviation of momentum, N·m·s, and of friction torque, N·m.",
        ),
    ]

    def make(self, context: Context) -> FrictionFilterFeedForward:
        """Compensator."""
        assert context.spacecraft is not None
        wheels = context.spacecraft.wheels
        return FrictionFilterFeedForward(
            context.controller,
            FrictionTorqueFilter(**self.options()),
            jnp.asarray(wheels.axes),
            jnp.asarray(wheels.inertia),
            jnp.asarray(wheels.torque_limit),
            context.delay,
        )
