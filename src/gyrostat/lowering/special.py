"""Primitives that become more than one operation on each element."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.lowering.primitives import Scalars, one_by_one
from gyrostat.lowering.program import Assign, Block, Fill, Name, Number, Operand, Table
from gyrostat.lowering.tracing import Source, refused

if TYPE_CHECKING:
    from gyrostat.lowering.lower import Lowering

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
    which, *cases = given
    if len(cases) != 2 or equation.invars[0].aval.dtype != np.bool_:
        raise refused(
            equation, where, f"a choice among {len(cases)}", "one between two by a condition"
        )
    target = equation.outvars[0]
    which = np.broadcast_to(which, target.aval.shape)
    return lowering.applied(block, "select", target, where, which, cases[1], cases[0])


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
    source_kind = lowering.kind(equation.invars[0])
    target = equation.outvars[0]
    kind = lowering.kind(target)
    if kind == source_kind:
        return given[0]
    if source_kind == "real" or kind == "logical":
        found = f"a conversion from {equation.invars[0].aval.dtype} to {target.aval.dtype}"
        raise refused(equation, where, found, "one that loses nothing")

    def number(operand: Operand) -> Operand:
        value = operand.value if isinstance(operand, Number) else 0
        return Number(kind, float(value) if kind == "real" else int(value))

    if all(isinstance(operand, Number) for operand in given[0].flat):
        return one_by_one(target.aval.shape, number, given[0])
    return lowering.applied(block, f"to_{kind}", target, where, *given)


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


def _largest(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """Place of the largest or smallest element of one axis; the first of several, or a NaN."""
    array = given[0]
    if len(equation.params["axes"]) != 1 or array.ndim != 1:
        raise refused(equation, where, "an array of several axes", "a vector")
    test = "gt" if equation.primitive.name == "argmax" else "lt"
    kind = lowering.kind(equation.invars[0])
    best, place = array[0], Number("integer", 0)
    group = lowering.new_group()

    def new(operation: str, *operands: Operand) -> Operand:
        made = operands[1].kind if operation == "select" else "logical"
        return lowering.assigned(block, operation, operands, Name(made, where.name, group), where)

    for k in range(1, len(array)):
        better = new(test, array[k], best)
        if kind == "real":
            fresh = new("and", new("ne", array[k], array[k]), new("eq", best, best))
            better = new("or", better, fresh)
        best = new("select", better, array[k], best)
        place = new("select", better, Number("integer", k), place)
    return np.asarray(place, dtype=object)


class _Pick:
    """An array whose elements are picked by a running index, kept within it."""

    def __init__(
        self,
        lowering: "Lowering",
        array: Scalars,
        sizes: Sequence[int],
        block: Block,
        where: Source,
    ) -> None:
        self._lowering, self._block, self._where = lowering, block, where
        self._array, self._sizes = array, sizes
        self._strides = [int(np.prod(array.shape[k + 1 :])) for k in range(array.ndim)]
        self._table = Table(array.flat[0].kind, array.size, where.name)
        block.append(Fill(self._table, tuple(array.flat), where))

    def base(self, starts: Sequence[Operand]) -> Operand:
        """Where a part that starts at some indices begins in the table."""
        base: Operand = Number("integer", 0)
        for axis, start in enumerate(starts):
            last = Number("integer", self._array.shape[axis] - self._sizes[axis])
            zero = Number("integer", 0)
            kept = self._lowering.within(self._block, start, zero, last, self._where)
            step = self._new("mul", kept, Number("integer", self._strides[axis]))
            base = step if base == zero else self._new("add", base, step)
        return base

    def element(self, base: Operand, offset: Sequence[int], name: Name) -> Name:
        """An element of that part."""
        steps = sum(place * stride for place, stride in zip(offset, self._strides, strict=True))
        index = self._new("add", base, Number("integer", steps)) if steps else base
        self._block.append(Assign(name, "element", (index,), self._where, self._table))
        return name

    def _new(self, operation: str, *operands: Operand) -> Operand:
        if operation == "mul" and operands[1] == Number("integer", 1):
            return operands[0]
        name = Name("integer", "index", self._lowering.new_group())
        return self._lowering.assigned(self._block, operation, operands, name, self._where)


def _dynamic_slice(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """A part that starts at a running index."""
    pick = _Pick(lowering, given[0], equation.params["slice_sizes"], block, where)
    base = pick.base([start.item() for start in given[1:]])
    names: Any = lowering.names(equation.outvars[0], where)
    for place in np.ndindex(names.shape):
        pick.element(base, place, names[place])
    return names


def _gather(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    """Parts that start at running indices, one for each element of an array of indices."""
    array, indices = given
    params = equation.params
    dimensions, mode = params["dimension_numbers"], str(params["mode"])
    if "FILL" in mode or dimensions.operand_batching_dims:
        raise refused(equation, where, f"indices of mode {mode}", "indices promised to be within")
    pick = _Pick(lowering, array, params["slice_sizes"], block, where)
    names: Any = lowering.names(equation.outvars[0], where)
    kept = [k for k in range(array.ndim) if k not in dimensions.collapsed_slice_dims]
    bases: dict[tuple[int, ...], Operand] = {}
    for place in np.ndindex(names.shape):
        row = tuple(p for k, p in enumerate(place) if k not in dimensions.offset_dims)
        if row not in bases:
            starts: list[Operand] = [Number("integer", 0)] * array.ndim
            for axis, start in zip(dimensions.start_index_map, indices[row], strict=True):
                starts[axis] = start
            bases[row] = pick.base(starts)
        offset = [0] * array.ndim
        for axis, k in zip(kept, dimensions.offset_dims, strict=True):
            offset[axis] = place[k]
        pick.element(bases[row], offset, names[place])
    return names


LOWERED: dict[str, Callable[..., Scalars]] = {
    "argmax": _largest,
    "argmin": _largest,
    "clamp": _clamp,
    "convert_element_type": _convert,
    "dot_general": _dot,
    "dynamic_slice": _dynamic_slice,
    "gather": _gather,
    "integer_pow": _power,
    "iota": _iota,
    "logistic": _logistic,
    "round": _round,
    "rsqrt": _rsqrt,
    "select_n": _select,
    "square": _square,
}
"""Primitive -> (lowering, equation, operands, block, source) -> result."""
