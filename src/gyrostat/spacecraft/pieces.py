"""Division of an interval at the times at which something changes."""

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


def pieces(
    times: Float[Array, " changes"], time: Scalar, duration: Scalar
) -> tuple[Float[Array, " pieces"], Float[Array, " pieces"]]:
    """Divide an interval at given times; times outside it give pieces of no length.

    Args:
        times: Times of the changes, (changes,), s.
        time: Start of the interval, s.
        duration: Its length, s.

    Returns:
        Start of each piece after that of the interval, and its length, (changes + 1,), s.
    """
    cuts = jnp.sort(jnp.clip(times - time, 0.0, duration))
    starts = jnp.concatenate([jnp.zeros(1), cuts])
    return starts, jnp.diff(starts, append=jnp.asarray(duration, dtype=float)[None])
