"""JAX with float64 enabled."""

import jax
import jax.numpy as jnp
from jax.core import Tracer
from jax.flatten_util import ravel_pytree
from jax.interpreters.partial_eval import dce_jaxpr

from gyrostat.core.jax_cache import use_private_cache

jax.config.update("jax_enable_x64", True)
use_private_cache(jax)

__all__ = ["Tracer", "dce_jaxpr", "jax", "jnp", "ravel_pytree"]
