"""JAX as the whole package imports it, so that float64 is on before any array exists."""

import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)

__all__ = ["jax", "jnp"]
