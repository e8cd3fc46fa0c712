"""Angles that a boresight keeps from the Sun, from the limb of the Earth and from the Moon."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Bool

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, direction, size
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import angle_between, to_inertial
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.torques.eclipse import sunlight


class Near(NamedTuple):
    """Which bodies are too near to a boresight."""

    sun: Bool[Array, ""]
    earth: Bool[Array, ""]
    moon: Bool[Array, ""]


class KeepOut(Checked):
    """Angles that a boresight keeps. Sun and Moon behind the Earth are not too near.

    Attributes:
        orbit: Orbit; with the Moon if its angle is above 0.
        boresight: Boresight in body axes, (3,), of any length.
        sun: Smallest angle to the Sun, rad.
        earth: Smallest angle to the limb of the Earth, lit or not, rad.
        moon: Smallest angle to the centre of the Moon, in any phase, rad.
    """

    orbit: OrbitEnvironment
    boresight: Annotated[Vector3, direction("boresight")]
    sun: Annotated[Scalar, size("angle to the Sun", "rad")] = 0.0
    earth: Annotated[Scalar, size("angle to the limb of the Earth", "rad")] = 0.0
    moon: Annotated[Scalar, size("angle to the Moon", "rad")] = 0.0

    def __call__(self, attitude: Quaternion, time: Scalar) -> Near:
        """Which bodies are too near.

        Args:
            attitude: Attitude of the body, (4,), scalar first.
            time: Time, s.
        """
        position, sun = self.orbit.position(time), self.orbit.sun(time)
        boresight = to_inertial(attitude, jnp.asarray(self.boresight))
        dark = sunlight(position, sun) <= 0.0
        from_sun = angle_between(boresight, sun - position)
        earth = jnp.arcsin(EARTH_RADIUS / jnp.sqrt(position @ position))
        from_limb = angle_between(boresight, -position) - earth
        near_moon = jnp.array(False)
        if self.orbit.has_moon:
            moon = self.orbit.moon(time) - position
            near_moon = angle_between(boresight, moon) < self.moon
            near_moon &= angle_between(moon, -position) > earth
        near_sun = jnp.logical_not(dark) & (from_sun < self.sun)
        return Near(near_sun, from_limb < self.earth, near_moon)

    def violated(self, attitude: Quaternion, time: Scalar) -> Near:
        """Which bodies are nearer than an angle above 0: those with 0 may be in view.

        Args:
            attitude: Attitude of the body, (4,), scalar first.
            time: Time, s.
        """
        near = self(attitude, time)
        angles = self.sun, self.earth, self.moon
        return Near(*(is_near & (angle > 0.0) for is_near, angle in zip(near, angles, strict=True)))
