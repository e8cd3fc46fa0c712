"""What a campaign may compute beyond flight code: noise, more kinds of numbers, any loop."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat._jax import jax, jnp
from gyrostat.lowering.lower import Lowering
from gyrostat.lowering.primitives import Scalars, one_by_one
from gyrostat.lowering.program import Block, Kind, Name, Number, Operand
from gyrostat.lowering.scope import Scope, kind_of
from gyrostat.lowering.tracing import Source, refused

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


def _convert(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    """A conversion as XLA does it: whole numbers wrap around, real ones end at the limits."""
    target, before = equation.outvars[0], equation.invars[0].aval.dtype
    after, kind = target.aval.dtype, lowering.kind(target)

    def made(operation: str, *operands: Any) -> Scalars:
        return lowering.applied(block, operation, target, where, *operands)

    if kind == wide_kind(before) and (after == before or after.itemsize > before.itemsize):
        return [given[0]]
    if kind == "logical":
        return [made("ne", given[0], np.array(Number(lowering.kind(equation.invars[0]), 0)))]
    if before != np.float64 and all(isinstance(operand, Number) for operand in given[0].flat):
        values = np.vectorize(lambda operand: operand.value, otypes=[before])(given[0])
        return [lowering.numbers(values.astype(after))]
    if before not in (np.float64, np.bool_) and after in NARROW:
        return [made(NARROW[after], given[0])]
    converted = made(f"to_{kind}", given[0])
    if before == np.float64 and after in NARROW:
        limits = np.iinfo(after)
        converted = made("max", converted, np.array(Number(kind, int(limits.min))))
        converted = made("min", converted, np.array(Number(kind, int(limits.max))))
    return [converted]


def _bitcast(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    before, after = equation.invars[0].aval.dtype, equation.outvars[0].aval.dtype
    if before == after:
        return [given[0]]
    if np.bool_ in (before, after) or before.itemsize != after.itemsize:
        raise refused(equation, where, f"{before} as {after}", "numbers of as many bits")
    operation = NARROW.get(after) or f"as_{lowering.kind(equation.outvars[0])}"
    return [lowering.applied(block, operation, equation.outvars[0], where, *given)]


def _shifted(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    if equation.outvars[0].aval.dtype == np.int32:
        raise refused(equation, where, "a shift of int32", "one of int64 or an unsigned type")
    return [lowering.applied(block, "shift_right", equation.outvars[0], where, *given)]


def _extreme(operation: str, of_logical: str) -> Callable[..., Sequence[Scalars]]:
    def lowered(
        lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source
    ):
        target = equation.outvars[0]
        made = of_logical if lowering.kind(target) == "logical" else operation
        return [lowering.applied(block, made, target, where, *given)]

    return lowered


def _elementwise(operation: str) -> Callable[..., Sequence[Scalars]]:
    def lowered(
        lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source
    ):
        return [lowering.applied(block, operation, equation.outvars[0], where, *given)]

    return lowered


def _sorted(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    """Sorted along one axis by exchanges of neighbours; NaN last."""
    if len(given) != 1:
        raise refused(equation, where, "several arrays sorted by one", "one array")
    axis = equation.params["dimension"]
    rows = np.moveaxis(given[0].copy(), axis, -1)
    target, kind = equation.outvars[0], lowering.kind(equation.outvars[0])

    def new(operation: str, kind: Kind, *operands: Operand) -> Operand:
        name = Name(kind, where.name, lowering.new_group())
        return lowering.assigned(block, operation, operands, name, where)

    for place in np.ndindex(rows.shape[:-1]):
        row = rows[place]
        for sweep in range(len(row)):
            for k in range(sweep % 2, len(row) - 1, 2):
                low, high = row[k], row[k + 1]
                swap = new("gt", "logical", low, high)
                swap = new("or", "logical", swap, new("ne", "logical", low, low))
                row[k] = new("select", kind, swap, high, low)
                row[k + 1] = new("select", kind, swap, low, high)
    return [np.moveaxis(rows, -1, axis).reshape(target.aval.shape)]


def _platform(lowering: Lowering, equation: Any, given: list[Scalars], block: Block, where: Source):
    """The branch for a processor, or the one for whatever there is."""
    platforms = equation.params["platforms"]
    for number, names in enumerate(platforms):
        if names is None or "cpu" in names:
            return [np.array(Number("integer", number), dtype=object)]
    raise refused(equation, where, f"code for {platforms} alone", "code for a processor")


WIDE = Scope(
    kind_of=wide_kind,
    lowered={
        "random_bits": _drawn,
        "random_split": _drawn,
        "random_fold_in": _folded_in,
        "random_seed": _seeded,
        "convert_element_type": _convert,
        "bitcast_convert_type": _bitcast,
        "erf_inv": _elementwise("erf_inv"),
        "shift_right_logical": _shifted,
        "shift_left": _elementwise("shift_left"),
        "max": _extreme("max", "or"),
        "min": _extreme("min", "and"),
        "or": _elementwise("or"),
        "xor": _elementwise("xor"),
        "and": _elementwise("and"),
        "sort": _sorted,
        "platform_index": _platform,
    },
    largest=LARGEST,
    in_place=True,
    unbounded=True,
    array=numbers,
    narrow=NARROW,
    longest=LONGEST,
)
"""The scope of a campaign."""
