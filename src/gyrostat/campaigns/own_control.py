"""Controllers, compensators and estimators of a user, in the control loop of a scenario."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx

from gyrostat.control.missing_sample import predicted
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import check_parts, check_period


class SampleTime(NamedTuple):
    """Field that is added to a measurement.

    Attributes:
        time: Time of the sample, s.
    """

    time: Annotated[Scalar, "s"]


class OwnMemory(NamedTuple):
    """Memory between samples.

    Attributes:
        inner: Memory of the user's part.
        sample: Index of the next sample.
        period: Control period, s.
    """

    inner: Any
    sample: Scalar
    period: Scalar


class OwnControl(eqx.Module):
    """Controller, compensator or estimator of a user; its measurements have the field `time`, s.

    Attributes:
        inner: Part of the user.
        kind: Its kind, for error messages.
    """

    inner: Any
    kind: str = eqx.field(static=True)

    def check(self) -> None:
        """Validate parameters; raises `InputError`."""
        check_parts(self.inner)

    def check_period(self, period: float) -> None:
        """Validate the control period, s; raises `InputError`."""
        check_period(period, self.inner)

    def start(self, period: Scalar) -> OwnMemory:
        """Memory before the first sample."""
        period = jnp.asarray(period, dtype=float)
        return OwnMemory(self.inner.start(period), jnp.zeros(()), period)

    def predicted(self, memory: OwnMemory, measurement: Any, command: Any) -> OwnMemory:
        """Memory after a period without a sample; see `gyrostat.control.missing_sample`."""
        inner = predicted(self.inner, memory.inner, timed(measurement, memory), command)
        return memory._replace(inner=inner, sample=memory.sample + 1.0)

    def __call__(self, memory: OwnMemory, measurement: Any) -> tuple[OwnMemory, Any]:
        """Compute the command by the part of the user."""
        inner, command = self.inner(memory.inner, timed(measurement, memory))
        return memory._replace(inner=inner, sample=memory.sample + 1.0), command


def timed(measurement: Any, memory: OwnMemory) -> Any:
    """Measurement with the time of the sample, s."""
    if "time" in measurement._fields:
        return measurement
    return recorded_with("Timed", measurement, SampleTime(memory.sample * memory.period))
