"""Friction feed-forward: adds modelled friction to the wheel torques of another controller."""

from typing import Annotated, Any

from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.friction import Friction

SOFTNESS = 0.2
"""Demanded torque over the breakaway torque at which a wheel at rest gets all of the latter."""


class FrictionFeedForward(Checked):
    """m_i = u_i + share F_i(W_i), with W_i the measured speed of wheel i.

    Below `band` the sign of a noisy speed says nothing: there the friction is the breakaway torque
    in the sense of the demanded torque, and a small demand gets a part of it, so that nothing hunts
    about rest. A wheel of which the controller demands exactly nothing, as of a failed one, gets
    nothing.

    Attributes:
        controller: that demands the torques u_i.
        friction: of the wheels, as the controller knows it.
        torque_limit: (wheels,) N·m.
        band: rad/s.
        share: of the friction that is compensated.
    """

    controller: Any
    friction: Friction
    torque_limit: PerWheel
    band: Annotated[Scalar, positive("speed band of the compensator", "rad/s")]
    share: Annotated[Scalar, size("share of the compensator")] = 1.0

    def start(self, period: Scalar) -> Any:
        """Memory of the controller."""
        return self.controller.start(period)

    def predicted(self, memory: Any, measurement: Any, command: Any) -> Any:
        """Memory of the controller one period later without a sample.

        Args:
            memory: of the controller.
            measurement: last one that was accepted.
            command: that is sent.
        """
        return predicted(self.controller, memory, measurement, command)

    def __call__(self, memory: Any, measurement: Any) -> tuple[Any, Any]:
        """Command the wheels.

        Args:
            memory: of the controller.
            measurement: has `wheel_speed` (wheels,) relative to the body, rad/s, beside what the
                controller needs.
        """
        memory, command = self.controller(memory, measurement)
        demanded = command.torque
        speed = measurement.wheel_speed
        turns = jnp.abs(speed) > self.band
        sense = jnp.where(jnp.where(turns, speed, demanded) < 0.0, -1.0, 1.0)
        resting = jnp.clip(
            demanded / (SOFTNESS * jnp.maximum(self.friction.breakaway_torque(sense), 1e-300)),
            -1.0,
            1.0,
        )
        drive = jnp.where(turns, 1.0, jnp.abs(resting))
        friction = drive * self.friction.torque(jnp.where(turns, speed, 0.0), sense)
        torque = demanded + jnp.where(demanded == 0.0, 0.0, self.share * friction)
        return memory, command._replace(
            torque=jnp.clip(torque, -self.torque_limit, self.torque_limit)
        )
