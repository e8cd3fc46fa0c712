"""Smooth path between two attitudes at rest, bowed away from the eigenaxis."""

from typing import NamedTuple, Self

from jaxtyping import Array, Float

from gyrostat.control.guidance.attitude_reference import AttitudeReference
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jnp

SMALL_SQUARE = 1e-2
"""Square of an angle, rad², below which coefficients of rotations are power series."""


class PathSamples(NamedTuple):
    """A path at equidistant shares of its progress, leading axis (samples,).

    Attributes:
        vector: Rotation vector from the middle attitude, (samples, 3), rad.
        first: Its first derivative, (samples, 3), rad.
        second: Its second derivative, (samples, 3), rad.
        rate: Body rate for a progress of 1/s, body axes, (samples, 3), rad/s.
        slope: Derivative of `rate` by the progress, (samples, 3), rad/s.
    """

    vector: Float[Array, "samples 3"]
    first: Float[Array, "samples 3"]
    second: Float[Array, "samples 3"]
    rate: Float[Array, "samples 3"]
    slope: Float[Array, "samples 3"]

    def to_body(self, vector: Vector3) -> Float[Array, "samples 3"]:
        """Components in body axes of a vector given in axes of the middle attitude, (3,)."""
        sine, versine, *_ = _coefficients(self.vector)
        across = jnp.cross(self.vector, vector)
        return vector - sine * across + versine * jnp.cross(self.vector, across)


class BowedPath(NamedTuple):
    """Path q(s) = q_m exp(v(s)) from attitude to attitude, with the progress s from 0 to 1.

    v(s) = (s - 1/2) p + 4 s (1 - s) b + 10 s (1 - s) (1 - 2 s) c, with the middle attitude q_m and
    the rotation vector p of the eigenaxis slew, the bow b and the second bow c, which has opposite
    signs in both halves. Without bows the path is the eigenaxis slew. All derivatives are smooth.

    Attributes:
        middle: Middle attitude of the eigenaxis slew, (4,).
        turn: Rotation vector p in body axes, (3,), rad.
        bow: Bow b, (3,), rad.
        twist: Second bow c, (3,), rad.
    """

    middle: Quaternion
    turn: Vector3
    bow: Vector3
    twist: Vector3

    @classmethod
    def eigenaxis(cls, start: Quaternion, turn: Vector3) -> Self:
        """Path without bows.

        Args:
            start: Attitude at the start, (4,).
            turn: Rotation vector in body axes, (3,), rad.
        """
        half = rotations.from_rotation_vector(0.5 * jnp.asarray(turn))
        return cls(rotations.product(start, half), turn, jnp.zeros(3), jnp.zeros(3))

    @classmethod
    def bowed(cls, start: Quaternion, turn: Vector3, bows: Float[Array, "2 3"]) -> Self:
        """Path from an attitude, with both bows."""
        return cls.eigenaxis(start, turn)._replace(bow=bows[0], twist=bows[1])

    def __call__(self, progress: Scalar) -> Quaternion:
        """Attitude at a progress from 0 to 1, (4,)."""
        vector = self.vector(progress)
        return rotations.product(self.middle, rotations.from_rotation_vector(vector))

    def vector(self, progress: Scalar) -> Vector3:
        """Rotation vector from the middle attitude at a progress, (3,), rad; see `sampled`."""
        s, rest = progress, 1.0 - progress
        second_bow = 10.0 * s * rest * (rest - s) * self.twist
        return (s - 0.5) * self.turn + 4.0 * s * rest * self.bow + second_bow

    def slopes(self, progress: Scalar) -> tuple[Vector3, Vector3]:
        """First and second derivative of `vector` by the progress, each (3,), rad."""
        s, bow, twist = progress, self.bow, self.twist
        first = 4.0 * (1.0 - 2.0 * s) * bow + 10.0 * (1.0 - 6.0 * s + 6.0 * s**2) * twist
        return self.turn + first, -8.0 * bow + 60.0 * (2.0 * s - 1.0) * twist

    def sampled(self, samples: int) -> PathSamples:
        """Path at equidistant shares of its progress.

        Args:
            samples: Number of samples, both ends included.
        """
        s = jnp.linspace(0.0, 1.0, samples)[:, None]
        vectors = self.vector(s), *self.slopes(s)
        return PathSamples(*vectors, *_rates(*vectors))

    def motion(self, progress: Scalar, speed: Scalar, change: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration, in closed form.

        Args:
            progress: Progress from 0 to 1.
            speed: Its time derivative, 1/s.
            change: Its second time derivative, 1/s².
        """
        rate, slope = _rates(self.vector(progress), *self.slopes(progress))
        acceleration = slope * speed**2 + rate * change
        return AttitudeReference(self(progress), rate * speed, acceleration)


def _coefficients(vector: Float[Array, "samples 3"]) -> tuple[Array, ...]:
    """Coefficients of a rotation by x: sin x / x, B, C, and the derivatives of B and C by x².

    B = (1 - cos x) / x² and C = (x - sin x) / x³; each (samples, 1).
    """
    square = jnp.sum(vector**2, axis=-1, keepdims=True)
    is_small = square < SMALL_SQUARE
    y, z = jnp.where(is_small, 1.0, square), jnp.where(is_small, square, 0.0)
    x = jnp.sqrt(y)
    sine, cosine = jnp.sin(x), jnp.cos(x)
    large = (
        sine / x,
        (1.0 - cosine) / y,
        (x - sine) / (x * y),
        (x * sine - 2.0 * (1.0 - cosine)) / (2.0 * y**2),
        (3.0 * sine - 2.0 * x - x * cosine) / (2.0 * x * y**2),
    )
    series = (
        1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0))),
        0.5 - z / 24.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0 * (1.0 - z / 90.0))),
        1.0 / 6.0 - z / 120.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0)),
        -1.0 / 24.0 + z / 360.0 * (1.0 - 3.0 * z / 112.0),
        -1.0 / 120.0 + z / 2520.0 * (1.0 - z / 48.0),
    )
    return tuple(jnp.where(is_small, a, b) for a, b in zip(series, large, strict=True))


def _rates(vector: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Body rate w = v' - B v x v' + C v x (v x v') and its derivative, each (samples, 3)."""
    _, b, c, b_slope, c_slope = _coefficients(vector)
    growth = 2.0 * jnp.sum(vector * first, axis=-1, keepdims=True)
    across, across_second = jnp.cross(vector, first), jnp.cross(vector, second)
    twice = jnp.cross(vector, across)
    rate = first - b * across + c * twice
    slope = second - b * across_second - b_slope * growth * across + c_slope * growth * twice
    return rate, slope + c * (jnp.cross(first, across) + jnp.cross(vector, across_second))
