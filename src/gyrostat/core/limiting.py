"""Limits and steps of numbers in JAX."""

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


def within(value: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """Value held within limits; at a limit, its derivative is that inside.

    The derivative of `jax.numpy.clip` is half of it there.
    """
    return jnp.where(value < low, low, jnp.where(value > high, high, value))


def quantised(value: Float[Array, "..."], step: Scalar) -> Float[Array, "..."]:
    """Value rounded to whole steps; unchanged if the step is 0."""
    positive = jnp.where(step > 0.0, step, 1.0)
    return jnp.where(step > 0.0, positive * jnp.round(value / positive), value)
