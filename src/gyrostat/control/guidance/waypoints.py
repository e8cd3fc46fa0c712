"""Fixed set of waypoints of a turn, some of them relative to its ends and to the bodies."""

from typing import Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.guidance.bodies import Bodies
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp

TWISTS = 4
"""Waypoints for each direction of a boresight that points away from a body."""
SIDES, SIZES = 8, np.array([0.3, 0.6, 1.0, 1.5])
"""Waypoints beside the middle of the eigenaxis turn: number of sides, angles, rad."""
SPREAD = 64
"""Waypoints that are spread evenly over all attitudes."""
TINY = 1e-9
"""Smallest sine of the angle between directions that have a normal."""


class Waypoints(NamedTuple):
    """Attitudes relative to the target by which a way may lead; the first one is the start.

    Attributes:
        start: Attitude at the start, (4,).
        middle: That halfway about the eigenaxis, (4,).
        sides: Vectors beside it, across the eigenaxis, (SIZES * SIDES, 3), rad.
        boresights: Boresights in body axes, (instruments, 3).
        directions: Directions to the bodies, (bodies, 3).
    """

    start: Quaternion
    middle: Quaternion
    sides: Float[Array, "sides 3"]
    boresights: Float[Array, "instruments 3"]
    directions: Float[Array, "bodies 3"]

    @classmethod
    def of(cls, start: Quaternion, bodies: Bodies, time: Scalar) -> Self:
        """Waypoints of a turn.

        Args:
            start: Attitude at the start, (4,).
            bodies: Cones.
            time: Time of the start, s.
        """
        turn = rotations.rotation_vector(start)
        angle = jnp.sqrt(turn @ turn)
        axis = jnp.where(angle > TINY, turn / jnp.maximum(angle, TINY), jnp.eye(3)[0])
        first = across_to(axis)
        second = jnp.cross(axis, first)
        angles = 2.0 * np.pi * np.tile(np.arange(SIDES), len(SIZES)) / SIDES
        sizes = np.repeat(SIZES, SIDES)
        sides = jnp.asarray(sizes * np.cos(angles))[:, None] * first
        sides = sides + jnp.asarray(sizes * np.sin(angles))[:, None] * second
        middle = rotations.from_rotation_vector(0.5 * turn)
        return cls(start, middle, sides, bodies.boresights, bodies.at(time).directions)

    @property
    def number(self) -> int:
        """Number of waypoints."""
        away = TWISTS * len(self.boresights) * len(self.directions)
        return 1 + len(self.sides) + away + SPREAD

    def __call__(self, row: Any) -> Quaternion:
        """Attitude of a waypoint, (4,).

        Args:
            row: Its number, from 0.
        """
        beside = row - 1
        away = beside - len(self.sides)
        spread = away - TWISTS * len(self.boresights) * len(self.directions)
        kind = jnp.where(row == 0, 0, jnp.where(away < 0, 1, jnp.where(spread < 0, 2, 3)))
        return jax.lax.switch(
            kind,
            [
                lambda: self.start,
                lambda: rotations.product(
                    self.middle, rotations.from_rotation_vector(self.sides[jnp.maximum(beside, 0)])
                ),
                lambda: self._away(jnp.maximum(away, 0)),
                lambda: jnp.asarray(_spread(SPREAD))[jnp.maximum(spread, 0)],
            ],
        )

    def _away(self, number: Any) -> Quaternion:
        """Attitude in which a boresight points away from a body, turned about it."""
        pair, twist = number // TWISTS, number % TWISTS
        boresight = self.boresights[pair // len(self.directions)]
        opposite = -self.directions[pair % len(self.directions)]
        normal, cosine = jnp.cross(boresight, opposite), boresight @ opposite
        size = jnp.sqrt(normal @ normal)
        # opposite to each other, any axis across will do
        axis = jnp.where(size > TINY, normal / jnp.maximum(size, TINY), across_to(boresight))
        swung = rotations.from_rotation_vector(jnp.arctan2(size, cosine) * axis)
        turned = (2.0 * np.pi / TWISTS) * twist * boresight
        return rotations.product(swung, rotations.from_rotation_vector(turned))


def across_to(axis: Vector3) -> Vector3:
    """Unit vector across a unit vector."""
    normal = jnp.cross(axis, jnp.eye(3)[jnp.argmin(jnp.abs(axis))])
    return normal / jnp.sqrt(normal @ normal)


def _spread(count: int) -> Float[np.ndarray, "count 4"]:
    """Attitudes that are spread evenly: spirals of M. Alexa, "Super-Fibonacci spirals" (2022)."""
    first, second = np.sqrt(2.0), 1.533751168755204288118041
    place = np.arange(count) + 0.5
    inner, outer = np.sqrt(place / count), np.sqrt(1.0 - place / count)
    one, other = 2.0 * np.pi * place / first, 2.0 * np.pi * place / second
    parts = inner * np.sin(one), inner * np.cos(one), outer * np.sin(other), outer * np.cos(other)
    return np.stack(parts, axis=1)
