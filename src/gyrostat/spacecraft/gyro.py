"""Gyro and combined sensors of an air-bearing table."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Tachometer


class Turn(NamedTuple):
    """Measured attitude and rate of a table.

    Attributes:
        attitude: Attitude angle, rad.
        rate: Rate, rad/s.
    """

    attitude: Float[Array, ""]
    rate: Float[Array, ""]


class TrueTurn(eqx.Module):
    """Ideal sensor of attitude and rate."""

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """Empty memory."""
        return ()

    def __call__(self, memory: tuple[()], state: Any, key: PRNGKeyArray) -> tuple[tuple[()], Turn]:
        """Read the state."""
        return memory, Turn(state.attitude, state.rate)


class Gyro(Checked):
    """Gyro: mean rate over the period with noise and bias, integrated to the attitude.

    Attributes:
        sigma: Standard deviation of the white noise of a sample, rad/s.
        bias: Bias, rad/s.
    """

    sigma: Annotated[Scalar, size("gyro sigma", "rad/s")] = 0.0
    bias: Annotated[Scalar, signed("gyro bias", "rad/s")] = 0.0

    def start(self, state: Any, period: Scalar) -> tuple[Array, Array, Scalar]:
        """Memory: true attitude one period before, rad; integrated attitude, rad; period, s."""
        return state.attitude - period * state.rate, state.attitude - period * state.rate, period

    def __call__(
        self, memory: tuple[Array, Array, Scalar], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[Array, Array, Scalar], Turn]:
        """Measure the rate, rad/s, and integrate it to the attitude, rad."""
        before, integrated, period = memory
        noise = self.sigma * jax.random.normal(key, jnp.shape(state.attitude))
        rate = (state.attitude - before) / period + self.bias + noise
        integrated = integrated + period * rate
        return (state.attitude, integrated, period), Turn(integrated, rate)


class TableMeasurement(NamedTuple):
    """Measurement of an air-bearing table, for its controller.

    Attributes:
        attitude: Attitude angle of the table, rad.
        rate: Rate of the table, rad/s.
        speed: Wheel speed relative to the table, rad/s.
    """

    attitude: Annotated[Float[Array, ""], "rad"]
    rate: Annotated[Float[Array, ""], "rad/s"]
    speed: Annotated[Float[Array, ""], "rad/s"]


class TableSensors(Checked):
    """Gyro of an air-bearing table and tachometer of its wheel.

    Attributes:
        gyro: Sensor that gives a `Turn`.
        tachometer: Sensor that gives the wheel speed, rad/s.
    """

    gyro: Any = TrueTurn()
    tachometer: Any = Tachometer()

    def start(self, state: Any, period: Scalar) -> tuple[Any, Any]:
        """Memories of gyro and tachometer."""
        return self.gyro.start(state, period), self.tachometer.start(state, period)

    def __call__(
        self, memory: tuple[Any, Any], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[Any, Any], TableMeasurement]:
        """Measure attitude, rate and wheel speed."""
        gyro_key, tachometer_key = jax.random.split(key)
        gyro, turn = self.gyro(memory[0], state, gyro_key)
        tachometer, speed = self.tachometer(memory[1], state, tachometer_key)
        return (gyro, tachometer), TableMeasurement(turn.attitude, turn.rate, speed)
