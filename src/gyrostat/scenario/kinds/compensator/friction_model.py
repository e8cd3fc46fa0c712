"""Friction feed-forward from the nominal friction model."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control import FrictionFeedForward
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import positive, size
from gyrostat.wheel.friction import static_curve


@dataclass(frozen=True, eq=False)
class FrictionModel(Kind):
    """Friction feed-forward from the nominal friction model at the measured speed.

    See `gyrostat.control.FrictionFeedForward`.
    """

    name = "friction_model"
    band: Annotated[
        Scalar, positive("speed", 1.0, "Speed below which the sign of the speed is ignored.")
    ]
    share: Annotated[Scalar, size("1", 1.0, "Fraction of the friction torque that is compensated.")]

    def make(self, context: Context) -> FrictionFeedForward:
        """Compensator."""
        assert context.spacecraft is not None
        wheels = context.spacecraft.wheels
        return FrictionFeedForward(
            context.controller,
            static_curve(wheels.friction),
            jnp.asarray(wheels.torque_limit),
            **self.options(),
        )
