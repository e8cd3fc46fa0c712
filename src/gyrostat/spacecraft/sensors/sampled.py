"""Sampling interval and latency of a sensor."""

from typing import Annotated, Any, NamedTuple, Protocol

import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, within
from gyrostat.core.jax64 import jax, jnp

LONGEST = 16
"""Longest latency, control periods."""
_interval = within(
    "sampling interval",
    "a whole number of control periods, 1 or more",
    lambda value: (value >= 1.0) & (value == np.round(value)),
)
_latency = within(
    "latency of a sensor",
    f"a whole number of control periods, 0 to {LONGEST}",
    lambda value: (value >= 0.0) & (value <= LONGEST) & (value == np.round(value)),
)


class InstantSensor(Protocol):
    """Protocol of a sensor without memory, which `Sampled` calls.

    Its attribute `unit` is the unit of the value.
    """

    def __call__(self, state: Any, time: Scalar, key: PRNGKeyArray) -> Any:
        """Measured value, a number or an array.

        Args:
            state: State of the plant.
            time: Time of the sample, s.
            key: Random key of the noise of this sample.
        """
        ...


class _Memory(NamedTuple):
    samples: Scalar
    period: Scalar
    line: Float[Array, "..."]


class Sampled(Checked):
    """Sensor with a sampling interval and a latency, as an `AddedSensor`.

    The first sample is at time 0. Between samples, the last value is held. The value that the
    controller gets is that of `latency` control periods ago; until then it is the first sample.

    Attributes:
        sensor: Sensor without memory.
        periods: Control periods from one sample to the next, a whole number.
        latency: Control periods from a sample to its use, a whole number up to `LONGEST`.
    """

    sensor: InstantSensor
    periods: Annotated[Scalar, _interval] = 1.0
    latency: Annotated[Scalar, _latency] = 0.0

    @property
    def unit(self) -> str:
        """Unit of the value."""
        return getattr(self.sensor, "unit", "1")

    def start(self, state: Any, period: Scalar) -> _Memory:
        """Memory before the first sample.

        Args:
            state: State of the plant at time 0.
            period: Control period, s.
        """
        sample = jax.eval_shape(self._value, state, jnp.zeros(()), jax.random.key(0))
        line = jnp.zeros((LONGEST + 1, *sample.shape))
        return _Memory(jnp.zeros(()), jnp.asarray(period, dtype=float), line)

    def _value(self, state: Any, time: Scalar, key: PRNGKeyArray) -> Array:
        return jnp.asarray(self.sensor(state, time, key), dtype=float)

    def __call__(self, memory: _Memory, state: Any, key: PRNGKeyArray) -> tuple[_Memory, Array]:
        """Measure.

        Args:
            memory: Memory from the last sample.
            state: State of the plant.
            key: Random key of the noise of this sample.
        """
        samples, period, line = memory
        # a product, because a sum of periods would drift
        value = self._value(state, samples * period, key)
        latest = jnp.where(jnp.mod(samples, self.periods) == 0.0, value, line[-1])
        pushed = jnp.concatenate([line[1:], latest[None]])
        line = jnp.where(samples == 0.0, jnp.broadcast_to(value, line.shape), pushed)
        age = jnp.asarray(LONGEST - self.latency, dtype=float).astype(int)
        output = jax.lax.dynamic_slice_in_dim(line, age, 1)[0]
        return _Memory(samples + 1.0, period, line), output
