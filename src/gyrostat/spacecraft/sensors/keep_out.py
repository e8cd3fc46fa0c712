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


BODIES = {"sun": "the Sun", "earth": "the Earth", "moon": "the Moon"}
"""Field of `Near` -> name of the body in a sentence."""


class Sight(NamedTuple):
    """Body as the spacecraft sees it.

    Attributes:
        direction: Direction to its centre, GCRS, (3,), of any length.
        radius: Angle from its centre to the part that counts, rad.
        is_visible: Whether it is not behind the Earth.
    """

    direction: Vector3
    radius: Scalar
    is_visible: Bool[Array, ""]


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
        boresight = to_inertial(attitude, jnp.asarray(self.boresight))
        near = []
        for sight, angle in zip(self.sights(time), self.angles, strict=True):
            distance = angle_between(boresight, sight.direction) - sight.radius
            near.append(sight.is_visible & (distance < angle))
        return Near(*near)

    @property
    def angles(self) -> tuple[Scalar, Scalar, Scalar]:
        """Smallest angles to Sun, Earth and Moon, rad."""
        return self.sun, self.earth, self.moon

    def sights(self, time: Scalar) -> tuple[Sight, Sight, Sight]:
        """Sun, Earth and Moon at a time, s; without tables of the Moon, it is not visible."""
        position, sun = self.orbit.position(time), self.orbit.sun(time)
        lit = jnp.asarray(sunlight(position, sun) > 0.0)
        earth = jnp.arcsin(EARTH_RADIUS / jnp.sqrt(position @ position))
        moon, is_up = -position, jnp.array(False)
        if self.orbit.has_moon:
            moon = self.orbit.moon(time) - position
            is_up = angle_between(moon, -position) > earth
        none = jnp.zeros(())
        ground = Sight(-position, earth, jnp.array(True))
        return Sight(sun - position, none, lit), ground, Sight(moon, none, is_up)

    def violated(self, attitude: Quaternion, time: Scalar) -> Near:
        """Which bodies are nearer than an angle above 0: those with 0 may be in view.

        Args:
            attitude: Attitude of the body, (4,), scalar first.
            time: Time, s.
        """
        near = self(attitude, time)
        pairs = zip(near, self.angles, strict=True)
        return Near(*(is_near & (angle > 0.0) for is_near, angle in pairs))
