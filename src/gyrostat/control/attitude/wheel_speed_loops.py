"""Adapts speed commands to torque-commanded wheels."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.speed_loop import SET_POINT_WEIGHT

COARSEST = 0.8
"""Largest product of natural frequency and control period; the sampled loop is unstable from
0.828."""


class SpeedLoopCommand(NamedTuple):
    """Motor torques, and the wheel speeds that they track.

    Attributes:
        torque: Motor torques, (wheels,), N·m.
        speed: Commanded wheel speeds relative to the body, (wheels,), rad/s.
    """

    torque: Annotated[PerWheel, "N·m"]
    speed: Annotated[PerWheel, "rad/s"]


class WheelSpeedMemory(NamedTuple):
    """State of the speed loops between two samples.

    Attributes:
        controller: Memory of the controller.
        integral: Integral of the speed errors, (wheels,), rad.
        begun: Whether there has been a sample.
        period: Control period, s.
    """

    controller: Any
    integral: PerWheel
    begun: Bool[Array, ""]
    period: Scalar


class WheelSpeedLoops(Checked):
    """Controller with a speed loop on each wheel, from commanded speed to motor torque.

    m = w_n² J integral(r - W) + 2 w_n J (r / 2 - W), within the torque limit. This is the loop of
    `gyrostat.spacecraft.SpeedLoopSpacecraft`, sampled at the control period, with r the commanded
    and W the measured speed. While a torque is limited, the integral does not grow further
    (anti-windup). The loop starts in equilibrium at the wheel speed of the first sample.

    Attributes:
        controller: Controller that commands `speed` (wheels,), rad/s.
        inertia: Spin inertia of the rotors, (wheels,), kg·m².
        torque_limit: Torque limits, (wheels,), N·m.
        natural_frequency: Natural frequency w_n of the loops, rad/s.
    """

    controller: Any
    inertia: PerWheel
    torque_limit: PerWheel
    natural_frequency: Annotated[Scalar, positive("speed loop natural frequency", "rad/s")] = 2.0

    def check_own_period(self, period: float) -> None:
        """Check that the speed loops are stable at a control period, s.

        Raises:
            InputError: The period is too long.
        """
        longest = COARSEST / float(np.max(np.asarray(self.natural_frequency)))
        if period > longest:
            raise InputError(
                f"control period: found {period:g} s, expected {longest:g} s or less at this "
                "natural frequency of the speed loops"
            )

    def start(self, period: Scalar) -> WheelSpeedMemory:
        """Initial memory."""
        return WheelSpeedMemory(
            self.controller.start(period),
            jnp.zeros_like(jnp.asarray(self.inertia, dtype=float)),
            jnp.array(False),
            jnp.asarray(period, dtype=float),
        )

    def predicted(
        self, memory: WheelSpeedMemory, measurement: Any, command: Any
    ) -> WheelSpeedMemory:
        """Memory after a period without a sample, from that of the controller.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        later = predicted(self.controller, memory.controller, measurement, command)
        return memory._replace(controller=later)

    def __call__(
        self, memory: WheelSpeedMemory, measurement: Any
    ) -> tuple[WheelSpeedMemory, SpeedLoopCommand]:
        """Compute the motor torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `wheel_speed` (wheels,), relative to the body, rad/s, and
                with the fields that the controller needs.
        """
        controller, command = self.controller(memory.controller, measurement)
        frequency, speed = self.natural_frequency, measurement.wheel_speed
        equilibrium = 2.0 * (1.0 - SET_POINT_WEIGHT) * speed / frequency
        error = command.speed - speed
        previous = jnp.where(memory.begun, memory.integral, equilibrium)
        integral = previous + memory.period * error
        demand = self.inertia * (
            frequency**2 * integral + 2.0 * frequency * (SET_POINT_WEIGHT * command.speed - speed)
        )
        torque = jnp.clip(demand, -self.torque_limit, self.torque_limit)
        integral = jnp.where((demand - torque) * error > 0.0, previous, integral)
        next_memory = WheelSpeedMemory(controller, integral, jnp.array(True), memory.period)
        return next_memory, SpeedLoopCommand(torque, command.speed)
