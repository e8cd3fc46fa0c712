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
BEND = 0.5
"""Angle by which a direction may be off its interpolation, over the largest second difference: an
arc leaves its chord by an eighth of it, a chord across a sample by a quarter, the rest is for an
uneven motion."""
HIDDEN = -10.0
"""Angle from the centre of a body that is not visible to its part that counts, rad: no cone."""


class SampledSky(NamedTuple):
    """Target and bodies at evenly spaced times; between them by linear interpolation.

    The orbit and the attitude of the target are thus evaluated in one place of a program, however
    many ways are compared.

    Attributes:
        start: Time of the first sample, s.
        step: Time between samples, s.
        target: Attitude of the target, (STEPS + 1, 4).
        bodies: Of each body, its direction in axes of the target and the angle from its centre to
            the part that counts, rad, or `HIDDEN`, (STEPS + 1, 4).
        bend: Angle by which a direction may be off its interpolation, rad.
    """

    start: Scalar
    step: Scalar
    target: Float[Array, "samples 4"]
    bodies: tuple[Float[Array, "samples 4"], ...]
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

        def sample(number: Any, tables: tuple[Array, ...]) -> tuple[Array, ...]:
            time = start + number * step
            target = attitude(time)
            rows = [target]
            for each in sights(time):
                toward = rotations.normalised(rotations.to_body(target, each.direction))
                radius = jnp.where(each.is_visible, each.radius, HIDDEN)
                rows.append(jnp.concatenate([toward, radius[None]]))
            pairs = zip(tables, rows, strict=True)
            return tuple(table.at[number].set(row) for table, row in pairs)

        def bent(number: Any, most: Scalar) -> Scalar:
            for table in bodies:
                one, two, three = (table[number + k, :3] for k in range(3))
                difference = one - 2.0 * two + three
                most = jnp.maximum(most, difference @ difference)
            return most

        count = 1 + len(jax.eval_shape(sights, start))
        empty = tuple(jnp.zeros((STEPS + 1, 4)) for _ in range(count))
        target, *bodies = jax.lax.fori_loop(0, STEPS + 1, sample, empty)
        most = jax.lax.fori_loop(0, STEPS - 1, bent, jnp.zeros(()))
        return cls(start, step, target, tuple(bodies), BEND * jnp.sqrt(most))

    def _place(self, time: Scalar) -> tuple[Any, Scalar]:
        """Sample before a time, and the share of the step after it."""
        place = (time - self.start) / jnp.where(self.step > 0.0, self.step, 1.0)
        place = jnp.clip(place, 0.0, float(STEPS))
        number = jnp.minimum(place.astype(int), STEPS - 1)
        return number, place - number

    def attitude(self, time: Scalar) -> Quaternion:
        """Attitude of the target at a time, s."""
        number, share = self._place(time)
        before, after = self.target[number], self.target[number + 1]
        near = jnp.where(before @ after < 0.0, -after, after)
        return rotations.normalised(before + share * (near - before))

    def seen(
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
            rows = [(table[number], table[number + 1]) for table in self.bodies]
            directions = [one[:3] + share * (two[:3] - one[:3]) for one, two in rows]
            radii = jnp.stack([jnp.maximum(one[3], two[3]) for one, two in rows])
            cones = jnp.where(angles > 0.0, jnp.maximum(angles + radii, NO_BODY), NO_BODY)
            return Sky(jnp.stack([*map(rotations.normalised, directions)]), cones)

        return Bodies(boresights, at)


def longest(profile_of: Callable[[Array], Scalar]) -> Scalar:
    """Time in which any way is expected to end: that of four rotations by half a turn, s.

    Args:
        profile_of: Duration of a rotation, from its rotation vector.
    """
    return 4.0 * jnp.max(jax.lax.map(profile_of, jnp.asarray(np.pi * np.eye(3))))
