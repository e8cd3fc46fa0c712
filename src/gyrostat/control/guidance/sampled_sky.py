"""Target of a turn and the bodies about it, sampled once when the turn starts."""

from collections.abc import Callable
from typing import Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.guidance.bodies import NO_BODY, Bodies, Sky
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft.sensors.keep_out import Sight

STEPS = 128
"""Steps between the samples."""


class _Row(NamedTuple):
    """Sample.

    Attributes:
        target: Attitude of the target, (4,).
        directions: Unit vectors to the bodies in axes of the target, (bodies, 3).
        radii: Angles from their centres to the part that counts, rad, (bodies,).
        visible: 1 if they are visible, otherwise 0, (bodies,).
    """

    target: Quaternion
    directions: Float[Array, "bodies 3"]
    radii: Float[Array, " bodies"]
    visible: Float[Array, " bodies"]

    @classmethod
    def of(cls, row: Array) -> Self:
        """Parts of a row of the table."""
        bodies = (len(row) - 4) // 5
        towards = row[4 : 4 + 3 * bodies].reshape(bodies, 3)
        rest = row[4 + 3 * bodies :]
        return cls(row[:4], towards, rest[:bodies], rest[bodies:])


class SampledSky(NamedTuple):
    """Target and bodies at evenly spaced times; between them by linear interpolation.

    The orbit and the attitude of the target are thus evaluated in one place of a program, however
    many ways are compared.

    Attributes:
        start: Time of the first sample, s.
        step: Time between samples, s.
        samples: Rows of `_Row`, (STEPS + 1, 4 + 5 bodies).
        bend: Angle by which a direction may be off its interpolation, rad.
    """

    start: Scalar
    step: Scalar
    samples: Float[Array, "samples columns"]
    bend: Scalar

    @classmethod
    def of(
        cls,
        attitude: Callable[[Scalar], Quaternion],
        sights: Callable[[Scalar], tuple[Sight, ...]],
        start: Scalar,
        span: Scalar,
    ) -> Self:
        """Sample.

        Args:
            attitude: Attitude of the target over time.
            sights: Bodies over time.
            start: First time, s.
            span: Time from the first to the last sample, s.
        """
        step = span / STEPS

        def sample(number: Any, table: Array) -> Array:
            time = start + number * step
            target, seen = attitude(time), sights(time)
            towards = [rotations.to_body(target, each.direction) for each in seen]
            units = [*map(rotations.normalised, towards)]
            radii = jnp.stack([jnp.asarray(each.radius) for each in seen])
            visible = jnp.stack([jnp.where(each.is_visible, 1.0, 0.0) for each in seen])
            return table.at[number].set(jnp.concatenate([target, *units, radii, visible]))

        def bent(number: Any, most: Scalar) -> Scalar:
            one, two, three = (_Row.of(table[number + k]).directions for k in range(3))
            return jnp.maximum(most, jnp.max(jnp.sum((one - 2.0 * two + three) ** 2, axis=1)))

        bodies = len(jax.eval_shape(sights, start))
        empty = jnp.zeros((STEPS + 1, 4 + 5 * bodies))
        table = jax.lax.fori_loop(0, STEPS + 1, sample, empty)
        most = jax.lax.fori_loop(0, STEPS - 1, bent, jnp.zeros(()))
        # An arc leaves its chord by an eighth of the second difference; twice that for an uneven
        # motion.
        return cls(start, step, table, 0.25 * jnp.sqrt(most))

    def _place(self, time: Scalar) -> tuple[Any, Scalar]:
        """Sample before a time, and the share of the step after it."""
        place = (time - self.start) / jnp.where(self.step > 0.0, self.step, 1.0)
        place = jnp.clip(place, 0.0, float(STEPS))
        number = jnp.minimum(place.astype(int), STEPS - 1)
        return number, place - number

    def attitude(self, time: Scalar) -> Quaternion:
        """Attitude of the target at a time, s."""
        number, share = self._place(time)
        before, after = (_Row.of(self.samples[number + k]).target for k in range(2))
        near = jnp.where(before @ after < 0.0, -after, after)
        return rotations.normalised(before + share * (near - before))

    def bodies(
        self,
        boresights: Float[Array, "instruments 3"],
        angles: Float[Array, "instruments bodies"],
    ) -> Bodies:
        """Bodies over time, with the cones of instruments.

        Args:
            boresights: Boresights in body axes, of unit length.
            angles: Smallest angle of each instrument to each body, rad, 0 for none.
        """

        def at(time: Scalar) -> Sky:
            number, share = self._place(time)
            before, after = (_Row.of(self.samples[number + k]) for k in range(2))
            directions = before.directions + share * (after.directions - before.directions)
            directions = jax.vmap(rotations.normalised)(directions)
            radii = jnp.maximum(before.radii, after.radii)
            visible = jnp.maximum(before.visible, after.visible) > 0.0
            return Sky(directions, jnp.where((angles > 0.0) & visible, angles + radii, NO_BODY))

        return Bodies(boresights, at)


def longest(profile_of: Callable[[Array], Scalar]) -> Scalar:
    """Time in which any way is expected to end: that of four rotations by half a turn, s.

    Args:
        profile_of: Duration of a rotation, from its rotation vector.
    """
    return 4.0 * jnp.max(jax.lax.map(profile_of, jnp.asarray(np.pi * np.eye(3))))
