"""PID control of the attitude about one axis."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.attitude.command import CurrentCommand
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, signed
from gyrostat.core.jax64 import jnp

INTEGRAL_POLE = 0.2
"""Ratio of the integral pole to the other poles, in `AttitudePID.design`."""


class PIDMemory(NamedTuple):
    """State of the PID law between two samples.

    Attributes:
        integral: Integral of the attitude error, rad·s.
        period: Control period, s.
    """

    integral: Float[Array, ""]
    period: Scalar


class AttitudePID(Checked):
    """PID law of the attitude: wheel torque K_p e + K_i (sum of e T) + K_d Ω.

    The error e is the attitude minus its reference. A positive wheel torque accelerates the table
    in the negative direction, so that positive gains are stable. The derivative term uses the
    measured rate, and the sum includes the present sample. The sum is not updated while the torque
    is beyond its limit and the error would increase it further (anti-windup). A controller that
    limits the command after this law applies the same rule by `within_limit`.

    Attributes:
        proportional: Proportional gain K_p, N·m/rad.
        integral: Integral gain K_i, N·m/(rad·s).
        derivative: Derivative gain K_d, N·m·s/rad.
        torque_limit: Limit of the wheel torque, N·m.
        reference: Attitude to hold, rad.
    """

    proportional: Annotated[Scalar, signed("size of the proportional gain", "N·m/rad")]
    integral: Annotated[Scalar, signed("size of the integral gain", "N·m/(rad·s)")]
    derivative: Annotated[Scalar, signed("size of the derivative gain", "N·m·s/rad")]
    torque_limit: Scalar = np.inf
    reference: Scalar = 0.0

    @classmethod
    def design(cls, inertia: Scalar, frequency: Scalar) -> "AttitudePID":
        """Place the poles for a body without friction: two at -ω, the integral's at -ω / 5.

        J s³ + K_d s² + K_p s + K_i = J (s + ω)² (s + ω / 5). The gains of Carrara and Kuga follow
        with J = 0.495 kg·m² and ω = 0.287 rad/s.

        Args:
            inertia: Inertia J of the body that the wheel turns, kg·m².
            frequency: Natural frequency ω of the loop, rad/s.
        """
        slow = INTEGRAL_POLE
        return cls(
            proportional=inertia * frequency**2 * (1.0 + 2.0 * slow),
            integral=inertia * frequency**3 * slow,
            derivative=inertia * frequency * (2.0 + slow),
        )

    # earlier name
    designed = design

    def start(self, period: Scalar) -> PIDMemory:
        """Initial memory, with a zero sum."""
        return PIDMemory(jnp.array(0.0), period)

    def __call__(self, memory: PIDMemory, measurement: Any) -> tuple[PIDMemory, Float[Array, ""]]:
        """Demanded wheel torque, N·m.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude`, rad, and `rate`, rad/s.
        """
        error = measurement.attitude - self.reference
        integral = memory.integral + error * memory.period
        pd = self.proportional * error + self.derivative * measurement.rate
        torque = pd + self.integral * integral
        winds_up = (jnp.abs(torque) > self.torque_limit) & (torque * self.integral * error > 0.0)
        integral = jnp.where(winds_up, memory.integral, integral)
        torque = jnp.clip(pd + self.integral * integral, -self.torque_limit, self.torque_limit)
        return PIDMemory(integral, memory.period), torque

    def within_limit(self, before: PIDMemory, after: PIDMemory, cut: Scalar) -> PIDMemory:
        """Undo the update of the integral if it increases the saturation (anti-windup).

        Args:
            before: Memory before the sample.
            after: Memory after the sample.
            cut: Command minus limited command, in any unit.
        """
        further = cut * self.integral * (after.integral - before.integral) > 0.0
        return after._replace(integral=jnp.where(further, before.integral, after.integral))


class CurrentMode(Checked):
    """Current mode: attitude law without friction compensation.

    The current is the demanded torque over the motor constant. Carrara and Kuga, section "Torque
    mode control".

    Attributes:
        law: Attitude law, which gives the demanded wheel torque.
        motor_constant: Motor constant assumed by the controller, N·m/A.
        current_limit: Limit of the motor current, A.
    """

    law: AttitudePID
    motor_constant: Annotated[Scalar, positive("motor_constant", "N·m/A")]
    current_limit: Scalar = np.inf

    def start(self, period: Scalar) -> PIDMemory:
        """Initial memory of the law."""
        return self.law.start(period)

    def __call__(self, memory: PIDMemory, measurement: Any) -> tuple[PIDMemory, CurrentCommand]:
        """Compute the current command."""
        next_memory, torque = self.law(memory, measurement)
        demand = torque / self.motor_constant
        current = jnp.clip(demand, -self.current_limit, self.current_limit)
        memory = self.law.within_limit(memory, next_memory, demand - current)
        return memory, CurrentCommand(current, demand, jnp.zeros_like(demand))
