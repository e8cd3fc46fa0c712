"""Environment torques, sensors, actuators and events of a user, in the simulated spacecraft.

Each validates what the user's Python returns, and reports mistakes with the name of the part.
"""

from typing import Any

from jaxtyping import PRNGKeyArray

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax
from gyrostat.core.user_errors import UserPartError, numbers, reported, same_memory
from gyrostat.core.validation import require
from gyrostat.scenario.user.wrapper import UserWrapper


class UserTorque(UserWrapper):
    """Environment torque or actuator of a user.

    See `gyrostat.spacecraft.TorqueModel`, whose first argument is the spacecraft, and
    `gyrostat.spacecraft.Actuator`, whose first argument is the value of the command.
    """

    def __call__(self, given: Any, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m."""
        torque = self.called("__call__", given, attitude, time)
        return numbers(self.name, "torque, N·m in body axes", torque, (3,))


class UserActuator(UserWrapper):
    """Actuator of a user with a state; see `gyrostat.spacecraft.ActuatorWithState`."""

    def check(self) -> None:
        """Validate parameters; raises `InputError`."""
        super().check()
        longest = getattr(self.inner, "longest_step", None)
        if longest is None:
            raise UserPartError(
                f"{self.name}: found no longest_step, expected it: the longest time over which a "
                "cubic function represents the torque, s"
            )
        with reported(self.name, self._module):
            require("longest_step", longest, "s", positive=True)

    @property
    def longest_step(self) -> Scalar:
        """See `ActuatorWithState`."""
        return numbers(self.name, "longest_step, s", self.inner.longest_step, ())

    def start(self) -> Any:
        """State at the start of a run."""
        return self.begun()

    def advanced(self, state: Any, value: Any, elapsed: Scalar) -> Any:
        """State after a time of constant command."""
        return same_memory(self.name, state, self.called("advanced", state, value, elapsed))

    def __call__(self, state: Any, value: Any, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m."""
        torque = self.called("__call__", state, value, attitude, time)
        return numbers(self.name, "torque, N·m in body axes", torque, (3,))


class UserProfile(UserWrapper):
    """Attitude over time of a user; see `gyrostat.control.guidance.Profile`."""

    def __call__(self, time: Scalar) -> Quaternion:
        """Attitude at a time, s."""
        attitude = self.called("__call__", time)
        return numbers(self.name, "attitude, a quaternion", attitude, (4,))


class UserCondition(UserWrapper):
    """Condition of a user; see `gyrostat.control.guidance.ModeChange`."""

    def __call__(self, measurement: Any, time: Scalar) -> Scalar:
        """Number above 0 while it holds."""
        result = self.called("__call__", measurement, time)
        return numbers(self.name, "condition, a number above 0 while it holds", result, ())


class UserChange(UserWrapper):
    """Event of a user; see `gyrostat.spacecraft.Change`."""

    def __call__(self, plant: Any) -> Any:
        """Plant after the event."""
        return self.called("__call__", plant)


class UserSensor(UserWrapper):
    """Sensor of a user; see `gyrostat.spacecraft.AddedSensor`."""

    @property
    def unit(self) -> Any:
        """Unit of the value, or None."""
        return getattr(self.inner, "unit", None)

    def start(self, state: Any, period: Scalar) -> Any:
        """Memory before the first sample."""
        return self.begun(state, period)

    def __call__(self, memory: Any, state: Any, key: PRNGKeyArray) -> tuple[Any, Any]:
        """Measure.

        Raises:
            InputError: The part raised an exception, or returned something else than its memory
                and a value.
        """
        result = self.called("__call__", memory, state, key)
        if not isinstance(result, tuple) or len(result) != 2:
            found = "an array" if isinstance(result, jax.Array) else type(result).__name__
            raise UserPartError(f"{self.name}: found {found} as result, expected (memory, value)")
        after = same_memory(self.name, memory, result[0])
        return after, numbers(self.name, "value", result[1])
