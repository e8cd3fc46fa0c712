"""Smear: largest rotation of a direction within an exposure time, with constant memory."""

from typing import NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp

EXPOSURES = 16
"""Number of overlapping exposures that are evaluated at a time."""


class Exposures(NamedTuple):
    """Overlapping exposures, the latest first.

    An exposure starts at every sample, or about every sixteenth of the exposure time if that is
    longer. Starts s apart give the largest angle of an oscillation with period P within an exposure
    of at least P / 2 times (1 + cos(pi s / P)) / 2 or more: 0.997 for P of twice the exposure time.

    Attributes:
        held: Number of exposures that started in this interval.
        since: Number of samples since the latest one started.
        first: Direction at the start of each, (exposures, 3).
        chord: Largest squared distance of a later direction from it, (exposures,).
    """

    held: Scalar
    since: Scalar
    first: Float[Array, "exposures 3"]
    chord: Float[Array, " exposures"]


def no_exposures() -> Exposures:
    """Exposures before the first sample."""
    zero = jnp.zeros(())
    return Exposures(zero, zero, jnp.zeros((EXPOSURES, 3)), jnp.zeros(EXPOSURES))


def exposed(
    seen: Exposures, direction: Vector3, inside: Bool[Array, ""], periods: Scalar
) -> tuple[Exposures, Scalar]:
    """Process one sample.

    Args:
        seen: Exposures after the last sample.
        direction: Unit vector.
        inside: Whether the sample is in the window; outside, no exposure is evaluated.
        periods: Exposure time in control periods, a whole number.

    Returns:
        The exposures after this sample, and the largest angle within the exposure that ends with
        this sample, rad; -inf if none ends.
    """
    stride = jnp.ceil(periods / EXPOSURES)
    held, since = jnp.where(inside, seen.held, 0.0), seen.since + 1.0
    difference = seen.first - direction
    chord = jnp.maximum(seen.chord, jnp.sum(difference**2, axis=1))
    number = jnp.arange(EXPOSURES)
    ends = (since + stride * number == periods) & (number < held)
    largest = jnp.max(jnp.where(ends, chord, -jnp.inf))
    # the angle is computed of a valid chord also where no exposure ends
    half = 0.5 * jnp.sqrt(jnp.clip(largest, 0.0, 4.0))
    angle = jnp.where(largest >= 0.0, 2.0 * jnp.arcsin(half), -jnp.inf)
    starts = inside & ((held == 0.0) | (since == stride))
    after = Exposures(
        jnp.where(starts, held + 1.0, held),
        jnp.where(starts, 0.0, since),
        jnp.where(starts, jnp.concatenate([direction[None], seen.first[:-1]]), seen.first),
        jnp.where(starts, jnp.concatenate([jnp.zeros(1), chord[:-1]]), chord),
    )
    return after, angle
