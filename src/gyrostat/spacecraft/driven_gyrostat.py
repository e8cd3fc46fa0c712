"""Gyrostat with motor electronics: current loops between torque command and wheels."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_wrapper import GyrostatWrapper
from gyrostat.spacecraft.imbalance import ImbalancedGyrostat
from gyrostat.wheel import Driver
from gyrostat.wheel.array import listed


class DrivenGyrostat(GyrostatWrapper):
    """Gyrostat with a current loop for each wheel.

    The commanded torque, limited to the torque limit of the wheel, is converted to a current
    command. The driver applies its limits, quantisation and lag. Within an integration step the
    motor gives the mean of the current, so that the wheel momentum is exact. The errors of attitude
    and dry friction are of second order in the step.

    Attributes:
        gyrostat: `Gyrostat` or `ImbalancedGyrostat`.
        driver: Motor electronics; each parameter (wheels,), or one value for all.
        motor_constant: Torque per current, (wheels,), or one value for all, N·m/A.
    """

    gyrostat: Gyrostat | ImbalancedGyrostat
    driver: Driver
    motor_constant: Annotated[PerWheel | float, positive("motor_constant", "N·m/A")] = eqx.field(
        converter=listed
    )

    def check_own(self) -> None:
        """Validate shapes.

        Raises:
            InputError: A parameter has another number of wheels.
        """
        count = self.spacecraft.wheels.count
        numbers = {"motor_constant": self.motor_constant, **vars(self.driver)}
        for name, value in numbers.items():
            if np.shape(value)[-1:] not in ((), (count,)):
                raise InputError(
                    f"driver {name}: found {np.shape(value)[-1]} values, expected one or {count}, "
                    "one a wheel"
                )

    def start(self, *, motor_current: Any = 0.0, **motion: Any) -> Any:
        """Create a state from attitude, rate, wheel speeds and motor currents.

        Args:
            motor_current: Motor currents, (wheels,), or one value for all, A.
            motion: See `start` of the gyrostat.
        """
        state = self.gyrostat.start(**motion)
        current = jnp.asarray(motor_current, dtype=float)
        return state._replace(motor_current=jnp.broadcast_to(current, state.wheel_speed.shape))

    def check_state(self, state: Any) -> None:
        """Validate a state; raises `InputError`."""
        self.gyrostat.check_state(state)
        if state.motor_current is None:
            raise InputError("motor_current: found none, expected the currents of the motors, A")

    def __call__(
        self, state: Any, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[Any, Bool[Array, ""]]:
        """Integrate over an interval of constant command; see `Gyrostat`."""
        _, target = self._set_point(state, command)
        mean = self.driver.mean_current(state.motor_current, target, duration)
        torque_command = command._replace(torque=self.motor_constant * mean)
        inner = state._replace(motor_current=None)
        after, resolved = self.gyrostat(inner, torque_command, time, duration)
        current = self.driver.current(state.motor_current, target, duration)
        return after._replace(motor_current=current), resolved

    def record(self, state: Any, command: Any) -> Any:
        """Record of the gyrostat; `saturated` includes the limits of the driver."""
        record = self.gyrostat.record(state, command)
        demand, target = self._set_point(state, command)
        return record._replace(saturated=record.saturated | self.driver.limited(demand, target))

    def _set_point(self, state: Any, command: Any) -> tuple[Any, Any]:
        """Commanded currents, and set points of the current loops after limits, (wheels,), A."""
        torque = self.spacecraft.wheels.within_torque_limit(command.torque)
        demand = torque / self.motor_constant
        return demand, self.driver.set_point(demand, state.wheel_speed, self.motor_constant)
