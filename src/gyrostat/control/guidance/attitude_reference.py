"""Attitude, rate and acceleration of a reference, by differentiation of its attitude over time."""

from collections.abc import Callable
from typing import Any, NamedTuple, Self

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import normalised

Profile = Callable[[Scalar], Quaternion]
"""Attitude over time: (time, s) -> quaternion, scalar first, (4,). Its length and its sign are
ignored. JAX must be able to differentiate it twice."""


class AttitudeReference(NamedTuple):
    """Motion of a reference at one time.

    Attributes:
        attitude: Unit quaternion of the reference with respect to inertial space, (4,).
        rate: Angular velocity relative to inertial space, in axes of the reference, (3,), rad/s.
        acceleration: Derivative of the components of `rate`, (3,), rad/s².
    """

    attitude: Quaternion
    rate: Vector3
    acceleration: Vector3

    def turned(self, relative: "AttitudeReference") -> "AttitudeReference":
        """Motion of axes that move relative to this reference.

        Args:
            relative: Their motion in axes of this reference.
        """
        attitude = rotations.product(self.attitude, relative.attitude)
        carried = rotations.to_body(relative.attitude, self.rate)
        gained = rotations.to_body(relative.attitude, self.acceleration)
        acceleration = gained - jnp.cross(relative.rate, carried) + relative.acceleration
        return AttitudeReference(attitude, carried + relative.rate, acceleration)


class Motion(NamedTuple):
    """Unit quaternion with its first and second time derivative at one time.

    Attributes:
        attitude: Quaternion, (4,).
        slope: First derivative, (4,), 1/s.
        bend: Second derivative, (4,), 1/s².
    """

    attitude: Quaternion
    slope: Quaternion
    bend: Quaternion

    @classmethod
    def of(cls, profile: Profile, time: Scalar) -> Self:
        """Motion of the unit quaternion of a profile.

        Args:
            profile: Attitude over time.
            time: Time, s.
        """

        def attitude(time: Scalar) -> Quaternion:
            return normalised(jnp.asarray(profile(time), dtype=float))

        return cls(*with_derivatives(attitude, time))

    @classmethod
    def along(cls, attitude: Callable[..., Quaternion], path: tuple[Any, Any, Any]) -> Self:
        """Motion of an attitude that depends on moving quantities.

        Args:
            attitude: Function of these quantities; see `Profile`.
            path: The quantities with their first and second time derivatives, each a tuple.
        """
        values, slopes, bends = path

        def derivative(values: Any, slopes: Any) -> tuple[Quaternion, Quaternion]:
            return jax.jvp(lambda *x: normalised(attitude(*x)), values, slopes)

        (quaternion, slope), (_, bend) = jax.jvp(derivative, (values, slopes), (slopes, bends))
        return cls(quaternion, slope, bend)

    @property
    def reference(self) -> AttitudeReference:
        """Attitude, rate and acceleration, for a unit quaternion: q*' q' has no vector part."""
        rate, acceleration = (rate_of(self.attitude, each) for each in (self.slope, self.bend))
        return AttitudeReference(self.attitude, rate, acceleration)


def rate_of(quaternion: Quaternion, slope: Quaternion) -> Vector3:
    """Rate w = 2 vec(q* q') / |q|² in axes of the attitude, (3,), rad/s.

    A factor on q, constant or not, does not change w: it adds to the scalar part of q* q' only.

    Args:
        quaternion: Quaternion q of any length, (4,).
        slope: Its time derivative, (4,), 1/s.
    """
    vector = rotations.product(rotations.conjugate(quaternion), slope)[1:]
    return 2.0 * vector / (quaternion @ quaternion)


def with_derivatives(function: Callable[[Scalar], Any], time: Scalar) -> tuple[Any, Any, Any]:
    """Value of a function of time, and its first and second derivative, each a tree as the value.

    Args:
        function: Function of the time, s.
        time: Time, s.
    """
    time = jnp.asarray(time, dtype=float)
    dt = jnp.ones_like(time)

    def derivative(time: Scalar) -> tuple[Any, Any]:
        return jax.jvp(function, (time,), (dt,))

    (value, slope), (_, bend) = jax.jvp(derivative, (time,), (dt,))
    return value, slope, bend


def reference_at(profile: Profile, time: Scalar) -> AttitudeReference:
    """Attitude, rate and acceleration of a profile at a time.

    Args:
        profile: Attitude over time; its method `reference_of_aim`, if it has one, gives them.
        time: Time, s.
    """
    own = getattr(profile, "reference_of_aim", None)
    return Motion.of(profile, time).reference if own is None else own(time)
