"""Threefry-2x32 with NumPy: the random numbers of JAX, to the last bit.

J. K. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", 2011. A key is a word of 64
bits. The words are those of JAX with `jax_threefry_partitionable`.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Words = NDArray[np.uint64]
_ROTATIONS = ((13, 15, 26, 6), (17, 29, 16, 24))
_PARITY = np.uint32(0x1BD11BDA)


def threefry(key: ArrayLike, counter: ArrayLike) -> Words:
    """Random words of 64 bits, elementwise; arguments are broadcast.

    Word n of the stream of a key is that of counter n: n = 0, 1, ... for `jax.random.bits`, and
    the folded number for `jax.random.fold_in`, whose result is a key.

    Args:
        key: Keys. The key of a seed is the seed.
        counter: Counters.
    """
    key, counter = np.broadcast_arrays(np.asarray(key, np.uint64), np.asarray(counter, np.uint64))
    shape = key.shape
    # an overflow in a NumPy scalar gives a warning, in an array it does not
    key, counter = np.atleast_1d(key), np.atleast_1d(counter)
    high, low = _halves(key)
    keys = (high, low, high ^ low ^ _PARITY)
    x0, x1 = _halves(counter)
    x0, x1 = x0 + high, x1 + low
    for stage in range(5):
        for rotation in _ROTATIONS[stage % 2]:
            x0 = x0 + x1
            turned = (x1 << np.uint32(rotation)) | (x1 >> np.uint32(32 - rotation))
            x1 = turned ^ x0
        x0 = x0 + keys[(stage + 1) % 3]
        x1 = x1 + keys[(stage + 2) % 3] + np.uint32(stage + 1)
    return ((x0.astype(np.uint64) << np.uint64(32)) | x1).reshape(shape)


def _halves(words: Words) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    return (words >> np.uint64(32)).astype(np.uint32), words.astype(np.uint32)
