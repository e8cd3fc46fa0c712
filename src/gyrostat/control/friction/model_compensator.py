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
    """I = u + F(w) / k_m, and at exactly zero speed I = u + sgn(u) T_s / k_m.

    Carrara and Kuga, eqs. (18), (19), with u = demanded torque over k_m, for any friction model.
    The speed is the measured sample: where that is noisy, so is the sign of the friction.

    Attributes:
        law: gives the demanded wheel torque.
        friction: as the controller knows it.
        motor_constant: as the controller knows it, N·m/A.
        current_limit: A.
    """

    law: AttitudePID
    friction: Friction
    motor_constant: Annotated[Scalar, positive("motor_constant", "N·m/A")]
    current_limit: Scalar = np.inf

    def start(self, period: Scalar) -> PIDMemory:
        """Memory of the law."""
        return self.law.start(period)

    def __call__(self, memory: PIDMemory, measurement: Any) -> tuple[PIDMemory, CurrentCommand]:
        """Command a current.

        Args:
            memory: of the law.
            measurement: has attitude, rate and the wheel's `speed`, rad/s.
        """
        after, torque = self.law(memory, measurement)
        speed = measurement.speed
        at_rest = speed == 0.0
        direction = jnp.where(at_rest, jnp.sign(torque), jnp.sign(speed))
        # at rest the curve in the demanded sense is the breakaway torque
        friction = jnp.where(direction == 0.0, 0.0, self.friction.torque(speed, direction))
        parts = torque / self.motor_constant, friction / self.motor_constant
        wished = parts[0] + parts[1]
        current = jnp.clip(wished, -self.current_limit, self.current_limit)
        memory = self.law.within_limit(memory, after, wished - current)
        return memory, CurrentCommand(current, *parts)
