"""PID control of the attitude about one axis."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.attitude.command import CurrentCommand
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, signed
from gyrostat.core.jax64 import jnp

INTEGRAL_POLE = 0.2
"""Pole of the integral part over the others, in `AttitudePID.designed`."""


class PIDMemory(NamedTuple):
    """Between two samples.

    Attributes:
        integral: of the attitude error, rad·s.
        period: control period, s.
    """

    integral: Float[Array, ""]
    period: Scalar


class AttitudePID(Checked):
    """Wheel torque K_p e + K_i (sum of e T) + K_d Ω, with e the attitude minus its reference.

    A positive wheel torque pushes the table back, so positive gains are stable. The derivative is
    the measured rate; the sum includes the present sample. The sum stands still while the torque is
    beyond its limit and the error would drive it further (anti-windup); a controller with a limit
    of its own behind the law tells it by `within_limit`.

    Attributes:
        proportional: K_p, N·m/rad.
        integral: K_i, N·m/(rad·s).
        derivative: K_d, N·m·s/rad.
        torque_limit: N·m.
        reference: attitude to hold, rad.
    """

    proportional: Annotated[Scalar, signed("size of the proportional gain", "N·m/rad")]
    integral: Annotated[Scalar, signed("size of the integral gain", "N·m/(rad·s)")]
    derivative: Annotated[Scalar, signed("size of the derivative gain", "N·m·s/rad")]
    torque_limit: Scalar = np.inf
    reference: Scalar = 0.0

    @classmethod
    def designed(cls, inertia: Scalar, frequency: Scalar) -> "AttitudePID":
        """Place the poles of a body without friction: two at -ω, the integral's at -ω / 5.

        J s³ + K_d s² + K_p s + K_i = J (s + ω)² (s + ω / 5). The gains of Carrara and Kuga follow
        with J = 0.495 kg·m² and ω = 0.287 rad/s.

        Args:
            inertia: J of what the wheel turns, kg·m².
            frequency: ω, natural frequency of the loop, rad/s.
        """
        slow = INTEGRAL_POLE
        return cls(
            proportional=inertia * frequency**2 * (1.0 + 2.0 * slow),
            integral=inertia * frequency**3 * slow,
            derivative=inertia * frequency * (2.0 + slow),
        )

    def start(self, period: Scalar) -> PIDMemory:
        """Nothing summed up yet."""
        return PIDMemory(jnp.array(0.0), period)

    def __call__(self, memory: PIDMemory, measurement: Any) -> tuple[PIDMemory, Float[Array, ""]]:
        """The demanded wheel torque, N·m.

        Args:
            memory: from the last sample.
            measurement: has `attitude`, rad, and `rate`, rad/s.
        """
        error = measurement.attitude - self.reference
        summed = memory.integral + error * memory.period
        rest = self.proportional * error + self.derivative * measurement.rate
        torque = rest + self.integral * summed
        winds_up = (jnp.abs(torque) > self.torque_limit) & (torque * self.integral * error > 0.0)
        summed = jnp.where(winds_up, memory.integral, summed)
        torque = jnp.clip(rest + self.integral * summed, -self.torque_limit, self.torque_limit)
        return PIDMemory(summed, memory.period), torque

    def within_limit(self, before: PIDMemory, after: PIDMemory, cut: Scalar) -> PIDMemory:
        """Take back a step of the sum that drives further what a limit behind the law cuts off.

        Args:
            before: memory before the sample.
            after: memory after it.
            cut: what the limit took from the command, in any unit.
        """
        further = cut * self.integral * (after.integral - before.integral) > 0.0
        return after._replace(integral=jnp.where(further, before.integral, after.integral))


class CurrentMode(Checked):
    """The attitude law alone: demanded torque over motor constant.

    Carrara and Kuga, section "Torque mode control".

    Attributes:
        law: gives the demanded wheel torque.
        motor_constant: as the controller knows it, N·m/A.
        current_limit: A.
    """

    law: AttitudePID
    motor_constant: Annotated[Scalar, positive("motor_constant", "N·m/A")]
    current_limit: Scalar = np.inf

    def start(self, period: Scalar) -> PIDMemory:
        """Memory of the law."""
        return self.law.start(period)

    def __call__(self, memory: PIDMemory, measurement: Any) -> tuple[PIDMemory, CurrentCommand]:
        """Command a current."""
        after, torque = self.law(memory, measurement)
        current = torque / self.motor_constant
        limited = jnp.clip(current, -self.current_limit, self.current_limit)
        memory = self.law.within_limit(memory, after, current - limited)
        return memory, CurrentCommand(limited, current, jnp.zeros_like(current))
