"""Validation of measurements: finite values, range and rate of change."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Annotated, Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Int

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

UNLIMITED = float(np.finfo(np.float32).max)
"""Value that means "no limit". It is finite in single precision too, so that flight code needs no
infinity."""
ON_BAD = ("hold", "zero")
"""Safe commands after a rejected sample: the last accepted command, or zero."""
REACQUIRE = 4
"""Number of samples without an accepted value after which the rate of change is not tested."""


class SampleStatus(IntEnum):
    """Result of the validation of a sample.

    Attributes:
        GOOD: Every value was accepted.
        PARTIAL: Values of a sensor with its own flag were rejected. The flag was cleared, and the
            command is computed from the other values.
        NOT_FINITE: A value was NaN or infinite; the command is the safe one.
        OUT_OF_RANGE: A value was outside its limits; the command is the safe one.
        TOO_FAST: A value changed faster than its limit; the command is the safe one.
        NOT_COMPUTED: The values were accepted, but the command or the memory was not finite; the
            command is the safe one.
    """

    GOOD = 0
    PARTIAL = 1
    NOT_FINITE = 2
    OUT_OF_RANGE = 3
    TOO_FAST = 4
    NOT_COMPUTED = 5


class FieldLimits(NamedTuple):
    """Limits of one field of a measurement.

    Attributes:
        lower: Smallest accepted value, in the unit of the field.
        upper: Largest accepted value, in the unit of the field.
        rate: Largest accepted rate of change, in the unit of the field per second. None: the rate
            is not tested, and no code is generated for the test.
    """

    lower: Scalar = -UNLIMITED
    upper: Scalar = UNLIMITED
    rate: Scalar | None = None


class SampleReport(NamedTuple):
    """Status of a sample.

    Attributes:
        sample_status: Status of the sample, see `SampleStatus`.
        samples_missed: Number of samples since the last one that gave a command; 0 if this one did.
    """

    sample_status: Int[Array, ""]
    samples_missed: Annotated[Int[Array, ""], "1"]

    ENUMS = {"sample_status": SampleStatus}  # noqa: RUF012


class GuardMemory(NamedTuple):
    """State of the validation between two samples.

    Attributes:
        last: Last accepted values, in a measurement.
        samples_missed: Number of samples since the last accepted one.
        fields_missed: Number of samples since the last accepted value, for fields with their own
            flag.
    """

    last: Any
    samples_missed: Int[Array, ""]
    fields_missed: dict[str, Any]


class Validated(NamedTuple):
    """Result of the validation of a measurement.

    Attributes:
        measurement: Values that may be used if `good`. For sensors with a flag, the last accepted
            values replace rejected ones.
        good: Whether the measurement may be used.
        status: Status of the sample, see `SampleStatus`.
        used: Memory after a sample that gives a command.
        missed: Memory after a sample that gives no command.
    """

    measurement: Any
    good: Any
    status: Int[Array, ""]
    used: GuardMemory
    missed: GuardMemory


class MeasurementGuard(Checked):
    """Test of each real field of a measurement, before a controller uses it.

    A value is accepted if it is finite, within [lower, upper], and |x - x_last| <= rate T (n + 1).
    Here x_last is the last accepted value, T the control period and n the number of samples since
    then. From n = `REACQUIRE` on, the last value is too old for a comparison and the rate is not
    tested. After a true jump of the signal, a sensor is therefore lost for `REACQUIRE` samples
    only. The tests are the limit and delta checks of ECSS-E-ST-70-41C, service 12, "on-board
    monitoring".

    A measurement with a rejected value is rejected as a whole and has the same effect as a missing
    one. The exception is a sensor with its own flag: the logical field `NAME_measured` belongs to
    the field `NAME` and to all fields whose names begin with `NAME_`. Rejected values of these
    fields clear the flag (one flag for the field, or one for each element), and the last accepted
    values replace them.

    Attributes:
        limits: Limits of each real field, by name; one number for all elements, or one for each.
        on_bad: Safe command after a rejected sample: "hold" or "zero".
        sample: Shapes of the measurement.
    """

    limits: dict[str, FieldLimits]
    on_bad: str = eqx.field(static=True)
    sample: Any = eqx.field(static=True)

    @classmethod
    def of(
        cls,
        measurement: Any,
        limits: Mapping[str, FieldLimits] | None = None,
        on_bad: str = "hold",
    ) -> Self:
        """Guard for measurements of the same form as an example.

        Args:
            measurement: Example of a measurement, or the shapes of one; a named tuple.
            limits: Limits of some real fields, by name. The other fields are only tested to be
                finite.
            on_bad: Safe command after a rejected sample: "hold" or "zero".

        Raises:
            InputError: A name is not that of a real field, or `on_bad` is not "hold" or "zero".
        """
        shapes = jax.tree.map(
            lambda x: jax.ShapeDtypeStruct(jnp.shape(x), jnp.result_type(x)), measurement
        )
        names = [name for name, shape in shapes._asdict().items() if _is_real(shape)]
        bounds = dict(limits or {})
        for name in bounds:
            if name not in names:
                raise InputError(
                    f"limits of a measurement: found {name}, expected one of {', '.join(names)}"
                )
        if on_bad not in ON_BAD:
            raise InputError(f"on bad samples: found {on_bad!r}, expected {' or '.join(ON_BAD)}")
        return cls({name: bounds.get(name, FieldLimits()) for name in names}, on_bad, shapes)

    def check_own(self) -> None:
        """Validate the limits.

        Raises:
            InputError: A limit is NaN, a range is empty, or a rate is not above zero.
        """
        for name, limits in self.limits.items():
            lower, upper = (np.asarray(limit, dtype=float) for limit in limits[:2])
            if not np.all(lower < upper):
                raise InputError(
                    f"limits of {name}: found {lower} to {upper}, expected the lower one first"
                )
            if limits.rate is not None and not np.all(np.asarray(limits.rate) > 0.0):
                raise InputError(f"rate limit of {name}: found {limits.rate}, expected above 0")

    def start(self) -> GuardMemory:
        """Initial memory, without an accepted value."""
        blank = jax.tree.map(lambda shape: jnp.zeros(shape.shape, shape.dtype), self.sample)
        flags = {
            name: jnp.full(jnp.shape(getattr(blank, flag)), REACQUIRE)
            for name in self.limits
            if (flag := self._flag(name)) is not None
        }
        return GuardMemory(blank, jnp.array(REACQUIRE), flags)

    def __call__(self, memory: GuardMemory, measurement: Any, period: Scalar) -> Validated:
        """Validate a measurement.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement as the sensors give it.
            period: Control period, s.
        """
        finite = in_range = slow = jnp.array(True)
        rejected = jnp.array(False)
        values: dict[str, Any] = {}
        flags: dict[str, Any] = {}
        later = {name: _counted(missed) for name, missed in memory.fields_missed.items()}
        reset = {}
        for name, limits in self.limits.items():
            flag, last = self._flag(name), getattr(memory.last, name)
            missed = memory.samples_missed if flag is None else memory.fields_missed[name]
            value = getattr(measurement, name)
            # finiteness is tested first, so that flight code compares only finite values
            is_finite = jnp.isfinite(value)
            is_inside = is_finite & (value >= limits.lower) & (value <= limits.upper)
            is_slow = is_inside
            if limits.rate is not None:
                missed = _expand(missed, last)
                fastest = limits.rate * (period * (missed.astype(float) + 1.0))
                is_slow = is_inside & ((missed >= REACQUIRE) | (jnp.abs(value - last) <= fastest))
            values[name] = value
            if flag is None:
                finite &= jnp.all(is_finite)
                in_range &= jnp.all(is_inside)
                slow &= jnp.all(is_slow)
                continue
            valid, accepted = getattr(measurement, flag), is_slow
            if jnp.shape(valid) != jnp.shape(accepted):
                accepted = jnp.all(accepted)
            rejected |= jnp.any(valid & ~accepted)
            accepted &= valid
            flags[flag] = flags.get(flag, valid) & accepted
            values[name] = jnp.where(accepted, value, last)
            reset[name] = jnp.where(accepted, 0, later[name])
        reason = jnp.where(in_range, int(SampleStatus.TOO_FAST), int(SampleStatus.OUT_OF_RANGE))
        reason = jnp.where(finite, reason, int(SampleStatus.NOT_FINITE))
        fine = jnp.where(rejected, int(SampleStatus.PARTIAL), int(SampleStatus.GOOD))
        sample = measurement._replace(**values, **flags)
        # a field that is not tested may be NaN: it is not kept
        shapes = self.sample._asdict().items()
        untested = [name for name, shape in shapes if _is_real(shape) and name not in values]
        tested = sample._replace(**{name: getattr(memory.last, name) for name in untested})
        return Validated(
            measurement=sample,
            good=slow,
            status=jnp.where(slow, fine, reason),
            used=GuardMemory(tested, jnp.zeros_like(memory.samples_missed), reset),
            missed=GuardMemory(memory.last, _counted(memory.samples_missed), later),
        )

    def _flag(self, name: str) -> str | None:
        """Logical field that states whether a field was measured; None if there is none."""
        for flag in self.sample._fields:
            sensor = flag.removesuffix("_measured")
            if sensor != flag and (name == sensor or name.startswith(f"{sensor}_")):
                return flag
        return None


def _is_real(shape: Any) -> bool:
    return jnp.issubdtype(shape.dtype, jnp.floating)


def _expand(missed: Any, value: Any) -> Any:
    """Sample counts with as many axes as the value that they belong to."""
    return jnp.reshape(missed, jnp.shape(missed) or (1,) * jnp.ndim(value))


def _counted(missed: Int[Array, ""]) -> Int[Array, ""]:
    """Count one more; the largest number stays, because signed overflow is undefined in C."""
    return jnp.minimum(missed, jnp.iinfo(missed.dtype).max - 1) + 1
