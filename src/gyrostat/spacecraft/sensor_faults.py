"""Sensor faults: dropouts, spikes, stuck values, drifts and wrong scales."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

DROPOUT, SPIKE, STUCK, DRIFT, SCALE = "dropout", "spike", "stuck", "drift", "scale"
KINDS = (DROPOUT, SPIKE, STUCK, DRIFT, SCALE)
RANDOM = (DROPOUT, SPIKE)
"""Kinds that affect each sample with a probability."""


class SensorFault(Checked):
    """Fault of one field of a measurement.

    Attributes:
        field: Name of the field.
        kind: "dropout": samples are missing, NaN; "spike": `magnitude` is added; "stuck": the
            sensor repeats its last value before the fault; "drift": an offset grows by `slope`
            from zero; "scale": the value is multiplied by `factor`.
        time: Start of the fault, s.
        until: End of the fault, s; infinite: permanent.
        magnitude: Size of a spike, in the unit of the field.
        share: Probability that a sample of a dropout or spike is affected, 0 to 1; the other faults
            affect all samples.
        slope: Growth of the offset of a drift, in the unit of the field per second.
        factor: Factor of a wrong scale.
        element: Index of the affected element, from 0; None for all.
    """

    field: str = eqx.field(static=True)
    kind: str = eqx.field(static=True)
    time: Scalar
    until: Scalar = np.inf
    magnitude: Scalar = 0.0
    share: Scalar = 1.0
    slope: Scalar = 0.0
    factor: Scalar = 1.0
    element: int | None = eqx.field(static=True, default=None)

    def check_own(self) -> None:
        """Validate parameters.

        Raises:
            InputError: An unknown kind, an end that is not after the start, a share outside 0 to 1,
                or a magnitude, slope or factor that is not finite.
        """
        if self.kind not in KINDS:
            raise InputError(f"sensor fault: found kind {self.kind!r}, expected {', '.join(KINDS)}")
        time, until, share = (np.asarray(v, float) for v in (self.time, self.until, self.share))
        if not np.all((time >= 0.0) & (until > time)):
            raise InputError(
                f"sensor fault of {self.field}: found {time} s to {until} s, expected a start of "
                "0 s or later and an end after it"
            )
        if not np.all((share >= 0.0) & (share <= 1.0)):
            raise InputError(f"sensor fault of {self.field}: found share {share}, expected 0 to 1")
        for name in ("magnitude", "slope", "factor"):
            value = getattr(self, name)
            if not np.all(np.isfinite(np.asarray(value, float))):
                raise InputError(
                    f"sensor fault of {self.field}: found {name} {value}, expected a finite number"
                )

    def __call__(self, value: Any, before: Any, time: Scalar, key: PRNGKeyArray) -> Any:
        """Measured value with the fault.

        Args:
            value: Value without the fault.
            before: Last value before the fault.
            time: Time of the sample, s.
            key: Random key of the draws.
        """
        # tolerance, because a multiple of the period has a rounding error
        acts = (self.time <= time + 1e-9) & (time + 1e-9 < self.until)
        if self.kind in RANDOM:
            acts &= jax.random.uniform(key) < self.share
        wrong = {
            DROPOUT: lambda: jnp.nan,
            SPIKE: lambda: value + self.magnitude,
            STUCK: lambda: before,
            DRIFT: lambda: value + self.slope * (time - self.time),
            SCALE: lambda: self.factor * value,
        }[self.kind]()
        hit = jnp.ones(jnp.shape(value), bool)
        if self.element is not None:
            hit = jnp.arange(len(value)) == self.element
        return jnp.where(acts & hit, wrong, value)


class _Memory(NamedTuple):
    sensor: Any
    samples: Scalar
    period: Scalar
    before: tuple[Any, ...]


class FaultySensor(Checked):
    """Sensor with faults, applied in the given order.

    Attributes:
        sensor: Any sensor whose measurement is a named tuple.
        faults: Faults of the fields of the measurement.
    """

    sensor: Any
    faults: tuple[SensorFault, ...]

    def start(self, state: Any, period: Scalar) -> _Memory:
        """Memory before the first sample."""
        inner = self.sensor.start(state, period)
        _, measurement = jax.eval_shape(self.sensor, inner, state, jax.random.key(0))
        before = tuple(jnp.zeros(getattr(measurement, fault.field).shape) for fault in self.faults)
        return _Memory(inner, jnp.zeros(()), jnp.asarray(period, dtype=float), before)

    def __call__(self, memory: _Memory, state: Any, key: PRNGKeyArray) -> tuple[_Memory, Any]:
        """Measure and apply the faults."""
        time = memory.samples * memory.period
        inner, measurement = self.sensor(memory.sensor, state, key)
        before = []
        for number, (fault, last) in enumerate(zip(self.faults, memory.before, strict=True)):
            value = getattr(measurement, fault.field)
            last = jnp.where(memory.samples == 0.0, value, last)
            # another key than that of the sensor noise
            fault_key = jax.random.fold_in(jax.random.fold_in(key, 0x5EED), number)
            faulty_value = fault(value, last, time, fault_key)
            before.append(jnp.where(fault.time <= time + 1e-9, last, value))
            measurement = measurement._replace(**{fault.field: faulty_value})
        return _Memory(inner, memory.samples + 1.0, memory.period, tuple(before)), measurement
