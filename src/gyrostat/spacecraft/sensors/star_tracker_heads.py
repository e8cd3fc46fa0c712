"""Star tracker with several heads, each with a boresight, noise and blinding."""

from typing import Annotated, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, direction, limit, positive, signed, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import from_rotation_vector, product
from gyrostat.spacecraft.attitude_sensors import whole_periods
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.rate_gyro import BodyMotion
from gyrostat.spacecraft.sensors.keep_out import KeepOut
from gyrostat.wheel.array import listed, zeros

FIELD_LENGTH = np.radians(1.0)
"""Usual rotation over which the field of view error is correlated, rad."""
_FIELD_KEY = 0xF1E1D


class Blinding(NamedTuple):
    """What blinds a head: Sun, limb of the Earth, Moon, body rate."""

    sun: Bool[Array, ""]
    earth: Bool[Array, ""]
    moon: Bool[Array, ""]
    rate: Bool[Array, ""]


class StarTrackerHead(Checked):
    """Head of a star tracker.

    A head is blind if its boresight is too near to the Sun, to the limb of the Earth, lit or not,
    or to the Moon in any phase, or if the body turns too fast. Sun and Moon do not blind it from
    behind the Earth. Other bright objects are not modelled.

    Attributes:
        orbit: Orbit with the Sun.
        across: Standard deviation about each axis across the boresight, rad.
        about: Standard deviation about the boresight, rad.
        boresight: Boresight in body axes, (3,), of any length.
        misalignment: Constant error of the measured attitude, rotation vector in body axes, (3,),
            rad.
        sun_exclusion: Smallest angle between boresight and Sun, rad.
        earth_exclusion: Smallest angle between boresight and limb of the Earth, rad.
        moon_exclusion: Smallest angle between boresight and centre of the Moon, rad; above 0, the
            orbit must hold the Moon.
        rate_limit: Largest body rate, rad/s; infinite: no limit.
        doubling_rate: Body rate at which the standard deviations have doubled, rad/s; infinite: the
            noise does not grow.
        delay: Time between exposure and time tag that is not corrected, s.
        orbit_error: Amplitude of an error once per orbit, such as that of thermal distortion,
            rotation vector in body axes, (3,), rad.
        orbit_phase: Its phase at time 0, rad.
        field_error: Standard deviation across the boresight of the error that changes as the stars
            move over the field of view, rad; about the boresight it is larger as the noise is.
        field_length: Rotation of the body over which this error is correlated, rad.
    """

    orbit: OrbitEnvironment
    across: Annotated[Scalar, positive("star tracker sigma across the boresight", "rad")]
    about: Annotated[Scalar, positive("star tracker sigma about the boresight", "rad")]
    boresight: Annotated[Vector3, direction("boresight of a star tracker")] = eqx.field(
        converter=listed, default_factory=lambda: np.array([0.0, 0.0, 1.0])
    )
    misalignment: Annotated[Vector3, signed("size of the head's misalignment", "rad")] = zeros()
    sun_exclusion: Annotated[Scalar, size("sun exclusion angle", "rad")] = 0.0
    earth_exclusion: Annotated[Scalar, size("earth exclusion angle", "rad")] = 0.0
    moon_exclusion: Annotated[Scalar, size("moon exclusion angle", "rad")] = 0.0
    rate_limit: Annotated[Scalar, limit("star tracker rate limit", "rad/s")] = np.inf
    doubling_rate: Annotated[Scalar, limit("star tracker doubling rate", "rad/s")] = np.inf
    delay: Annotated[Scalar, size("star tracker delay", "s")] = 0.0
    orbit_error: Annotated[Vector3, signed("size of the head's orbit error", "rad")] = zeros()
    orbit_phase: Annotated[Scalar, signed("size of the phase of the orbit error", "rad")] = 0.0
    field_error: Annotated[Scalar, size("star tracker field error", "rad")] = 0.0
    field_length: Annotated[Scalar, positive("length of the field error", "rad")] = FIELD_LENGTH

    def check_own(self) -> None:
        """Validate that the orbit holds the Moon where its exclusion angle needs it.

        Raises:
            InputError: It does not.
        """
        if not self.orbit.has_moon and np.any(np.asarray(self.moon_exclusion) > 0.0):
            raise InputError(
                f"moon exclusion angle: found {float(self.moon_exclusion):g} rad and an orbit "
                "without the Moon, expected `orbit_environment(..., moon=True)`"
            )

    def sees(self, motion: BodyMotion, time: Scalar) -> Bool[Array, ""]:
        """Whether the head is not blind; arguments as of `blinding`."""
        blinding = self.blinding(motion, time)
        return ~(blinding.sun | blinding.earth | blinding.moon | blinding.rate)

    def blinding(self, motion: BodyMotion, time: Scalar) -> Blinding:
        """What blinds the head.

        Args:
            motion: Attitude and rate of the body.
            time: Time, s.
        """
        angles = self.sun_exclusion, self.earth_exclusion, self.moon_exclusion
        near = KeepOut(self.orbit, self.boresight, *angles)(motion.attitude, time)
        return Blinding(*near, motion.rate @ motion.rate > self.rate_limit**2)

    def field_after(self, before: Vector3, turned: Scalar, key: PRNGKeyArray) -> Float[Array, "3"]:
        """Field of view error after a rotation, as a share of its standard deviations, (3,).

        A Gauss-Markov process over the angle that the body has turned.

        Args:
            before: Value before, (3,).
            turned: Angle of the rotation, rad; infinite: a new draw.
            key: Random key.
        """
        kept = jnp.exp(-turned / self.field_length)
        return kept * before + jnp.sqrt(1.0 - kept**2) * jax.random.normal(key, (3,))

    def error(
        self, motion: BodyMotion, time: Scalar, field: Vector3, key: PRNGKeyArray
    ) -> tuple[Vector3, Float[Array, "3 3"]]:
        """Error of a sample, a rotation vector in body axes, (3,), rad, and its information matrix.

        The information matrix, (3, 3), 1/rad², is the inverse of the covariance of the noise at
        rest.

        Args:
            motion: Attitude and rate of the body.
            time: Time, s.
            field: Field of view error as a share of its standard deviations, (3,).
            key: Random key of the noise.
        """
        axis = jnp.asarray(self.boresight)
        axis = axis / jnp.sqrt(axis @ axis)

        def scaled(draws: Vector3, across: Scalar, about: Scalar) -> Vector3:
            along = axis * (axis @ draws)
            return across * (draws - along) + about * along

        ratio = self.about / self.across
        noise = scaled(jax.random.normal(key, (3,)), self.across, self.about)
        # the variance is four times as large at the doubling rate
        growth = jnp.sqrt(1.0 + 3.0 * (motion.rate @ motion.rate) / self.doubling_rate**2)
        phase = 2.0 * jnp.pi * time / self.orbit.period + self.orbit_phase
        slow = jnp.asarray(self.orbit_error) * jnp.sin(phase)
        slow = slow + scaled(field, self.field_error, ratio * self.field_error)
        plane = jnp.eye(3) - jnp.outer(axis, axis)
        information = plane / self.across**2 + jnp.outer(axis, axis) / self.about**2
        constant = self.misalignment - self.delay * motion.rate
        return constant + slow + growth * noise, information


