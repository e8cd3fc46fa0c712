"""Attitude, rate and wheel measurements of a spacecraft."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector, product
from gyrostat.spacecraft.failures import WheelFailures
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_state import GyrostatState
from gyrostat.wheel import Tachometer


class SpacecraftMeasurement(NamedTuple):
    """Measured attitude, rate and wheel speeds.

    Controllers compute the wheel momentum with the rotor inertia of their own model.

    Attributes:
        attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
        rate: Body rate in body axes, (3,), rad/s.
        wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s; the last measured speed
            if the tachometer is lost.
        wheel_measured: Whether each tachometer works, (wheels,).
    """

    attitude: Annotated[Quaternion, "1"]
    rate: Annotated[Vector3, "rad/s"]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    wheel_measured: Bool[Array, " wheels"]


class WheelMotion(NamedTuple):
    """Wheel motion that a tachometer measures.

    Attributes:
        speed: Wheel speeds relative to the body, (wheels,), rad/s.
        wheel_angle: Rotor angles relative to the body, (wheels,), rad.
    """

    speed: PerWheel
    wheel_angle: PerWheel


class _Memory(NamedTuple):
    samples: Scalar
    period: Scalar
    wheels: WheelMotion
    tachometer: Any
    measured: PerWheel


class SpacecraftSensor(Checked):
    """Attitude and body rate with white noise, and wheel speeds from tachometers.

    A pulse tachometer needs the rotor angles. If the state of the plant does not contain them, they
    are integrated here by the trapezoidal rule over control periods. This is exact for constant
    wheel acceleration; a change of the acceleration by a within a period T shifts the angle by at
    most a T^2 / 8.

    Attributes:
        gyrostat: Plant to measure; its failures determine which tachometers are lost, and when.
        attitude_sigma: Standard deviation of the attitude about each body axis, rad.
        rate_sigma: Standard deviation of each component of the body rate, rad/s.
        wheel_sigma: Standard deviation of each wheel momentum, N·m·s: an older parameter for the
            noise of the tachometers. It is divided by the rotor inertias of `gyrostat`.
        rate_bias: Bias of the body rate, (3,), or one value for all, rad/s.
        tachometer: Tachometer of all wheels, see `gyrostat.wheel`; None: white noise of
            `wheel_sigma`.
    """

    gyrostat: Gyrostat
    attitude_sigma: Annotated[Scalar, size("attitude sigma", "rad")] = 0.0
    rate_sigma: Annotated[Scalar, size("rate sigma", "rad/s")] = 0.0
    wheel_sigma: Annotated[Scalar, size("wheel momentum sigma", "N·m·s")] = 0.0
    rate_bias: Annotated[Vector3 | Scalar, signed("rate bias", "rad/s")] = 0.0
    tachometer: Any = None

    def check_own(self) -> None:
        """Validate the noise of the tachometers.

        Raises:
            InputError: Both `wheel_sigma` and a tachometer are given.
        """
        if self.tachometer is not None and np.any(np.asarray(self.wheel_sigma) != 0.0):
            raise InputError("spacecraft sensor: found wheel_sigma and a tachometer, expected one")

    def _tachometer(self) -> Any:
        if self.tachometer is not None:
            return self.tachometer
        return Tachometer(self.wheel_sigma / self.gyrostat.spacecraft.wheels.inertia)

    def start(self, state: GyrostatState, period: Scalar) -> _Memory:
        """Memory before the first sample."""
        speed = jnp.asarray(state.wheel_speed)
        angle = getattr(state, "wheel_angle", None)
        wheels = WheelMotion(speed, jnp.zeros_like(speed) if angle is None else angle)
        tachometer = self._tachometer().start(wheels, period)
        period = jnp.asarray(period, dtype=float)
        # the first sample is at the start, so that no angle is integrated before it
        return _Memory(jnp.zeros(()), period, wheels, tachometer, speed)

    def __call__(
        self, memory: _Memory, state: GyrostatState, key: PRNGKeyArray
    ) -> tuple[_Memory, SpacecraftMeasurement]:
        """Measure attitude, rate and wheel speeds."""
        turn, rate, wheel = jax.random.split(key, 3)
        failures = self.gyrostat.failures or WheelFailures.none(state.wheel_speed.shape[-1])
        # a product, because a sum of periods would drift; tolerance for its rounding error
        time = memory.samples * memory.period + 1e-9
        measured = ~(failures.failed(time) & failures.sensor_lost)
        wheels = self._motion(memory, state)
        tachometer, speed = self._tachometer()(memory.tachometer, wheels, wheel)
        speed = jnp.where(measured, speed, memory.measured)
        small = self.attitude_sigma * jax.random.normal(turn, (3,))
        noise = self.rate_sigma * jax.random.normal(rate, (3,))
        measurement = SpacecraftMeasurement(
            attitude=product(state.attitude, from_rotation_vector(small)),
            rate=self.gyrostat.rate(state) + self.rate_bias + noise,
            wheel_speed=speed,
            wheel_measured=measured,
        )
        samples = memory.samples + 1.0
        return _Memory(samples, memory.period, wheels, tachometer, speed), measurement

    def _motion(self, memory: _Memory, state: GyrostatState) -> WheelMotion:
        angle = getattr(state, "wheel_angle", None)
        if angle is None:
            elapsed = jnp.where(memory.samples > 0.0, memory.period, 0.0)
            mean = 0.5 * (memory.wheels.speed + state.wheel_speed)
            angle = memory.wheels.wheel_angle + elapsed * mean
        return WheelMotion(state.wheel_speed, angle)
