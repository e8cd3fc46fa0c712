"""Star tracker and gyro of a spacecraft."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, size, within
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_tuples import with_fields
from gyrostat.core.rotations import from_rotation_vector, product
from gyrostat.spacecraft.rate_gyro import BodyMotion
from gyrostat.spacecraft.spacecraft_sensor import SpacecraftSensor
from gyrostat.wheel.array import listed

whole_periods = within(
    "star tracker periods",
    "whole numbers of 1 or more",
    lambda value: (value >= 1.0) & (value == np.round(value)),
)
"""Rule for the interval between samples of a star tracker, control periods."""


class StarTracker(Checked):
    """Star tracker: attitude with white noise about each body axis, every few control periods.

    Attributes:
        sigma: Standard deviation about each body axis, (3,), or one value for all, rad; it is
            largest about the boresight of a star tracker.
        periods: Control periods from one sample to the next, a whole number; the first sample is
            at time 0.
    """

    sigma: Annotated[Vector3 | float, size("star tracker sigma", "rad")] = eqx.field(
        converter=listed
    )
    periods: Annotated[Scalar, whole_periods] = 1

    def start(self) -> tuple[()]:
        """Empty memory."""
        return ()

    def __call__(
        self,
        motion: BodyMotion,
        memory: tuple[()],
        samples: Scalar,
        period: Scalar,
        key: PRNGKeyArray,
    ) -> tuple[Quaternion, Bool[Array, ""], tuple[()]]:
        """Measure the attitude.

        Args:
            motion: True attitude and rate.
            memory: Empty memory.
            samples: Control periods since the start.
            period: Unused.
            key: Random key of the noise.

        Returns:
            The measured attitude, (4,), whether the tracker has a sample at this time, and the
            memory.
        """
        noise = jnp.asarray(self.sigma) * jax.random.normal(key, (3,))
        attitude = product(motion.attitude, from_rotation_vector(noise))
        return attitude, jnp.mod(samples, self.periods) == 0.0, memory


class TrackerGyroMeasurement(NamedTuple):
    """Measurement of star tracker, gyro and tachometers.

    Attributes:
        attitude: Attitude from the star tracker, (4,), scalar first; use only if measured.
        attitude_measured: Whether the attitude is measured at this sample.
        rate: Gyro rate, mean over the last control period with the gyro bias, (3,), rad/s.
        wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s; the last measured speed
            if the tachometer is lost.
        wheel_measured: Whether each tachometer works, (wheels,).
    """

    attitude: Annotated[Quaternion, "1"]
    attitude_measured: Bool[Array, ""]
    rate: Annotated[Vector3, "rad/s"]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    wheel_measured: Bool[Array, " wheels"]


class TrackerMeasurement(NamedTuple):
    """Measurement of star tracker and tachometers, without a gyro.

    Attributes:
        attitude: Attitude from the star tracker, (4,), scalar first; use only if measured.
        attitude_measured: Whether the attitude is measured at this sample.
        wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s; the last measured speed
            if the tachometer is lost.
        wheel_measured: Whether each tachometer works, (wheels,).
    """

    attitude: Annotated[Quaternion, "1"]
    attitude_measured: Bool[Array, ""]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    wheel_measured: Bool[Array, " wheels"]


class _Memory(NamedTuple):
    truth: Any
    samples: Scalar
    period: Scalar
    motion: BodyMotion
    tracker: Any
    gyro: Any


class TrackerGyroSensors(Checked):
    """Star tracker, gyro and tachometers of a spacecraft.

    The measurement is a `TrackerGyroMeasurement`; without a gyro, it is a `TrackerMeasurement`.
    With `StarTrackerHeads`, it also has the field `tracker_heads`, (heads,): whether each head has
    a sample. The attitude is measured if one has.

    Attributes:
        truth: Source of the true state, with the tachometers.
        tracker: `StarTracker` or `StarTrackerHeads`.
        gyro: `RateGyro` or `DataSheetGyro`; None for none.
    """

    truth: SpacecraftSensor
    tracker: Any
    gyro: Any = None

    def start(self, state: Any, period: Scalar) -> _Memory:
        """Memory before the first sample, for a constant body rate before the start."""
        rate = self._rate(state)
        previous = product(state.attitude, from_rotation_vector(-period * rate))
        motion = BodyMotion(previous, rate)
        return _Memory(
            self.truth.start(state, period),
            jnp.zeros(()),
            jnp.asarray(period, dtype=float),
            motion,
            self.tracker.start(),
            None if self.gyro is None else self.gyro.start(motion),
        )

    def __call__(self, memory: _Memory, state: Any, key: PRNGKeyArray) -> tuple[_Memory, Any]:
        """Measure attitude, rate if there is a gyro, and wheel speeds."""
        truth_key, tracker_key, gyro_key = jax.random.split(key, 3)
        truth, sample = self.truth(memory.truth, state, truth_key)
        motion = BodyMotion(sample.attitude, self._rate(state))
        attitude, sees, tracker = self.tracker(
            motion, memory.tracker, memory.samples, memory.period, tracker_key
        )
        sampled, wheels = jnp.any(sees), (sample.wheel_speed, sample.wheel_measured)
        measurement: Any = TrackerMeasurement(attitude, sampled, *wheels)
        gyro = memory.gyro
        if self.gyro is not None:
            rate, gyro = self.gyro(memory.motion, motion, gyro, memory.period, gyro_key)
            measurement = TrackerGyroMeasurement(attitude, sampled, rate, *wheels)
        if sees.ndim:
            measurement = with_fields("Heads", measurement, {"tracker_heads": sees}, {})
        after = _Memory(truth, memory.samples + 1.0, memory.period, motion, tracker, gyro)
        return after, measurement

    def _rate(self, state: Any) -> Vector3:
        plant = self.truth.gyrostat
        # only plants with wheel imbalance have jitter to be removed
        return getattr(plant, "balanced_rate", plant.rate)(state)
