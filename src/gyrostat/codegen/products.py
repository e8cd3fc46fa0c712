"""Rule for matrix products: written out, or loops where that is shorter and no slower."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import Array, Data, Deferred, is_plain, joined, moved
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import accumulated, nest
from gyrostat.codegen.nests import declared, filled, objects, put, reader, settled, store
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Number, Operand
from gyrostat.codegen.views import view_of

ZERO, ONE = Number("real", 0.0), Number("real", 1.0)
LONGEST = 1000
"""Largest number of products of scalars that are written out."""
WRITTEN_ROWS = 128
"""Largest number of products in the body of a loop over the columns of a matrix."""
NARROW = 4
"""Largest number of columns for which each sum of products has a loop of its own."""


@dataclass(frozen=True)
class _Factor:
    """Matrix of a product.

    Attributes:
        array: Rows and columns.
        known: Elements where they are scalars or elements of tables; None for a deferred operation.
        is_used: Whether each element is other than the constant 0.
    """

    array: Array
    known: Scalars | None
    is_used: NDArray[np.bool_]


def _factor(build: Builder, array: Array) -> _Factor:
    is_known = is_plain(array) or isinstance(array, np.ndarray)
    known = objects(build, array) if is_known else None
    if known is None:
        return _Factor(array, None, np.ones(array.shape, bool))
    is_used = np.array([each != ZERO for each in known.flat], bool).reshape(known.shape)
    return _Factor(array, known, is_used)


def _dot(build: Builder, first: Array, second: Array) -> Array | Sequence[Array]:
    """Sums of products, added from first to last, without those with a constant zero.

    A zero of a matrix means that two quantities have nothing to do with each other: NaN and
    infinity do not spread through it.
    """
    (left_axes, right_axes), (left_batch, right_batch) = build.params["dimension_numbers"]
    if any(operand.aval.dtype != np.float64 for operand in build.equation.invars):
        raise build.refused("operands of other types", "float64 ones")

    def rows(array: Array, batch: Sequence[int], axes: Sequence[int], *, last: bool) -> Array:
        free = [k for k in range(array.ndim) if k not in (*batch, *axes)]
        order = [*batch, *free, *axes] if last else [*batch, *axes, *free]
        counts = [int(np.prod([array.shape[k] for k in group])) for group in (batch, free, axes)]
        sizes = counts if last else [counts[0], counts[2], counts[1]]
        return moved(lambda _, each: [each.transpose(order).reshape(sizes)], {}, array)[0]

    left = rows(first, left_batch, left_axes, last=True)
    right = rows(second, right_batch, right_axes, last=False)
    results = [_product(build, _row(left, b), _row(right, b)) for b in range(left.shape[0])]
    if len(results) == 1:
        return _shaped(build, results[0])
    stacked = np.stack([objects(build, each) for each in results])
    return _shaped(build, joined(stacked))


def _row(array: Array, number: int) -> Array:
    return moved(lambda _, each: [each[number]], {}, array)[0]


def _shaped(build: Builder, array: Array) -> Array:
    return settled(build, moved(lambda _, each: [each.reshape(build.shape)], {}, array)[0])


def _product(build: Builder, left: Array, right: Array) -> Array:
    """Product of two matrices."""
    if not left.size or not right.size:
        raise build.refused("a sum of no elements", "one or more")
    # an operation on each element is computed once, not in each sum
    left, right = (filled(build, a) if isinstance(a, Deferred) else a for a in (left, right))
    first, second = _factor(build, left), _factor(build, right)
    terms = first.is_used.astype(int) @ second.is_used.astype(int)
    products = int(terms.sum())
    if all(isinstance(each, np.ndarray) and is_plain(each) for each in (left, right)):
        is_written = products <= LONGEST
    else:
        is_written = _operations(first, second, terms) <= build.scope.written
    if is_written:
        return _written(build, first, second, terms.shape)
    height, width = terms.shape
    used, used_right = int(first.is_used.sum()), int(second.is_used.sum())
    dense = first.is_used.size * width
    if 2 * used * width <= dense and used <= WRITTEN_ROWS and width > 1:
        return _over_columns(build, first, right)
    if 2 * used_right * height <= dense and used_right <= WRITTEN_ROWS and height > 1:
        transposed = _Factor(_turned(second.array), _turned(second.known), second.is_used.T)
        return _turned(_over_columns(build, transposed, _turned(left)))
    return _looped(build, left, right)


def _turned(array: Any) -> Any:
    return array if array is None else moved(lambda _, each: [each.T], {}, array)[0]


def _operations(first: _Factor, second: _Factor, terms: NDArray[Any]) -> int:
    """Number of products and sums, without products with 1."""
    count = int(terms.sum()) + int(np.maximum(terms - 1, 0).sum())
    for factor, times in (
        (first, second.is_used.sum(axis=1)),
        (second, first.is_used.sum(axis=0)[:, None]),
    ):
        if factor.known is not None:
            is_one = np.array([each == ONE for each in factor.known.flat], bool)
            count -= int((is_one.reshape(factor.known.shape) * times).sum())
    return count


def _written(
    build: Builder, first: _Factor, second: _Factor, shape: tuple[int, ...]
) -> Scalars | Data:
    left, right = (objects(build, factor.array) for factor in (first, second))
    sums, group = np.empty(shape, dtype=object), next(build.groups)
    for i, j in np.ndindex(shape):
        pairs = [(a, b) for a, b in zip(left[i], right[:, j], strict=True)]
        sums[i, j] = _sum(build, [pair for pair in pairs if ZERO not in pair], group)
    return joined(sums)


def _sum(build: Builder, pairs: Sequence[tuple[Any, Any]], group: int) -> Any:
    """Sum of products; an element of a table that stands alone remains one."""
    terms = []
    for pair in pairs:
        a, b = pair if pair[0] == ONE else pair[::-1]
        terms.append(b if a == ONE else build.compute("mul", *map(build.scalar, pair), group=group))
    if len(terms) == 1:
        return terms[0]
    return build.fold("add", [build.scalar(term) for term in terms]) if terms else ZERO


def _over_columns(build: Builder, first: _Factor, right: Array) -> Array:
    """Product whose sums are written out, in a loop over the columns of the right matrix.

    A row with a single 1 is a row of the right matrix.
    """
    assert first.known is not None
    left, (height, width) = first.known, (first.known.shape[0], right.shape[1])
    rows = [_row(right, k) for k in range(right.shape[0])]
    counts = first.is_used.sum(axis=1)
    ones = np.array([each == ONE for each in left.flat], bool).reshape(left.shape)
    is_row = (counts == 1) & ones.any(axis=1)
    summed = [i for i in range(height) if counts[i]]
    if is_row[summed].all():
        summed = []
    table = declared(build, "real", len(summed) * width) if summed else None
    results = np.full((height, width), ZERO, dtype=object)
    for i in range(height):
        if is_row[i] and not summed:
            results[i] = objects(build, rows[int(np.argmax(ones[i]))])
    if table is None:
        return joined(results)
    data = Data(table, np.arange(table.size).reshape(len(summed), width))
    used = [k for k in range(len(rows)) if first.is_used[summed, k].any()]
    readers = {k: reader(build, rows[k]) for k in used}
    used_factors: Any = np.where(first.is_used, left, np.array(ZERO, dtype=object))
    factors = build.scalars(used_factors)

    def body(inside: Builder, counters: tuple[Operand, ...]) -> None:
        group = next(build.groups)
        column = {k: readers[k](inside, counters) for k in used}
        for number, i in enumerate(summed):
            pairs = [(factors[i, k], column[k]) for k in used if first.is_used[i, k]]
            total = inside.scalar(_sum(inside, pairs, group))
            put(inside, view_of(Data(data.table, data.places[number])), counters, total)

    nest(build, [width], body)
    results[summed] = data.elements()
    return joined(results)


def _looped(build: Builder, left: Array, right: Array) -> Data:
    """Product as loops over rows, products and columns."""
    (height, count), width = left.shape, right.shape[1]
    table = declared(build, "real", height * width)
    data = Data(table, np.arange(table.size).reshape(height, width))
    view, at_left, at_right = view_of(data), reader(build, left), reader(build, right)

    def total(inside: Builder, counters: tuple[Operand, ...]) -> None:
        row, column = counters

        def step(within: Builder, inner: tuple[Operand, ...], so_far: Operand) -> Operand:
            pair = at_left(within, (row, *inner)), at_right(within, (*inner, column))
            return within.compute("add", so_far, within.compute("mul", *pair))

        put(inside, view, counters, accumulated(inside, [count], ZERO, step, depth=2))

    def terms(inside: Builder, counters: tuple[Operand, ...]) -> None:
        row, number = counters
        factor = at_left(inside, counters)

        def add(within: Builder, inner: tuple[Operand, ...]) -> None:
            term = within.compute("mul", factor, at_right(within, (number, *inner)))
            put(
                within,
                view,
                (row, *inner),
                within.compute("add", view.at(within, (row, *inner)), term),
            )

        nest(inside, [width], add, depth=2)

    if width <= NARROW:
        nest(build, [height, width], total)
        return data
    # sums of one row side by side: a processor need not wait for one addition before the next
    store(build, np.broadcast_to(np.array(ZERO, dtype=object), data.shape), data)
    nest(build, [height, count], terms)
    return data


RULES: dict[str, Callable[..., Array | Sequence[Array]]] = {"dot_general": _dot}
"""Primitive -> (builder, operands) -> result."""
