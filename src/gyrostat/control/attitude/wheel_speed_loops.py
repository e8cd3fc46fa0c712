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
"""Natural frequency times control period: from 0.828 on the sampled loop is unstable."""


class SpeedLoopCommand(NamedTuple):
    """What motors shall give, and the speeds that it is for.

    Attributes:
        torque: (wheels,) of the motors, N·m.
        speed: (wheels,) that they shall come to, relative to the body, rad/s.
    """

    torque: Annotated[PerWheel, "N·m"]
    speed: Annotated[PerWheel, "rad/s"]


class WheelSpeedMemory(NamedTuple):
    """Between two samples.

    Attributes:
        controller: what the controller remembers.
        integral: (wheels,) of the speed errors, rad.
        begun: whether there was a sample.
        period: control period, s.
    """

    controller: Any
    integral: PerWheel
    begun: Bool[Array, ""]
    period: Scalar


class WheelSpeedLoops(Checked):
    """m = w_n² J integral(r - W) + 2 w_n J (r / 2 - W) on each wheel, within its torque.

    The loop of `gyrostat.spacecraft.SpeedLoopSpacecraft`, sampled with the controller: r is the
    commanded and W the measured speed. What drives further beyond the limit is not summed up. At
    the first sample the loop is at rest where the wheel is.

    Attributes:
        controller: commands `speed` (wheels,), rad/s.
        inertia: (wheels,) of the rotors, kg·m².
        torque_limit: (wheels,) N·m.
        natural_frequency: w_n, rad/s.
    """

    controller: Any
    inertia: PerWheel
    torque_limit: PerWheel
    natural_frequency: Annotated[Scalar, positive("speed loop natural frequency", "rad/s")] = 2.0

    def check_own_period(self, period: float) -> None:
        """Refuse a control period, s, at which the speed loops are unstable, by `InputError`."""
        longest = COARSEST / float(np.max(np.asarray(self.natural_frequency)))
        if period > longest:
            raise InputError(
                f"control period: found {period:g} s, expected {longest:g} s or less at this "
                "natural frequency of the speed loops"
            )

    def start(self, period: Scalar) -> WheelSpeedMemory:
        """Nothing measured yet."""
        return WheelSpeedMemory(
            self.controller.start(period),
            jnp.zeros_like(jnp.asarray(self.inertia, dtype=float)),
            jnp.array(False),
            jnp.asarray(period, dtype=float),
        )

    def predicted(
        self, memory: WheelSpeedMemory, measurement: Any, command: Any
    ) -> WheelSpeedMemory:
        """Memory one period later without a sample: that of the controller.

        Args:
            memory: from the last sample.
            measurement: last one that was accepted.
            command: that is sent.
        """
        later = predicted(self.controller, memory.controller, measurement, command)
        return memory._replace(controller=later)

    def __call__(
        self, memory: WheelSpeedMemory, measurement: Any
    ) -> tuple[WheelSpeedMemory, SpeedLoopCommand]:
        """Command the motors.

        Args:
            memory: from the last sample.
            measurement: has `wheel_speed` (wheels,) relative to the body, rad/s, beside what the
                controller needs.
        """
        controller, command = self.controller(memory.controller, measurement)
        frequency, speed = self.natural_frequency, measurement.wheel_speed
        rest = 2.0 * (1.0 - SET_POINT_WEIGHT) * speed / frequency
        error = command.speed - speed
        before = jnp.where(memory.begun, memory.integral, rest)
        integral = before + memory.period * error
        wanted = self.inertia * (
            frequency**2 * integral + 2.0 * frequency * (SET_POINT_WEIGHT * command.speed - speed)
        )
        torque = jnp.clip(wanted, -self.torque_limit, self.torque_limit)
        integral = jnp.where((wanted - torque) * error > 0.0, before, integral)
        after = WheelSpeedMemory(controller, integral, jnp.array(True), memory.period)
        return after, SpeedLoopCommand(torque, command.speed)
