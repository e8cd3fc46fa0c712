"""Targets for `Pointing`: sky, limb of the Earth, strip on the ground, another spacecraft.

Each is a callable (orbit, time) -> two directions, as `gyrostat.control.guidance.Aim` says: to the
target, and the velocity. `SecondAxis` replaces the velocity.
"""

from typing import Annotated

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.guidance.pointing import Aim, GroundTarget, as_tree, axes_of
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, signed
from gyrostat.core.jax64 import jnp
from gyrostat.core.limiting import within
from gyrostat.core.rotations import direction_at, to_inertial
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS
from gyrostat.spacecraft.orbit.orbit_environment import FLATTENING, OrbitEnvironment, interpolated

VELOCITY, SUN, NORMAL = 0, 1, 2
"""Choices of `SecondAxis`."""


class SecondAxis(Checked):
    """Directions of another aim, with a chosen second direction.

    Attributes:
        aim: Target; its second direction is that of the velocity.
        choice: `VELOCITY`, `SUN` or `NORMAL`, the orbit normal.
    """

    aim: Aim = eqx.field(converter=as_tree)
    choice: Scalar = VELOCITY

    def __call__(self, orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
        """Directions at a time, s."""
        first, velocity = self.aim(orbit, time)
        position = orbit.position(time)
        normal = jnp.cross(position, orbit.velocity(time))
        second = jnp.where(self.choice == NORMAL, normal, velocity)
        return first, jnp.where(self.choice == SUN, orbit.sun(time) - position, second)


class Celestial(Checked):
    """Direction that is fixed in the GCRS.

    Aberration, up to 26 arcseconds in a low orbit, is left out, as for the Sun.

    Attributes:
        right_ascension: Right ascension (ICRS), rad.
        declination: Declination (ICRS), rad.
    """

    right_ascension: Annotated[Scalar, signed("right ascension", "rad")]
    declination: Annotated[Scalar, signed("declination", "rad")]

    def __call__(self, orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
        """Directions at a time, s."""
        return direction_at(self.right_ascension, self.declination), orbit.velocity(time)


class Limb(Checked):
    """Direction that grazes the Earth at a height above its limb.

    The line of sight is a tangent of the ellipsoid whose half axes are those of WGS 84 and the
    height. It differs from the surface at this geodetic height by at most 1.4e-6 of the height.

    Attributes:
        height: Height of the tangent point above the ellipsoid, m; below that of the spacecraft.
        azimuth: Direction of the tangent point, from the part of the velocity across the zenith
            about the zenith, rad; positive to the left, toward the orbit normal.
    """

    height: Annotated[Scalar, signed("tangent height", "m")]
    azimuth: Annotated[Scalar, signed("azimuth of the limb", "rad")] = 0.0

    def __call__(self, orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
        """Directions at a time, s."""
        position, velocity = orbit.position(time), orbit.velocity(time)
        _, ahead, normal = axes_of(position, velocity)
        level = jnp.cos(self.azimuth) * ahead + jnp.sin(self.azimuth) * normal
        # scaled along the axis of the Earth, the ellipsoid is the unit sphere
        pole = to_inertial(orbit.earth(time), jnp.array([0.0, 0.0, 1.0]))
        equatorial = EARTH_RADIUS + self.height
        stretch = equatorial / (EARTH_RADIUS * (1.0 - FLATTENING) + self.height)

        def scaled(vector: Vector3, factor: Scalar) -> Vector3:
            return vector + (factor - 1.0) * (vector @ pole) * pole

        place, toward = scaled(position, stretch) / equatorial, scaled(level, stretch)
        squared = place @ place
        toward = toward - (toward @ place) / squared * place
        toward = toward / jnp.sqrt(toward @ toward)
        tangent = place / squared + jnp.sqrt(1.0 - 1.0 / squared) * toward
        return equatorial * scaled(tangent - place, 1.0 / stretch), velocity


class GroundStrip(Checked):
    """Directions to a point that moves along the ground, for a push-broom camera.

    Latitude and longitude change in proportion to time between both ends, the longitude the shorter
    way; before and after, the point rests at them.

    Attributes:
        first: Target at the begin.
        last: Target at the end.
        begin: Time at which the point starts, s.
        duration: Time that it takes, s.
    """

    first: GroundTarget
    last: GroundTarget
    begin: Annotated[Scalar, signed("begin of the strip", "s")]
    duration: Annotated[Scalar, positive("duration of the strip", "s")]

    def __call__(self, orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
        """Directions at a time, s."""
        share = within((time - self.begin) / self.duration, 0.0, 1.0)
        first, last = self.first, self.last
        east = last.longitude - first.longitude
        east = east - 2.0 * jnp.pi * jnp.round(east / (2.0 * jnp.pi))
        here = GroundTarget(
            first.latitude + share * (last.latitude - first.latitude),
            first.longitude + share * east,
            first.altitude + share * (last.altitude - first.altitude),
        )
        return here(orbit, time)


class OtherSpacecraft(Checked):
    """Directions to another spacecraft.

    Attributes:
        positions: Its position, GCRS, m, over time after the epoch of the orbit tables
            (`gyrostat.spacecraft.orbit.orbit_environment.spline_of`), (rows, 2, 3).
        step: Time between rows, s.
    """

    positions: Float[Array, "rows 2 channels"]
    step: Annotated[Scalar, positive("step of the positions", "s")]

    def __call__(self, orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
        """Directions at a time, s."""
        share = (orbit.offset + time) / self.step
        there = interpolated(jnp.asarray(self.positions), share, 0, 3)
        return there - orbit.position(time), orbit.velocity(time)
