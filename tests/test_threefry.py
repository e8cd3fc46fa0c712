"""Random words against JAX, to the last bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.threefry import threefry

WORDS = st.integers(0, 2**64 - 1)


def key_of(word):
    pair = np.array([word >> 32, word & 0xFFFFFFFF], np.uint32)
    return jax.random.wrap_key_data(jnp.asarray(pair))


def word_of(key):
    high, low = np.asarray(jax.random.key_data(key)).astype(np.uint64)
    return (high << np.uint64(32)) | low


@given(WORDS)
def test_the_stream_of_a_key(word):
    words = np.asarray(jax.random.bits(key_of(word), (7,), jnp.uint64))
    np.testing.assert_array_equal(threefry(np.uint64(word), np.arange(7)), words)


@given(WORDS, st.integers(0, 2**32 - 1))
def test_a_number_folded_into_a_key(word, number):
    folded = jax.random.fold_in(key_of(word), jnp.asarray(number, jnp.uint32))
    assert threefry(np.uint64(word), number) == word_of(folded)


@pytest.mark.parametrize("seed", [0, 1, 2**31, 2**32 - 1, 2**32, 2**63 - 1])
def test_the_key_of_a_seed_is_the_seed(seed):
    assert word_of(jax.random.key(seed)) == seed


def test_arguments_are_broadcast():
    found = threefry(np.arange(3, dtype=np.uint64)[:, None], np.arange(2))
    assert found.shape == (3, 2)
    assert found[2, 1] == threefry(np.uint64(2), 1)
