"""Controllers, compensators and estimators of a user, in the control loop of a scenario."""

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import equinox as eqx

from gyrostat.control.guidance import Guide
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.user_errors import UserPartError, described, numbers, reported, same_memory
from gyrostat.core.validation import check_period
from gyrostat.scenario.user.wrapper import UserWrapper
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment


class SampleTime(NamedTuple):
    """Field that is added to a measurement.

    Attributes:
        time: Time of the sample, s.
    """

    time: Annotated[Scalar, "s"]


class UserMemory(NamedTuple):
    """Memory between samples.

    Attributes:
        inner: Memory of the user's part.
        sample: Index of the next sample.
        period: Control period, s.
    """

    inner: Any
    sample: Scalar
    period: Scalar


class UserControl(UserWrapper):
    """Controller, compensator or estimator of a user.

    It adds the field `time`, s, to the measurements, and validates what the part returns.

    Attributes:
        wheels: Number of wheels.
    """

    wheels: int = eqx.field(static=True)

    def check_period(self, period: float) -> None:
        """Validate the control period, s; raises `InputError`."""
        with reported(self.name, self._module):
            check_period(period, self.inner)

    def toward(self, guide: Guide) -> "UserControl":
        """Part whose field `reference`, if it has one, is the reference as a function of time."""
        if not self.takes_reference:
            return self
        return dataclasses.replace(self, inner=dataclasses.replace(self.inner, reference=guide.at))

    def in_orbit(self, orbit: OrbitEnvironment) -> "UserControl":
        """Part whose field `orbit`, if it has one, is the orbit of the run."""
        if not self._has_field("orbit"):
            return self
        return dataclasses.replace(self, inner=dataclasses.replace(self.inner, orbit=orbit))

    def _has_field(self, name: str) -> bool:
        return name in {field.name for field in dataclasses.fields(self.inner)}

    @property
    def takes_reference(self) -> bool:
        """Whether the part has a field `reference`."""
        return self._has_field("reference")

    def start(self, period: Scalar) -> UserMemory:
        """Memory before the first sample."""
        period = jnp.asarray(period, dtype=float)
        return UserMemory(self.begun(period), jnp.zeros(()), period)

    def predicted(self, memory: UserMemory, measurement: Any, command: Any) -> UserMemory:
        """Memory after a period without a sample; see `gyrostat.control.missing_sample`."""
        inner = memory.inner
        if hasattr(self.inner, "predicted"):
            inner = self.called("predicted", inner, timed(measurement, memory), command)
        inner = same_memory(self.name, memory.inner, inner)
        return memory._replace(inner=inner, sample=memory.sample + 1.0)

    def __call__(self, memory: UserMemory, measurement: Any) -> tuple[UserMemory, Any]:
        """Compute the command by the part of the user.

        Raises:
            InputError: The part raised an exception, or returned something else than its memory
                and a command.
        """
        sample = timed(measurement, memory)
        result = self.called("__call__", memory.inner, sample)
        if not isinstance(result, tuple) or len(result) != 2 or hasattr(result, "_fields"):
            raise UserPartError(
                f"{self.name}: found {described(result)} as result, expected (memory, command)"
            )
        inner = same_memory(self.name, memory.inner, result[0])
        command = self._command(result[1])
        if hasattr(self.inner, "predicted"):
            # flight code always predicts after a rejected sample
            self.tried("predicted", inner, sample, command, simulated=False)
        return memory._replace(inner=inner, sample=memory.sample + 1.0), command

    def _command(self, command: Any) -> Any:
        fields = getattr(command, "_fields", None)
        if fields is None or "torque" not in fields:
            found = described(command) if fields is None else f"fields {', '.join(fields)}"
            raise UserPartError(
                f"{self.name}: found {found} as command, expected a named tuple with the field "
                f"torque ({self.wheels},), N·m, one number for each wheel"
            )
        shapes: Mapping[str, tuple[int, ...]] = {"torque": (self.wheels,), "external_torque": (3,)}
        return type(command)(
            *(
                numbers(self.name, f"command.{name}", value, shapes.get(name))
                for name, value in zip(fields, command, strict=True)
            )
        )


def timed(measurement: Any, memory: UserMemory) -> Any:
    """Measurement with the time of the sample, s."""
    if "time" in measurement._fields:
        return measurement
    return recorded_with("Timed", measurement, SampleTime(memory.sample * memory.period))
