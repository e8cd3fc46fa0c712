"""Gyrostat with motor electronics between command and wheel."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.imbalance import ImbalancedGyrostat
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.wheel import Driver
from gyrostat.wheel.array import listed


class DrivenGyrostat(Checked):
    """A gyrostat behind a current loop for each wheel.

    A commanded torque, cut to the limit of the wheel, asks for its current; the driver takes the
    current towards it within its own limits, on its steps and through its lag. Through an
    integration step the motor gives the mean of that current: so the momentum of the wheels is
    exact; the error of attitude and dry friction is of second order in the step.

    Attributes:
        gyrostat: `Gyrostat` or `ImbalancedGyrostat`.
        driver: of the motors, each of its numbers (wheels,) or one for all.
        motor_constant: (wheels,) or one for all, N·m/A.
    """

    gyrostat: Gyrostat | ImbalancedGyrostat
    driver: Driver
    motor_constant: Annotated[PerWheel | float, positive("motor_constant", "N·m/A")] = eqx.field(
        converter=listed
    )

    @property
    def spacecraft(self) -> Spacecraft:
        """The body and its wheels."""
        return self.gyrostat.spacecraft

    @property
    def failures(self) -> Any:
        """Of the wheels; see `Gyrostat`."""
        return self.gyrostat.failures

    def check_own(self) -> None:
        """Validate shapes.

        Raises:
            InputError: Numbers of another number of wheels.
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
        """A state from what is measured.

        Args:
            motor_current: (wheels,) or one for all, A.
            motion: see the gyrostat.
        """
        state = self.gyrostat.start(**motion)
        current = jnp.asarray(motor_current, dtype=float)
        return state._replace(motor_current=jnp.broadcast_to(current, state.wheel_speed.shape))

    def check_state(self, state: Any) -> None:
        """Refuse what is no state of this spacecraft, by `InputError`."""
        self.gyrostat.check_state(state)
        if state.motor_current is None:
            raise InputError("motor_current: found none, expected the currents of the motors, A")

    def rate(self, state: Any) -> Vector3:
        """Body rate in body axes, rad/s."""
        return self.gyrostat.rate(state)

    def balanced_rate(self, state: Any) -> Vector3:
        """Body rate without the jitter of wheels out of balance, in body axes, rad/s."""
        return getattr(self.gyrostat, "balanced_rate", self.gyrostat.rate)(state)

    def __call__(
        self, state: Any, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[Any, Bool[Array, ""]]:
        """Carry the spacecraft over an interval of held command; see `Gyrostat`."""
        _, target = self._set_point(state, command)
        mean = self.driver.mean_current(state.motor_current, target, duration)
        given = command._replace(torque=self.motor_constant * mean)
        inner = state._replace(motor_current=None)
        after, resolved = self.gyrostat(inner, given, time, duration)
        current = self.driver.current(state.motor_current, target, duration)
        return after._replace(motor_current=current), resolved

    def diverged(self, state: Any) -> Bool[Array, ""]:
        """See `Gyrostat.diverged`."""
        return self.gyrostat.diverged(state)

    def record(self, state: Any, command: Any) -> Any:
        """That of the gyrostat; a wheel is saturated where a limit of its driver cuts, too."""
        record = self.gyrostat.record(state, command)
        wanted, target = self._set_point(state, command)
        return record._replace(saturated=record.saturated | self.driver.limited(wanted, target))

    def _set_point(self, state: Any, command: Any) -> tuple[Any, Any]:
        """Currents (wheels,) that are asked for and that the loops go to, A."""
        torque = self.spacecraft.wheels.within_torque_limit(command.torque)
        wanted = torque / self.motor_constant
        return wanted, self.driver.set_point(wanted, state.wheel_speed, self.motor_constant)
