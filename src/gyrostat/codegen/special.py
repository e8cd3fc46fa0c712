"""Lower primitives that need more than one operation for each element."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Block, Name, Number, Operand
from gyrostat.codegen.source import Source, refused

if TYPE_CHECKING:
    from gyrostat.codegen.lower import Lowering

ONE = Number("real", 1.0)


def _power(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    """A whole power, by squaring as XLA does."""
    (base,) = given
    exponent = equation.params["y"]
    left, total = abs(exponent), None
    target = equation.outvars[0]
    while left:
        if left & 1:
            if total is None:
                total = base
            else:
                total = lowering.applied(block, "mul", target, where, total, base)
        left >>= 1
        if left:
            base = lowering.applied(block, "mul", target, where, base, base)
    if total is None:
        return np.full(target.aval.shape, ONE, dtype=object)
    return total if exponent > 0 else _inverse(lowering, equation, total, block, where)


def _inverse(lowering: "Lowering", equation: Any, array: Scalars, block: Block, where: Source):
    ones = np.full(array.shape, ONE, dtype=object)
    return lowering.applied(block, "div", equation.outvars[0], where, ones, array)


def _square(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    return lowering.applied(block, "mul", equation.outvars[0], where, given[0], given[0])


def _rsqrt(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    root = lowering.applied(block, "sqrt", equation.outvars[0], where, *given)
    return _inverse(lowering, equation, root, block, where)


def _logistic(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    target = equation.outvars[0]
    power = lowering.applied(block, "neg", target, where, *given)
    power = lowering.applied(block, "exp", target, where, power)
    ones = np.full(power.shape, ONE, dtype=object)
    total = lowering.applied(block, "add", target, where, ones, power)
    return _inverse(lowering, equation, total, block, where)


def _select(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    """One of several cases by a condition or a number."""
    which, *cases = given
    target, kind = equation.outvars[0], lowering.kind(equation.invars[0])
    if kind == "logical":
        which = np.broadcast_to(which, target.aval.shape)
        return lowering.applied(block, "select", target, where, which, cases[1], cases[0])
    chosen = cases[-1]
    for k in range(len(cases) - 2, -1, -1):
        here = lowering.tested(block, "le", which, Number(kind, k), where)
        here = np.broadcast_to(here, target.aval.shape)
        chosen = lowering.applied(block, "select", target, where, here, cases[k], chosen)
    return chosen


def _clamp(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    target = equation.outvars[0]
    low, array, high = (np.broadcast_to(each, target.aval.shape) for each in given)
    if lowering.kind(target) == "integer":

        def kept(first: Operand, index: Operand, last: Operand) -> Operand:
            return lowering.within(block, index, first, last, where)

        return one_by_one(target.aval.shape, kept, low, array, high)
    above = lowering.applied(block, "max", target, where, low, array)
    return lowering.applied(block, "min", target, where, above, high)


def _convert(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """A conversion as XLA does it: whole numbers wrap around, real ones end at the limits."""
    source, target = equation.invars[0], equation.outvars[0]
    before, after = source.aval.dtype, target.aval.dtype
    kind, narrow = lowering.kind(target), lowering.scope.narrow.get(after)

    def made(operation: str, *operands: Any) -> Scalars:
        return lowering.applied(block, operation, target, where, *operands)

    if kind == lowering.kind(source) and (narrow is None or before == after):
        return given[0]
    if kind == "logical":
        return made("ne", given[0], np.array(Number(lowering.kind(source), 0)))
    if before != np.float64 and all(isinstance(operand, Number) for operand in given[0].flat):
        values = np.vectorize(lambda operand: operand.value, otypes=[before])(given[0])
        return lowering.numbers(values.astype(after))
    if before not in (np.float64, np.bool_) and narrow is not None:
        return made(narrow, given[0])
    converted = made(f"to_{kind}", given[0])
    if before == np.float64 and np.issubdtype(after, np.integer) and after.itemsize < 8:
        limits = np.iinfo(after)
        converted = made("max", converted, np.array(Number(kind, int(limits.min))))
        converted = made("min", converted, np.array(Number(kind, int(limits.max))))
    return converted


def _round(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    to_even = int(equation.params["rounding_method"]) == 1
    return lowering.applied(
        block, "rint" if to_even else "round", equation.outvars[0], where, *given
    )


def _iota(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    shape, axis = equation.params["shape"], equation.params["dimension"]
    every = np.indices(shape)[axis].astype(equation.params["dtype"])
    return lowering.numbers(every)


def _dot(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    """Sums of products, the first ones first."""
    (left_axes, right_axes), (left_batch, right_batch) = equation.params["dimension_numbers"]
    if equation.invars[0].aval.dtype != np.float64 or equation.invars[1].aval.dtype != np.float64:
        raise refused(equation, where, "operands of other types", "float64 ones")

    def rows(array: Scalars, batch: Sequence[int], axes: Sequence[int]) -> Scalars:
        free = [k for k in range(array.ndim) if k not in (*batch, *axes)]
        counts = [int(np.prod([array.shape[k] for k in group])) for group in (batch, free, axes)]
        return array.transpose([*batch, *free, *axes]).reshape(counts)

    left, right = rows(given[0], left_batch, left_axes), rows(given[1], right_batch, right_axes)
    made = np.empty((len(left), left.shape[1], right.shape[1]), dtype=object)
    group = lowering.new_group()
    for b, i, j in np.ndindex(made.shape):
        terms: list[Operand] = []
        for one, other in zip(left[b, i], right[b, j], strict=True):
            name = Name("real", where.name, group)
            terms.append(lowering.assigned(block, "mul", (one, other), name, where))
        made[b, i, j] = lowering.folded(block, "add", terms, where)
    return made.reshape(equation.outvars[0].aval.shape)


def _platform(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """The number of the branch for a processor, or of the one for whatever there is."""
    platforms = equation.params["platforms"]
    for number, names in enumerate(platforms):
        if names is None or "cpu" in names:
            return np.array(Number("integer", number), dtype=object)
    raise refused(equation, where, f"code for {platforms} alone", "code for a processor")


def _shifted(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """Bits moved to the right, zeros after them."""
    if equation.outvars[0].aval.dtype == np.int32:
        raise refused(equation, where, "a shift of int32", "one of int64 or an unsigned type")
    return lowering.applied(block, "shift_right", equation.outvars[0], where, *given)


LOWERED: dict[str, Callable[..., Scalars]] = {
    "clamp": _clamp,
    "convert_element_type": _convert,
    "dot_general": _dot,
    "integer_pow": _power,
    "iota": _iota,
    "logistic": _logistic,
    "platform_index": _platform,
    "round": _round,
    "rsqrt": _rsqrt,
    "select_n": _select,
    "shift_right_logical": _shifted,
    "square": _square,
}
"""Primitive -> (lowering, equation, operands, block, source) -> result."""
