"""Wear of wheels: their friction over that of the friction model."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, limit, positive
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.array import listed


class WheelWear(Checked):
    """Wear of each wheel for the null-space control, given or estimated.

    The estimate is the friction torque in the direction of rotation, over that of the friction
    model at the measured speed, at least 1, after a low-pass filter. It is unchanged while a wheel
    is not measured.

    Attributes:
        given: Wear at the start, (wheels,) or one for all, above 0; it remains without an estimate.
        time: Time constant of the low-pass filter, s; infinite: no estimate.
    """

    given: Annotated[PerWheel | float, positive("wear of a wheel")] = eqx.field(
        converter=listed, default=1.0
    )
    time: Annotated[Scalar, limit("wear time", "s")] = np.inf

    def start(self, count: int) -> PerWheel:
        """Wear at the start, (wheels,)."""
        return jnp.ones(count) * self.given

    def __call__(
        self,
        wear: PerWheel,
        friction: PerWheel,
        speed: PerWheel,
        model: Any,
        used: Bool[Array, " wheels"],
        period: Scalar,
    ) -> PerWheel:
        """Wear after a sample, (wheels,).

        Args:
            wear: Wear before the sample, (wheels,).
            friction: Measured friction torque, (wheels,), N·m, positive if it opposes a positive
                speed.
            speed: Wheel speeds relative to the body, (wheels,), rad/s.
            model: Static friction model, see `gyrostat.wheel.friction.static_curve`.
            used: Whether each speed is measured, (wheels,).
            period: Time since the last sample, s.
        """
        sense = jnp.where(speed < 0.0, -1.0, 1.0)
        drag = sense * model.torque(speed, sense)
        valid = used & (drag > 0.0)
        ratio = jnp.maximum(sense * friction / jnp.where(valid, drag, 1.0), 1.0)
        share = period / (self.time + period)
        return wear + share * jnp.where(valid, ratio - wear, 0.0)
