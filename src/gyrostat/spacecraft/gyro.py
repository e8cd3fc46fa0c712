"""Gyro and combined sensors of an air-bearing table."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Tachometer


class Turn(NamedTuple):
    """What a gyro says of a table.

    Attributes:
        attitude: rad.
        rate: rad/s.
    """

    attitude: Float[Array, ""]
    rate: Float[Array, ""]


class TrueTurn(eqx.Module):
    """Attitude and rate as they are."""

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """It has no memory."""
        return ()

    def __call__(self, memory: tuple[()], state: Any, key: PRNGKeyArray) -> tuple[tuple[()], Turn]:
        """Read the state."""
        return memory, Turn(state.attitude, state.rate)


class Gyro(Checked):
    """The angle turned since the last sample over the period, with noise and bias, and its sum.

    Attributes:
        sigma: white noise of a sample, rad/s.
        bias: rad/s.
    """

    sigma: Annotated[Scalar, size("gyro sigma", "rad/s")] = 0.0
    bias: Annotated[Scalar, signed("gyro bias", "rad/s")] = 0.0

    def start(self, state: Any, period: Scalar) -> tuple[Array, Array, Scalar]:
        """True attitude a period before, integrated attitude, period."""
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
    """What the controller of an air-bearing table is given.

    Attributes:
        attitude: of the table, rad.
        rate: of the table, rad/s.
        speed: of the wheel relative to the table, rad/s.
    """

    attitude: Annotated[Float[Array, ""], "rad"]
    rate: Annotated[Float[Array, ""], "rad/s"]
    speed: Annotated[Float[Array, ""], "rad/s"]


class TableSensors(Checked):
    """The gyro of a table and the tachometer of its wheel.

    Attributes:
        gyro: gives a `Turn`.
        tachometer: gives the wheel speed, rad/s.
    """

    gyro: Any = TrueTurn()
    tachometer: Any = Tachometer()

    def start(self, state: Any, period: Scalar) -> tuple[Any, Any]:
        """Memories of both."""
        return self.gyro.start(state, period), self.tachometer.start(state, period)

    def __call__(
        self, memory: tuple[Any, Any], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[Any, Any], TableMeasurement]:
        """Measure with both."""
        first, second = jax.random.split(key)
        gyro, turn = self.gyro(memory[0], state, first)
        tachometer, speed = self.tachometer(memory[1], state, second)
        return (gyro, tachometer), TableMeasurement(turn.attitude, turn.rate, speed)