class StarTrackerHeads(Checked):
    """Star tracker whose attitude is the weighted mean of the heads that are not blind.

    The errors of the heads are weighted by their information matrices (least squares). Two heads
    with different boresights thus remove most of the noise about each of them. Without a head that
    sees, there is no sample.

    Attributes:
        heads: Heads, one or more.
        periods: Control periods from one sample to the next, a whole number; the first sample is
            at time 0.
    """

    heads: tuple[StarTrackerHead, ...]
    periods: Annotated[Scalar, whole_periods] = 1

    def start(self) -> Float[Array, "heads 3"]:
        """Memory before the first sample: field of view errors."""
        return jnp.zeros((len(self.heads), 3))

    def __call__(
        self,
        motion: BodyMotion,
        memory: Float[Array, "heads 3"],
        samples: Scalar,
        period: Scalar,
        key: PRNGKeyArray,
    ) -> tuple[Quaternion, Bool[Array, " heads"], Float[Array, "heads 3"]]:
        """Measure the attitude.

        Args:
            motion: True attitude and rate.
            memory: Memory from the last control period.
            samples: Control periods since the start.
            period: Control period, s.
            key: Random key of the noise.

        Returns:
            The measured attitude, (4,), whether each head has a sample at this time, (heads,), and
            the memory.
        """
        due = jnp.mod(samples, self.periods) == 0.0
        sees = jnp.stack([due & head.sees(motion, samples * period) for head in self.heads])
        total, weighted, fields = jnp.zeros((3, 3)), jnp.zeros(3), []
        turned = period * jnp.sqrt(motion.rate @ motion.rate)
        turned = jnp.where(samples == 0.0, jnp.inf, turned)
        for number, head in enumerate(self.heads):
            head_key = jax.random.fold_in(key, number)
            field_key = jax.random.fold_in(head_key, _FIELD_KEY)
            fields.append(head.field_after(memory[number], turned, field_key))
            error, information = head.error(motion, samples * period, fields[-1], head_key)
            total += sees[number] * information
            weighted += sees[number] * (information @ error)
        # without a head, any definite matrix
        total += jnp.where(jnp.any(sees), 0.0, 1.0) * jnp.eye(3)
        mean = inverse_definite(total) @ weighted
        attitude = product(motion.attitude, from_rotation_vector(mean))
        return attitude, sees, jnp.stack(fields)
