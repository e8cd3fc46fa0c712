"""What a spacecraft measures of itself."""

from typing import NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat._jax import jax, jnp
from gyrostat.body.failures import WheelFailures
from gyrostat.body.gyrostat import Gyrostat, GyrostatState
from gyrostat.body.rotations import Quaternion, Vector, from_rotation_vector, product
from gyrostat.friction import Scalar
from gyrostat.require import check_parts, require
from gyrostat.wheel import PerWheel


class SpacecraftMeasurement(NamedTuple):
    """A measurement of attitude, rate and wheels.

    Attributes:
        attitude: (4,) quaternion of the body in inertial space, scalar first.
        rate: (3,) of the body, in body axes, rad/s.
        wheel_momentum: (wheels,) rotor inertia times speed relative to the body, N·m·s; the last
            one measured where the sensor of a wheel is lost.
        wheel_measured: (wheels,) whether its sensor works.
    """

    attitude: Quaternion
    rate: Vector
    wheel_momentum: PerWheel
    wheel_measured: Bool[Array, " wheels"]

    UNITS = {"attitude": "1", "rate": "rad/s", "wheel_momentum": "N·m·s"}  # noqa: RUF012


class _Memory(NamedTuple):
    samples: Scalar
    period: Scalar
    wheel_momentum: PerWheel


class SpacecraftSensor(eqx.Module):
    """Attitude, body rate and wheel speeds with white noise; wheels lose their tachometers.

    Attributes:
        gyrostat: that is measured; its failures say which tachometers are lost, and when.
        attitude_sigma: of a sample about each body axis, rad.
        rate_sigma: of a sample of each component, rad/s.
        rate_bias: (3,) or one for all, rad/s.
        wheel_sigma: of a sample of each wheel, N·m·s.
    """

    gyrostat: Gyrostat
    attitude_sigma: Scalar = 0.0
    rate_sigma: Scalar = 0.0
    wheel_sigma: Scalar = 0.0
    rate_bias: Vector | Scalar = 0.0

    def check(self) -> None:
        """Refuse noise that is none, by `InputError`."""
        require("attitude sigma", self.attitude_sigma, "rad")
        require("rate sigma", self.rate_sigma, "rad/s")
        require("wheel momentum sigma", self.wheel_sigma, "N·m·s")
        require("rate bias", np.abs(self.rate_bias), "rad/s")
        check_parts(self.gyrostat)

    def start(self, state: GyrostatState, period: Scalar) -> _Memory:
        """Memory before the first sample."""
        momentum = self.gyrostat.spacecraft.wheels.inertia * state.wheel_speed
        return _Memory(jnp.zeros(()), jnp.asarray(period, dtype=float), momentum)

    def __call__(
        self, memory: _Memory, state: GyrostatState, key: PRNGKeyArray
    ) -> tuple[_Memory, SpacecraftMeasurement]:
        """Measure."""
        turn, rate, wheel = jax.random.split(key, 3)
        count = self.gyrostat.spacecraft.wheels.count
        failures = self.gyrostat.failures or WheelFailures.none(count)
        # a sum of periods would drift, and a multiple is not exactly the time that it stands for
        time = memory.samples * memory.period + 1e-9
        measured = ~(failures.failed(time) & failures.sensor_lost)
        momentum = self.gyrostat.spacecraft.wheels.inertia * state.wheel_speed
        momentum = momentum + self.wheel_sigma * jax.random.normal(wheel, (count,))
        momentum = jnp.where(measured, momentum, memory.wheel_momentum)
        small = self.attitude_sigma * jax.random.normal(turn, (3,))
        noise = self.rate_sigma * jax.random.normal(rate, (3,))
        measurement = SpacecraftMeasurement(
            attitude=product(state.attitude, from_rotation_vector(small)),
            rate=self.gyrostat.rate(state) + self.rate_bias + noise,
            wheel_momentum=momentum,
            wheel_measured=measured,
        )
        return _Memory(memory.samples + 1.0, memory.period, momentum), measurement
