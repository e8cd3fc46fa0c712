"""Speed mode: the attitude law commands a wheel speed, which an inner loop tracks."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.attitude.attitude_pid import AttitudePID, PIDMemory
from gyrostat.control.attitude.command import CurrentCommand
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jnp


class SpeedModeMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        law: Memory of the attitude law.
        reference: Commanded wheel speed, rad/s.
        integral: Integral of the speed error, rad.
        started: Whether there has been a sample.
    """

    law: PIDMemory
    reference: Float[Array, ""]
    integral: Float[Array, ""]
    started: Bool[Array, ""]


class SpeedMode(Checked):
    """Outer attitude loop with an inner speed loop.

    The demanded torque, integrated and divided by the wheel inertia, is the reference of a
    proportional-integral speed loop with natural frequency w_n and damping ratio z: gains 2 z w_n
    J_w and w_n^2 J_w. Friction is a disturbance, which the loop corrects only after it has changed
    the speed.

    Attributes:
        law: Attitude law, which gives the demanded wheel torque.
        inertia: Wheel inertia assumed by the controller, kg·m².
        motor_constant: Motor constant assumed by the controller, N·m/A.
        natural_frequency: Natural frequency of the speed loop, rad/s; the tachometer noise in the
            current grows with it.
        damping_ratio: Damping ratio of the speed loop.
        current_limit: Limit of the motor current, A.
    """

    law: AttitudePID
    inertia: Annotated[Scalar, positive("wheel inertia", "kg·m²")]
    motor_constant: Annotated[Scalar, positive("motor_constant", "N·m/A")]
    natural_frequency: Annotated[Scalar, positive("natural frequency", "rad/s")] = 1.0
    damping_ratio: Annotated[Scalar, size("damping ratio")] = 1.0
    current_limit: Scalar = np.inf

    def start(self, period: Scalar) -> SpeedModeMemory:
        """Initial memory."""
        zero = jnp.array(0.0)
        return SpeedModeMemory(self.law.start(period), zero, zero, jnp.array(False))

    def __call__(
        self, memory: SpeedModeMemory, measurement: Any
    ) -> tuple[SpeedModeMemory, CurrentCommand]:
        """Compute the current command.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with attitude, rate and wheel `speed`, rad/s.
        """
        law, torque = self.law(memory.law, measurement)
        period = law.period
        previous = jnp.where(memory.started, memory.reference, measurement.speed)
        reference = previous + torque / self.inertia * period
        error = reference - measurement.speed
        integral = memory.integral + error * period
        w_n = self.natural_frequency
        proportional = 2.0 * self.damping_ratio * w_n * self.inertia
        loop_torque = proportional * error + w_n**2 * self.inertia * integral
        demand = loop_torque / self.motor_constant
        current = jnp.clip(demand, -self.current_limit, self.current_limit)
        # anti-windup: no integration further beyond the limit
        excess = demand - current
        law = self.law.within_limit(memory.law, law, excess)
        integral = jnp.where(excess * error > 0.0, memory.integral, integral)
        reference = jnp.where(excess * torque > 0.0, previous, reference)
        attitude_current = torque / self.motor_constant
        command = CurrentCommand(current, attitude_current, demand - attitude_current)
        return SpeedModeMemory(law, reference, integral, jnp.array(True)), command
