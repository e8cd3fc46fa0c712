"""Star tracker and gyro of a spacecraft, as they are sampled in the loop."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat._jax import jax, jnp
from gyrostat.body.rotations import (
    Quaternion,
    Vector,
    error,
    from_rotation_vector,
    product,
    rotation_vector,
)
from gyrostat.body.spacecraft_sensor import SpacecraftSensor
from gyrostat.errors import InputError
from gyrostat.friction import Scalar
from gyrostat.require import check_parts, require
from gyrostat.wheel import PerWheel
from gyrostat.wheel.array import listed


class StarTracker(eqx.Module):
    """The attitude with white noise about each body axis, in every so many control periods.

    Attributes:
        sigma: (3,) of a sample about each body axis, or one for all, rad; about its boresight a
            tracker sees worst.
        periods: control periods from one sample to the next, a whole number; the first sample is
            that at time 0.
    """

    sigma: Vector | float = eqx.field(converter=listed)
    periods: Scalar = 1

    def check(self) -> None:
        """Refuse what is no noise or no number of periods.

        Raises:
            InputError: as said.
        """
        require("star tracker sigma", self.sigma, "rad")
        every = np.asarray(self.periods)
        if not np.all((every >= 1) & (every == np.round(every))):
            raise InputError(
                f"star tracker periods: found {self.periods}, expected whole numbers of 1 or more"
            )

    def __call__(
        self, attitude: Quaternion, samples: Scalar, key: PRNGKeyArray
    ) -> tuple[Quaternion, Bool[Array, ""]]:
        """Measure.

        Args:
            attitude: (4,) as it is.
            samples: control periods since the start.
            key: of the noise.

        Returns:
            The attitude (4,), and whether this is a sample.
        """
        noise = jnp.asarray(self.sigma) * jax.random.normal(key, (3,))
        seen = product(attitude, from_rotation_vector(noise))
        return seen, jnp.mod(samples, self.periods) == 0.0


class RateGyro(eqx.Module):
    """The turn since the last sample over the period, with noise and a bias that walks.

    R. L. Farrenkopf, "Analytic steady-state accuracy solutions for two common spacecraft attitude
    estimators", Journal of Guidance and Control 1 (1978): white noise and a random walk of the
    rate, integrated exactly over the period.

    Attributes:
        angle_walk: sigma_v, of the integrated noise, rad/√s.
        bias_walk: sigma_u, of the bias in the square root of a second, rad/s/√s.
        bias: (3,) at time 0, rad/s.
    """

    angle_walk: Scalar = 0.0
    bias_walk: Scalar = 0.0
    bias: Vector = eqx.field(converter=listed, default_factory=lambda: np.zeros(3))

    def check(self) -> None:
        """Refuse what is no noise or bias, by `InputError`."""
        require("gyro angle walk", self.angle_walk, "rad/√s")
        require("gyro bias walk", self.bias_walk, "rad/s/√s")
        require("size of the gyro bias", np.abs(self.bias), "rad/s")

    def __call__(
        self, before: Quaternion, now: Quaternion, bias: Vector, period: Scalar, key: PRNGKeyArray
    ) -> tuple[Vector, Vector]:
        """Measure.

        Args:
            before: (4,) attitude at the last sample.
            now: (4,) attitude.
            bias: (3,) at the last sample, rad/s.
            period: between both, s.
            key: of the noise.

        Returns:
            The mean rate (3,) over the period, and the bias (3,) now, rad/s.
        """
        white, walk = jax.random.normal(key, (2, 3))
        after = bias + self.bias_walk * jnp.sqrt(period) * walk
        sigma = jnp.sqrt(self.angle_walk**2 / period + self.bias_walk**2 * period / 12.0)
        turned = rotation_vector(error(now, before)) / period
        return turned + 0.5 * (bias + after) + sigma * white, after


class TrackerGyroMeasurement(NamedTuple):
    """What star tracker, gyro and tachometers say.

    Attributes:
        attitude: (4,) of the star tracker, scalar first; to be used where it is measured.
        attitude_measured: whether it is.
        rate: (3,) of the gyro: the mean over the last control period with its bias, rad/s.
        wheel_momentum: (wheels,) rotor inertia times speed relative to the body, N·m·s.
        wheel_measured: (wheels,) whether its sensor works.
    """

    attitude: Quaternion
    attitude_measured: Bool[Array, ""]
    rate: Vector
    wheel_momentum: PerWheel
    wheel_measured: Bool[Array, " wheels"]

    UNITS = {"attitude": "1", "rate": "rad/s", "wheel_momentum": "N·m·s"}  # noqa: RUF012


class _Memory(NamedTuple):
    truth: Any
    samples: Scalar
    period: Scalar
    attitude: Quaternion
    bias: Vector


class TrackerGyroSensors(eqx.Module):
    """Star tracker, gyro and tachometers of a spacecraft.

    Attributes:
        truth: reads the state of the spacecraft: exact but for the noise of the tachometers.
        tracker: of the attitude.
        gyro: of the rate.
    """

    truth: SpacecraftSensor
    tracker: StarTracker
    gyro: RateGyro

    def check(self) -> None:
        """Refuse what a part refuses, by `InputError`."""
        check_parts(self.truth, self.tracker, self.gyro)

    def start(self, state: Any, period: Scalar) -> _Memory:
        """Memory before the first sample, as if the body had turned evenly before."""
        turned = from_rotation_vector(-period * self.truth.gyrostat.rate(state))
        return _Memory(
            self.truth.start(state, period),
            jnp.zeros(()),
            jnp.asarray(period, dtype=float),
            product(state.attitude, turned),
            jnp.asarray(self.gyro.bias, dtype=float),
        )

    def __call__(
        self, memory: _Memory, state: Any, key: PRNGKeyArray
    ) -> tuple[_Memory, TrackerGyroMeasurement]:
        """Measure."""
        first, second, third = jax.random.split(key, 3)
        truth, seen = self.truth(memory.truth, state, first)
        attitude, measured = self.tracker(seen.attitude, memory.samples, second)
        rate, bias = self.gyro(memory.attitude, seen.attitude, memory.bias, memory.period, third)
        measurement = TrackerGyroMeasurement(
            attitude, measured, rate, seen.wheel_momentum, seen.wheel_measured
        )
        after = _Memory(truth, memory.samples + 1.0, memory.period, seen.attitude, bias)
        return after, measurement
