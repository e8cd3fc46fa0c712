"""Cones about directions in space that boresights stay out of, and a bound along a path."""

from typing import NamedTuple, Self

import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.control.guidance.bowed_path import BowedPath, PathSamples
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

TINY = 1e-300
"""Smallest divisor: a path that stays where it is has no bulge."""


class KeepOutCones(NamedTuple):
    """Angles that boresights keep from directions fixed in space.

    Attributes:
        boresights: Boresights in body axes, of unit length, (cones, 3).
        directions: Directions in inertial axes, of unit length, (cones, 3).
        angles: Smallest angles, (cones,), rad; 0 or less: no cone.
    """

    boresights: Float[Array, "cones 3"]
    directions: Float[Array, "cones 3"]
    angles: Float[Array, " cones"]

    @classmethod
    def of(cls, *cones: tuple[ArrayLike, ArrayLike, float]) -> Self:
        """Create the cones.

        Args:
            cones: Boresight in body axes and direction in inertial axes, each (3,), of any length,
                and the angle, rad, from 0 to pi.

        Raises:
            InputError: There is none, a vector has no direction, or an angle is out of range.
        """
        if not cones:
            raise InputError("keep-out cones: found none, expected one or more")
        vectors = np.array([[first, second] for first, second, _ in cones], dtype=float)
        angles = np.array([angle for *_, angle in cones], dtype=float)
        lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
        if not np.all(np.isfinite(lengths) & (lengths > 0.0)):
            raise InputError(
                f"keep-out cones: found the vectors {vectors.tolist()}, expected vectors with a "
                "direction"
            )
        if not np.all((angles >= 0.0) & (angles < np.pi)):
            raise InputError(
                f"keep-out cones: found the angles {angles.tolist()} rad, expected 0 to pi"
            )
        boresights, directions = np.moveaxis(vectors / lengths, 1, 0)
        return cls(jnp.asarray(boresights), jnp.asarray(directions), jnp.asarray(angles))

    def clearance(self, attitude: Quaternion) -> Float[Array, " cones"]:
        """Angle of each boresight from the edge of its cone, negative inside, (cones,), rad."""
        pointed = jax.vmap(lambda axis: rotations.to_inertial(attitude, axis))(self.boresights)
        return jax.vmap(rotations.angle_between)(pointed, self.directions) - self.angles

    def excess(self, path: BowedPath, samples: PathSamples) -> Scalar:
        """Upper bound of the cosine to a direction less that of its angle, for the whole path.

        With R(s) = exp [v(s)], |R''| <= |v''| + |v'|² (Duhamel's formula; exp of a skew matrix is
        orthogonal). Between two samples, a cosine is therefore nowhere larger than the straight
        line between both values plus K t (1 - t) h² / 2, with K that bound, the distance h of the
        samples and the share t between them. A path is outside of all cones if the result is not
        positive, at the samples and between them.

        Args:
            path: Path.
            samples: The path sampled.
        """
        step = 1.0 / (len(samples.vector) - 1)
        bend = jnp.sqrt(jnp.sum(samples.second**2, axis=-1))
        bend = jnp.maximum(bend[1:], bend[:-1])  # v'' is linear, so that its norm is convex
        speed = jnp.sqrt(jnp.sum(samples.first**2, axis=-1))
        speed = jnp.maximum(speed[1:], speed[:-1]) + 0.5 * step * bend
        bulge = 0.5 * (bend + speed**2) * step**2

        def largest(boresight: Array, direction: Array, angle: Scalar) -> Scalar:
            cosine = samples.to_body(rotations.to_body(path.middle, direction)) @ boresight
            rise = cosine[1:] - cosine[:-1]
            share = jnp.clip(0.5 + 0.5 * rise / jnp.maximum(bulge, TINY), 0.0, 1.0)
            bound = jnp.max(cosine[:-1] + rise * share + bulge * share * (1.0 - share))
            return jnp.where(angle > 0.0, bound - jnp.cos(angle), -1.0)

        return jnp.max(jax.vmap(largest)(*self))
