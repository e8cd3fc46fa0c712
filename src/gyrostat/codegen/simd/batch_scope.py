"""Primitives allowed in batches beyond flight code: random numbers, more types, any loop."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import SMALL, Array
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Kind, Number
from gyrostat.codegen.scope import NARROW, Scope, kind_of
from gyrostat.core.jax64 import jax
from gyrostat.core.random_keys import is_random_key, words_of

LARGEST = 4096
LONGEST = 64
"""Largest number of passes of a scan whose rows are scalars of the program."""

HALF = Number("bits", 32)
"""Number of bits of a word of a random key."""


@lru_cache
def batch_kind(dtype: Any) -> Kind | None:
    """Kind of number of an array type; a random key of Threefry is 64 bits."""
    if dtype in (np.uint32, np.uint64) or str(dtype) == "key<fry>":
        return "bits"
    return kind_of(dtype)


def numbers(array: Any) -> NDArray[Any]:
    """Array of numbers; the two words of a random key become one of 64 bits."""
    return words_of(array) if is_random_key(array) else np.asarray(array)


def _draw(build: Builder, keys: Scalars) -> Scalars:
    """Words of a key's random stream, one for each element: 32 or 64 bits, or a new key.

    Threefry-2x32 of the element's index, as JAX draws with `jax_threefry_partitionable`.
    """
    size = build.params.get("bit_width", 64)
    if size not in (32, 64) or not jax.config.values["jax_threefry_partitionable"]:
        raise build.refused("random bits of another kind", "32 or 64 partitionable ones")
    names: Any = build.names(build.target)
    words = names.reshape([keys.size, -1])
    for key, row in zip(keys.flat, words, strict=True):
        for number, name in enumerate(row):
            stream = key, Number("bits", number)
            if size == 64:
                row[number] = build.assign("threefry", stream, name)
                continue
            word = build.compute("threefry", *stream)
            halves = build.compute("shift_right", word, HALF), build.compute("to_word", word)
            row[number] = build.assign("xor", halves, name)
    return words.reshape(names.shape)


def _wrap(build: Builder, words: Scalars) -> Array:
    """Random keys of pairs of words of 32 bits."""
    high = build.apply("shift_left", words[..., 0], np.array(HALF, dtype=object))
    return build.apply("or", high, words[..., 1])


def _unwrap(build: Builder, keys: Scalars) -> Scalars:
    """Pairs of words of 32 bits of random keys."""
    names: Any = build.names(build.target)
    for position in np.ndindex(keys.shape):
        key: Any = keys[position]
        high, low = names[position]
        names[(*position, 0)] = build.assign("shift_right", (key, HALF), high)
        names[(*position, 1)] = build.assign("to_word", (key,), low)
    return names


def _seed(build: Builder, seed: Scalars) -> Array:
    """Key of a seed: the 64 bits of the seed."""
    size = 8 * build.equation.invars[0].aval.dtype.itemsize
    if all(isinstance(operand, Number) for operand in seed.flat):
        return one_by_one(seed.shape, lambda s: Number("bits", int(s.value) % 2**size), seed)
    return build.apply("to_bits" if size == 64 else "to_word", seed)


BATCH = Scope(
    kind_of=batch_kind,
    rules={
        "erf_inv": lambda build, array: build.apply("erf_inv", array),
        "random_bits": _draw,
        # key n is word n of the stream
        "random_fold_in": lambda build, *operands: build.apply("threefry", *operands),
        "random_seed": _seed,
        "random_split": _draw,
        "random_unwrap": _unwrap,
        "random_wrap": _wrap,
    },
    largest=LARGEST,
    few=SMALL,
    written=256,
    in_place=True,
    unbounded=True,
    array=numbers,
    narrow=NARROW,
    longest=LONGEST,
)
"""Scope of batches."""
