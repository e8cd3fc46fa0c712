"""Tachometers: noise, pulse counting, low-pass filter, delay.

A sensor has `start(state, period) -> memory` and `sensor(memory, state, key) -> memory, value`. It
is sampled once in each control period.
"""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size, within
from gyrostat.core.delay_line import empty_line, pushed
from gyrostat.core.jax64 import jax, jnp


class Tachometer(Checked):
    """Tachometer with white noise.

    Attributes:
        sigma: Standard deviation of a sample, rad/s.
    """

    sigma: Annotated[Scalar, size("tachometer sigma", "rad/s")] = 0.0

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """Initial memory; empty."""
        return ()

    def __call__(
        self, memory: tuple[()], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[()], Float[Array, ""]]:
        """Measure `state.speed`, rad/s."""
        return memory, state.speed + self.sigma * jax.random.normal(key, jnp.shape(state.speed))


class PulseTachometer(Checked):
    """Tachometer that counts pulses over a gate time and senses the direction of rotation.

    The direction comes from two channels or from Hall sensors. One pulse corresponds to a speed of
    2 pi / (N gate). For one wheel, or several at once.

    Attributes:
        pulses: Number of pulses N in one revolution.
        gate_periods: Gate time in control periods, an integer.
    """

    pulses: Annotated[Scalar, positive("tachometer pulses")]
    gate_periods: Annotated[int, positive("tachometer gate", "periods")] = eqx.field(
        static=True, default=1
    )

    def start(self, state: Any, period: Scalar) -> tuple[Array, Scalar]:
        """Counts at the last samples, for a constant speed before the start, and gate time, s."""
        back = jnp.arange(self.gate_periods, 0, -1) * period
        back = back.reshape(-1, *(1,) * jnp.ndim(state.speed))
        before = (state.wheel_angle - back * state.speed) * self.pulses / (2.0 * jnp.pi)
        return jnp.floor(before), self.gate_periods * period

    def __call__(
        self, memory: tuple[Array, Scalar], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[Array, Scalar], Float[Array, ""]]:
        """Count the pulses of the last gate time and return the speed, rad/s."""
        counts, gate = memory
        count = jnp.floor(state.wheel_angle * self.pulses / (2.0 * jnp.pi))
        speed = (count - counts[0]) * 2.0 * jnp.pi / (self.pulses * gate)
        return (jnp.concatenate([counts[1:], count[None]]), gate), speed


_pulse_rule = within(
    "tachometer pulses",
    "1 or more, or 0 for a speed without steps",
    lambda pulses: (pulses == 0.0) | ((pulses >= 1.0) & np.isfinite(pulses)),
)


class WheelTachometer(Checked):
    """Tachometer of one or several wheels with pulses, white noise and a first-order lag.

    The pulses of each control period are counted as in `PulseTachometer` and give the mean speed of
    the period; without pulses, the speed at the sample is measured. The noise is added next, and
    the lag of `LowPass` comes last. All three parameters are numbers that a scenario can disperse.

    Attributes:
        sigma: Standard deviation of the noise of a sample, rad/s.
        pulses: Number of pulses in one revolution; 0: the speed is not quantised.
        time_constant: Time constant of the lag, s; 0: no lag.
    """

    sigma: Annotated[Scalar, size("tachometer sigma", "rad/s")] = 0.0
    pulses: Annotated[Scalar, _pulse_rule] = 0.0
    time_constant: Annotated[Scalar, size("tachometer time constant", "s")] = 0.0

    def _counter(self) -> PulseTachometer:
        return PulseTachometer(jnp.where(jnp.asarray(self.pulses) > 0.0, self.pulses, 1.0))

    def start(self, state: Any, period: Scalar) -> tuple[Any, Array, Array, Array]:
        """Memory of the counter, filtered speed, whether there is one, and decay of the filter."""
        lags = jnp.asarray(self.time_constant) > 0.0
        decay = jnp.exp(-period / jnp.where(lags, self.time_constant, 1.0))
        decay = jnp.where(lags, decay, 0.0)
        filtered = jnp.zeros_like(jnp.asarray(state.speed, dtype=float))
        return self._counter().start(state, period), filtered, jnp.array(False), decay

    def __call__(
        self, memory: tuple[Any, Array, Array, Array], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[Any, Array, Array, Array], Array]:
        """Measure `state.speed`, rad/s; the pulses are counted from `state.wheel_angle`, rad."""
        counter, filtered, started, decay = memory
        counter, mean_speed = self._counter()(counter, state, key)
        speed = jnp.where(jnp.asarray(self.pulses) > 0.0, mean_speed, state.speed)
        speed = speed + self.sigma * jax.random.normal(key, jnp.shape(state.speed))
        filtered = jnp.where(started, decay * filtered + (1.0 - decay) * speed, speed)
        return (counter, filtered, jnp.array(True), decay), filtered


class LowPass(Checked):
    """Sensor with a first-order low-pass filter, exact for its samples.

    Attributes:
        sensor: Sensor whose values are filtered.
        time_constant: Time constant of the filter, s.
    """

    sensor: Any
    time_constant: Annotated[Scalar, positive("low pass time constant", "s")]

    def start(self, state: Any, period: Scalar) -> tuple[Any, Array, Array, Scalar]:
        """Memory of the sensor, filtered value, whether it is initialised, and filter decay."""
        decay = jnp.exp(-period / self.time_constant)
        memory = self.sensor.start(state, period)
        value = jax.eval_shape(self.sensor, memory, state, jax.random.key(0))[1]
        return memory, jnp.zeros(value.shape), jnp.array(False), decay

    def __call__(self, memory: Any, state: Any, key: PRNGKeyArray) -> tuple[Any, Array]:
        """Measure and filter; the first sample initialises the filter."""
        inner, filtered, started, decay = memory
        inner, value = self.sensor(inner, state, key)
        filtered = jnp.where(started, decay * filtered + (1.0 - decay) * value, value)
        return (inner, filtered, jnp.array(True), decay), filtered


class Delayed(Checked):
    """Sensor with delayed samples; until the first one arrives, it is returned for all samples.

    Attributes:
        sensor: Sensor whose values are delayed.
        periods: Delay in control periods, an integer of 1 or more.
    """

    sensor: Any
    periods: Annotated[int, positive("sensor delay", "periods")] = eqx.field(static=True)

    def start(self, state: Any, period: Scalar) -> Any:
        """Memory of the sensor, the delay line (empty), and whether it has been filled."""
        memory = self.sensor.start(state, period)
        sample = jax.eval_shape(self.sensor, memory, state, jax.random.key(0))[1]
        return memory, empty_line(sample, self.periods), jnp.array(False)

    def __call__(self, memory: Any, state: Any, key: PRNGKeyArray) -> tuple[Any, Any]:
        """Measure now, and return the measurement of `periods` ago."""
        inner, under_way, started = memory
        inner, sample = self.sensor(inner, state, key)
        under_way = jax.tree.map(lambda u, s: jnp.where(started, u, s), under_way, sample)
        under_way, arrived = pushed(under_way, sample)
        return (inner, under_way, jnp.array(True)), arrived
