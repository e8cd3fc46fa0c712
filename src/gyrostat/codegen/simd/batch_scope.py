"""Primitives allowed in batches beyond flight code: random numbers, more types, any loop."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.lower import Lowering
from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Block, Kind, Number
from gyrostat.codegen.scope import Scope, kind_of
from gyrostat.codegen.source import Source, refused
from gyrostat.core.jax64 import jax, jnp

LARGEST = 4096
LONGEST = 64
"""Passes of a scan whose rows are scalars of the program."""
NARROW = {np.dtype(np.uint32): "to_word", np.dtype(np.int32): "to_half"}
"""What keeps numbers of 32 bits within them."""


def wide_kind(dtype: Any) -> Kind | None:
    """The kind of number of an array type; a random key of Threefry is 64 bits."""
    if dtype in (np.uint32, np.uint64) or str(dtype) == "key<fry>":
        return "bits"
    return kind_of(dtype)


def numbers(array: Any) -> NDArray[Any]:
    """An array of numbers; of a random key's two words one of 64 bits."""
    if jnp.issubdtype(getattr(array, "dtype", np.float64), jax.dtypes.prng_key):
        pair = np.asarray(jax.random.key_data(array)).astype(np.uint64)
        return (pair[..., 0] << np.uint64(32)) | pair[..., 1]
    return np.asarray(array)


def _drawn(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    """Words of a key's stream, one for each element: 64 bits, or a key.

    Threefry-2x32 of the element's number, as JAX draws with `jax_threefry_partitionable`.
    """
    if (
        equation.params.get("bit_width", 64) != 64
        or not jax.config.values["jax_threefry_partitionable"]
    ):
        raise refused(equation, where, "random bits of another kind", "64 partitionable ones")
    names = lowering.names(equation.outvars[0], where)
    keys = given[0]
    words = names.reshape([keys.size, -1])
    for key, row in zip(keys.flat, words, strict=True):
        for number, name in enumerate(row):
            row[number] = lowering.assigned(
                block, "threefry", (key, Number("bits", number)), name, where
            )
    return [words.reshape(names.shape)]


def _folded_in(
    lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source
):
    """The keys of numbers: that of number n is word n of the stream."""
    return [lowering.applied(block, "threefry", equation.outvars[0], where, *given)]


def _seeded(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    """The key of a seed: its 64 bits."""
    seed = given[0]
    size = 8 * equation.invars[0].aval.dtype.itemsize
    if all(isinstance(operand, Number) for operand in seed.flat):
        return [one_by_one(seed.shape, lambda s: Number("bits", int(s.value) % 2**size), seed)]
    operation = "to_bits" if size == 64 else "to_word"
    return [lowering.applied(block, operation, equation.outvars[0], where, seed)]


def _bitcast(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    before, after = equation.invars[0].aval.dtype, equation.outvars[0].aval.dtype
    if before == after:
        return [given[0]]
    if np.bool_ in (before, after) or before.itemsize != after.itemsize:
        raise refused(equation, where, f"{before} as {after}", "numbers of as many bits")
    operation = NARROW.get(after) or f"as_{lowering.kind(equation.outvars[0])}"
    return [lowering.applied(block, operation, equation.outvars[0], where, *given)]


def _inverse_error_function(
    lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source
):
    return [lowering.applied(block, "erf_inv", equation.outvars[0], where, *given)]


WIDE = Scope(
    kind_of=wide_kind,
    lowered={
        "random_bits": _drawn,
        "random_split": _drawn,
        "random_fold_in": _folded_in,
        "random_seed": _seeded,
        "bitcast_convert_type": _bitcast,
        "erf_inv": _inverse_error_function,
    },
    largest=LARGEST,
    in_place=True,
    unbounded=True,
    array=numbers,
    narrow=NARROW,
    longest=LONGEST,
)
"""The scope of a campaign."""
