"""Attitude profiles along an orbit: a body axis points at the Earth, the Sun or a ground target."""

from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, Self

import equinox as eqx
import numpy as np
from numpy.typing import ArrayLike

from gyrostat.control.guidance.attitude_reference import (
    AttitudeReference,
    Motion,
    with_derivatives,
)
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, signed
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.traced_once import one_function
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment

PARALLEL = 1e-6
"""Sine of the angle between two directions below which they count as parallel."""
Aim = Callable[[OrbitEnvironment, Scalar], tuple[Vector3, Vector3]]
"""Two directions in the GCRS at a time, of any length: where to point, and the second direction."""


def to_earth(orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
    """Direction to the centre of the Earth, and direction of the velocity."""
    return -orbit.position(time), orbit.velocity(time)


def to_sun(orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
    """Direction to the Sun, and direction of the orbit normal."""
    position = orbit.position(time)
    return orbit.sun(time) - position, jnp.cross(position, orbit.velocity(time))


class GroundTarget(Checked):
    """Directions to a point that turns with the Earth and of the velocity.

    Attributes:
        latitude: Geodetic latitude (WGS 84), rad.
        longitude: Longitude, to the east, rad.
        altitude: Height above the ellipsoid, m.
    """

    latitude: Annotated[Scalar, signed("latitude of the ground target", "rad")]
    longitude: Annotated[Scalar, signed("longitude of the ground target", "rad")]
    altitude: Annotated[Scalar, signed("altitude of the ground target", "m")] = 0.0

    def __call__(self, orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
        """Directions at a time, s."""
        target = orbit.ground(self.latitude, self.longitude, self.altitude, time)
        return target - orbit.position(time), orbit.velocity(time)


def as_tree(aim: Any) -> Any:
    """Aim as a tree of numbers, which a function is not.

    Args:
        aim: Function or callable tree.
    """
    return aim if isinstance(aim, eqx.Module) else jax.tree_util.Partial(aim)


class Pointing(Checked):
    """Attitude that points one body axis, and turns another one as near as possible to a direction.

    Two directions determine the attitude (the TRIAD method without noise; F. L. Markley and J. L.
    Crassidis, "Fundamentals of Spacecraft Attitude Determination and Control", section 5.1).

    Attributes:
        orbit: Orbit.
        aim: The two directions over time.
        body: Attitude of the body relative to the frame of these directions, a quaternion, (4,).
    """

    orbit: OrbitEnvironment
    aim: Aim = eqx.field(converter=as_tree)
    body: Quaternion

    @classmethod
    def of(cls, orbit: OrbitEnvironment, aim: Aim, axis: ArrayLike, second: ArrayLike) -> Self:
        """Create the profile from two body axes.

        Args:
            orbit: Orbit.
            aim: The two directions over time.
            axis: Body axis that points along the first direction, (3,), of any length.
            second: Body axis whose part across `axis` points along the second direction, (3,). If
                both axes are parallel, `check` refuses the profile.
        """
        first, secondary = (jnp.asarray(axis, dtype=float) for axis in (axis, second))
        return cls(orbit, aim, frame_of_axes(first, secondary))

    def check_own(self) -> None:
        """Validate the body axes.

        Raises:
            InputError: They are parallel.
        """
        check_axes(self.body)

    def __call__(self, time: Scalar) -> Quaternion:
        """Attitude at a time, s."""
        return _pointed(*self.aim(self.orbit, time), jnp.asarray(self.body))

    def reference_of_aim(self, time: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration at a time, s."""
        if type(self).__call__ is not Pointing.__call__:
            return Motion.of(self, time).reference
        directions = with_derivatives(partial(self.aim, self.orbit), time)
        return _reference(directions, jnp.asarray(self.body))


def _pointed(first: Vector3, second: Vector3, body: Quaternion) -> Quaternion:
    return rotations.product(rotations.conjugate(frame_of_axes(first, second)), body)


@one_function
def _reference(directions: Any, body: Quaternion) -> AttitudeReference:
    """Motion that two directions with their derivatives determine: one function for all modes."""
    return Motion.along(partial(_pointed, body=body), directions).reference


def frame_of_axes(first: Vector3, second: Vector3) -> Quaternion:
    """Attitude of the frame of `axes_of` two axes, which are the rows of its rotation matrix."""
    return rotations.from_matrix(jnp.stack(axes_of(first, second)))


def axes_of(first: Vector3, second: Vector3) -> tuple[Vector3, Vector3, Vector3]:
    """Unit vectors: a first axis, the part of a second one across it, and their cross product.

    Args:
        first: Axis of any length, (3,).
        second: Axis of any length, (3,). If both are parallel, the last two are NaN.
    """
    first = first / jnp.sqrt(first @ first)
    second = second / jnp.sqrt(second @ second)
    second = second - (second @ first) * first
    length = jnp.sqrt(second @ second)
    second = jnp.where(length > PARALLEL, second / length, jnp.nan)
    return first, second, jnp.cross(first, second)


def check_axes(body: Quaternion) -> None:
    """Check that two body axes were not parallel.

    Args:
        body: Result of `frame_of_axes`.

    Raises:
        InputError: They were.
    """
    if not np.all(np.isfinite(body)):
        raise InputError(
            "pointing: found parallel body axes, expected axes with different directions"
        )
