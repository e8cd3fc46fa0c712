"""Reference as if it were followed exactly: no plant, no controller."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Int

from gyrostat.control.guidance import AttitudeReference, Mode, Reference
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp


class Followed(NamedTuple):
    """Measurement of a spacecraft that follows its reference."""

    attitude: Quaternion
    rate: Vector3
    wheel_speed: PerWheel


def follow(
    reference: Reference, mode: Mode, speed: PerWheel, time: Scalar
) -> tuple[Mode, AttitudeReference]:
    """Mode from a sample on, and the reference at the sample.

    Args:
        reference: Reference.
        mode: Mode before the sample.
        speed: Wheel speeds, (wheels,), rad/s.
        time: Time of the sample, s.
    """
    at = reference.at(mode, time)
    return reference.advance(mode, Followed(at.attitude, at.rate, speed), time)


def without_constants(tree: Any) -> Any:
    """Tree whose numbers of Python are arrays.

    As arguments of `equinox.filter_jit` they would be constants of the program, which is compiled
    again for each of their values, such as the length of an orbit's tables.
    """
    return jax.tree.map(lambda x: np.asarray(x) if isinstance(x, float) else x, tree)


class TakenChange(NamedTuple):
    """Change of mode that the reference takes if it is followed.

    Attributes:
        number: Number of the change, from 0.
        origin: Number of the mode before.
        to: Number of the mode after.
        start: Time, s.
        before: Motion at this time.
    """

    number: int
    origin: int
    to: int
    start: float
    before: AttitudeReference

    @property
    def pair(self) -> tuple[int, int]:
        """Numbers of both modes."""
        return self.origin, self.to


def taken_changes(
    reference: Reference, speed: PerWheel, period: float, count: int
) -> list[TakenChange]:
    """Changes of mode in the order of time.

    Args:
        reference: Reference with changes.
        speed: Wheel speeds, (wheels,), rad/s.
        period: Control period, s.
        count: Number of control periods.
    """
    arguments = without_constants((reference, speed, period, np.arange(count + 1)))
    *rows, before = _followed(*arguments)
    numbers, taken = map(np.asarray, rows)
    origins = np.concatenate([[0], numbers[:-1]])
    return [
        TakenChange(
            int(taken[k]) - 1,
            int(origins[k]),
            int(numbers[k]),
            float(k * period),
            jax.tree.map(lambda each, k=k: each[k], before),
        )
        for k in np.flatnonzero(taken)
    ]


@eqx.filter_jit
def _followed(
    reference: Reference, speed: PerWheel, period: Scalar, samples: Any
) -> tuple[Int[Array, " samples"], Int[Array, " samples"], AttitudeReference]:
    """Mode after each sample, the change that is taken there, from 1, or 0, and the motion."""

    def sample(mode: Mode, k: Any) -> tuple[Mode, tuple[Array, Array, AttitudeReference]]:
        time = k * period
        later, now = follow(reference, mode, speed, time)
        assert later.watch is not None
        is_new = (later.number != mode.number) | (later.start != mode.start)
        return later, (later.number, jnp.where(is_new, later.watch.taken, 0), now)

    return jax.lax.scan(sample, reference.start(), samples)[1]
