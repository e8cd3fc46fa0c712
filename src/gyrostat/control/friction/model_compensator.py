"""Dynamic model compensator: adds modelled friction to the commanded torque."""

from typing import Annotated, Any

import numpy as np

from gyrostat.control.attitude.attitude_pid import AttitudePID, PIDMemory
from gyrostat.control.attitude.command import CurrentCommand
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.friction import Friction


class DynamicModelCompensator(Checked):
    """Dynamic model compensator: current I = u + F(w) / k_m.

    At exactly zero speed I = u + sgn(u) T_s / k_m. Carrara and Kuga, eqs. (18), (19), for any
    friction model; u is the demanded torque over k_m. The speed is the measured sample; if it is
    noisy, so is the sign of the friction.

    Attributes:
        law: Attitude law, which gives the demanded wheel torque.
        friction: Friction model of the controller.
        motor_constant: Motor constant assumed by the controller, N·m/A.
        current_limit: Limit of the motor current, A.
    """

    law: AttitudePID
    friction: Friction
    motor_constant: Annotated[Scalar, positive("motor_constant", "N·m/A")]
    current_limit: Scalar = np.inf

    def start(self, period: Scalar) -> PIDMemory:
        """Initial memory of the law."""
        return self.law.start(period)

    def __call__(self, memory: PIDMemory, measurement: Any) -> tuple[PIDMemory, CurrentCommand]:
        """Compute the current command.

        Args:
            memory: Memory of the law.
            measurement: Measurement with attitude, rate and wheel `speed`, rad/s.
        """
        next_memory, torque = self.law(memory, measurement)
        speed = measurement.speed
        at_rest = speed == 0.0
        direction = jnp.where(at_rest, jnp.sign(torque), jnp.sign(speed))
        # at rest, the curve in the direction of the demanded torque is the breakaway torque
        friction = jnp.where(direction == 0.0, 0.0, self.friction.torque(speed, direction))
        parts = torque / self.motor_constant, friction / self.motor_constant
        demand = parts[0] + parts[1]
        current = jnp.clip(demand, -self.current_limit, self.current_limit)
        memory = self.law.within_limit(memory, next_memory, demand - current)
        return memory, CurrentCommand(current, *parts)
