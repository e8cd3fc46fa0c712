"""Friction feed-forward: adds modelled friction to the wheel torques of another controller."""

from typing import Annotated, Any

from gyrostat.control.measured import with_wheel_friction
from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.friction import Friction

SOFTNESS = 0.2
"""Demanded torque over breakaway torque at which the compensation at rest is complete."""


class FrictionFeedForward(Checked):
    """Friction feed-forward m_i = u_i + share F_i(W_i), with W_i the measured speed of wheel i.

    Below `band`, noise hides the sign of the speed. The compensation is then the breakaway torque
    in the direction of the demanded torque. A small demand gets only a part of it, so that there is
    no limit cycle at rest. A wheel with a demand of exactly zero, such as a failed one, is not
    compensated.

    Attributes:
        controller: Controller that demands the torques u_i. It gets the measurement with the field
            `wheel_friction`, the friction of the model while a wheel turns, (wheels,), N·m.
        friction: Friction model of the wheels in the controller.
        torque_limit: Torque limits, (wheels,), N·m.
        band: Speed below which a wheel counts as at rest, rad/s.
        share: Fraction of the friction that is compensated.
    """

    controller: Any
    friction: Friction
    torque_limit: PerWheel
    band: Annotated[Scalar, positive("speed band of the compensator", "rad/s")]
    share: Annotated[Scalar, size("share of the compensator")] = 1.0

    def start(self, period: Scalar) -> Any:
        """Initial memory of the controller."""
        return self.controller.start(period)

    def predicted(self, memory: Any, measurement: Any, command: Any) -> Any:
        """Memory of the controller one period later without a sample.

        Args:
            memory: Memory of the controller.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        return predicted(self.controller, memory, measurement, command)

    def __call__(self, memory: Any, measurement: Any) -> tuple[Any, Any]:
        """Compute the wheel torques.

        Args:
            memory: Memory of the controller.
            measurement: Measurement with `wheel_speed` (wheels,), relative to the body, rad/s, and
                with the fields that the controller needs.
        """
        speed = measurement.wheel_speed
        turns = jnp.abs(speed) > self.band
        model_friction = self.share * self.friction.torque(speed, jnp.where(speed < 0.0, -1.0, 1.0))
        inner_measurement = with_wheel_friction(measurement, jnp.where(turns, model_friction, 0.0))
        memory, command = self.controller(memory, inner_measurement)
        demand = command.torque
        sense = jnp.where(jnp.where(turns, speed, demand) < 0.0, -1.0, 1.0)
        breakaway = jnp.maximum(self.friction.breakaway_torque(sense), 1e-300)
        resting = jnp.clip(demand / (SOFTNESS * breakaway), -1.0, 1.0)
        drive = jnp.where(turns, 1.0, jnp.abs(resting))
        friction = drive * self.friction.torque(jnp.where(turns, speed, 0.0), sense)
        torque = demand + jnp.where(demand == 0.0, 0.0, self.share * friction)
        return memory, command._replace(
            torque=jnp.clip(torque, -self.torque_limit, self.torque_limit)
        )
