"""Random keys of JAX, and their words of 64 bits, as `threefry` takes them."""

from typing import Any

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.threefry import Words


def is_random_key(value: Any) -> bool:
    """Whether a value is a key of jax.random with the type of keys."""
    dtype = getattr(value, "dtype", None)
    return dtype is not None and jnp.issubdtype(dtype, jax.dtypes.prng_key)


def words_of(keys: Any) -> Words:
    """Words of random keys of Threefry, with the shape of the keys."""
    pair = np.asarray(jax.random.key_data(keys)).astype(np.uint64)
    return (pair[..., 0] << np.uint64(32)) | pair[..., 1]


def random_keys(words: Words) -> Any:
    """Random keys of words; the inverse of `words_of`."""
    pair = np.stack([words >> np.uint64(32), words], axis=-1).astype(np.uint32)
    return jax.random.wrap_key_data(jnp.asarray(pair))
