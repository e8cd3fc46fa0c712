"""Matrix products as loops, which leave out what known zeros leave out."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import Array, Data, joined, moved, runs_of
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import accumulated, nest
from gyrostat.codegen.nests import declared, objects, put, reader, store
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import ONE, ZERO, Operand
from gyrostat.codegen.views import view_of

WRITTEN_SUM = 8
"""Largest number of products of a sum that is written out in loops over rows and columns."""
LONGEST_SUM = 16
"""Largest number of products of a sum that has a loop of its own; longer ones are side by side."""
NARROW = 4
"""Largest number of columns for which each sum of products has a loop of its own."""


@dataclass(frozen=True)
class Factor:
    """Matrix of a product.

    Attributes:
        array: Rows and columns.
        known: Elements where they are scalars or elements of tables; None for a deferred operation.
        is_used: Whether each element is other than the constant 0.
    """

    array: Array
    known: Scalars | None
    is_used: NDArray[np.bool_]


def row_of(array: Array, number: int) -> Array:
    """One row, or one matrix of several."""
    return moved(lambda _, each: [each[number]], {}, array)[0]


def rows_of(array: Array, numbers: NDArray[np.int64]) -> Array:
    """Some rows of a matrix."""
    return moved(lambda _, each: [each[numbers]], {}, array)[0]


def columns_of(array: Array, numbers: NDArray[np.int64]) -> Array:
    """Some columns of a matrix."""
    return moved(lambda _, each: [each[:, numbers]], {}, array)[0]


def turned(array: Any) -> Any:
    """Transposed matrix; None remains None."""
    return array if array is None else moved(lambda _, each: [each.T], {}, array)[0]


def transposed(factor: Factor) -> Factor:
    """Transposed matrix of a product."""
    return Factor(turned(factor.array), turned(factor.known), factor.is_used.T)


def sum_of_products(build: Builder, pairs: Sequence[tuple[Any, Any]], group: int) -> Any:
    """Sum of products; an element of a table that stands alone remains one."""
    terms = []
    for pair in pairs:
        a, b = pair if pair[0] == ONE else pair[::-1]
        terms.append(b if a == ONE else build.compute("mul", *map(build.scalar, pair), group=group))
    if len(terms) == 1:
        return terms[0]
    return build.fold("add", [build.scalar(term) for term in terms]) if terms else ZERO


def over_columns(build: Builder, first: Factor, right: Array) -> Array:
    """Product whose sums are written out, in a loop over the columns of the right matrix.

    A row with a single 1 is a row of the right matrix.
    """
    assert first.known is not None
    left, (height, width) = first.known, (first.known.shape[0], right.shape[1])
    rows = [row_of(right, k) for k in range(right.shape[0])]
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
            total = inside.scalar(sum_of_products(inside, pairs, group))
            put(inside, view_of(Data(data.table, data.places[number])), counters, total)

    nest(build, [width], body)
    results[summed] = data.elements()
    return joined(results)


def looped(build: Builder, first: Factor, second: Factor) -> Data:
    """Product as loops over rows, products and columns."""
    height, width = len(first.is_used), second.is_used.shape[1]
    table = declared(build, "real", height * width)
    data = Data(table, np.arange(table.size).reshape(height, width))
    left, right = first.array, second.array
    if width <= NARROW:
        sum_by_sum(build, left, right, data)
        return data
    for factor, other, result in (
        (first, right, data),
        (transposed(second), turned(left), turned(data)),
    ):
        parts = _parts(factor)
        if parts is None:
            continue
        _side_by_side(build, left, right, parts.dense, data)
        for factors, rows, columns in parts.rest:
            add_rows(build, factors, rows_of(other, columns), rows_of(result, rows))
        return data
    _side_by_side(build, left, right, np.arange(left.shape[1]), data)
    return data


class _Parts(NamedTuple):
    """Columns of a matrix that are mostly used, and used elements of the others.

    Attributes:
        dense: Columns.
        rest: Elements with their rows and columns, which have constant distances.
    """

    dense: NDArray[np.int64]
    rest: list[tuple[Scalars, NDArray[np.int64], NDArray[np.int64]]]


def _parts(factor: Factor) -> _Parts | None:
    """Parts of a matrix; None if its known zeros leave out less than a quarter of a product."""
    height, count = factor.is_used.shape
    is_dense = 2 * factor.is_used.sum(axis=0) > height
    dense, rest = np.flatnonzero(is_dense), np.flatnonzero(factor.is_used & ~is_dense)
    is_few = len(dense) * height + len(rest) <= 0.75 * height * count and len(rest) <= 2 * count
    if factor.known is None or not is_few:
        return None
    runs = []
    for places in runs_of(rest):
        rows, columns = np.divmod(places, count)
        even = not np.diff(columns, 2).any()
        for some in [slice(None)] if even else [slice(k, k + 1) for k in range(len(places))]:
            runs.append((factor.known[rows[some], columns[some]], rows[some], columns[some]))
    return _Parts(dense, runs)


def sum_by_sum(
    build: Builder, left: Array, right: Array, data: Data, *, adds: bool = False
) -> None:
    """Product, with a loop for each sum.

    Args:
        build: Builder.
        left: Left matrix.
        right: Right matrix.
        data: Elements of the result.
        adds: Whether the product is added to what is there.
    """
    view, at_left, at_right = view_of(data), reader(build, left), reader(build, right)

    def total(inside: Builder, counters: tuple[Operand, ...]) -> None:
        row, column = counters

        def step(within: Builder, inner: tuple[Operand, ...], so_far: Operand) -> Operand:
            pair = at_left(within, (row, *inner)), at_right(within, (*inner, column))
            return within.compute("add", so_far, within.compute("mul", *pair))

        start = view.at(inside, counters) if adds else ZERO
        put(inside, view, counters, accumulated(inside, [left.shape[1]], start, step, depth=2))

    nest(build, data.shape, total)


def _side_by_side(
    build: Builder, left: Array, right: Array, numbers: NDArray[np.int64], data: Data
) -> None:
    """Product of some columns and the same rows.

    The sums of one row are side by side: a processor need not wait for one addition before the
    next.
    """
    if len(numbers) > LONGEST_SUM:
        store(build, np.broadcast_to(np.array(ZERO, dtype=object), data.shape), data)
        for run in runs_of(numbers):
            _add_terms(build, columns_of(left, run), rows_of(right, run), data)
        return
    if len(numbers) > WRITTEN_SUM:
        for k, run in enumerate(runs_of(numbers)):
            sum_by_sum(build, columns_of(left, run), rows_of(right, run), data, adds=k > 0)
        return
    view = view_of(data)
    at_left = [reader(build, row_of(turned(left), int(k))) for k in numbers]
    at_right = [reader(build, row_of(right, int(k))) for k in numbers]

    def sums(inside: Builder, row: tuple[Operand, ...]) -> None:
        factors = [at(inside, row) for at in at_left]

        def total(within: Builder, column: tuple[Operand, ...]) -> None:
            pairs = [(f, at(within, column)) for f, at in zip(factors, at_right, strict=True)]
            total = within.scalar(sum_of_products(within, pairs, next(within.groups)))
            put(within, view, (*row, *column), total)

        nest(inside, [data.shape[1]], total, depth=2)

    nest(build, [data.shape[0]], sums)


def _add_terms(build: Builder, left: Array, right: Array, data: Data) -> None:
    """Add a product to a matrix."""
    view, at_left, at_right = view_of(data), reader(build, left), reader(build, right)

    def terms(inside: Builder, counters: tuple[Operand, ...]) -> None:
        row, number = counters
        factor = at_left(inside, counters)

        def add(within: Builder, inner: tuple[Operand, ...]) -> None:
            term = within.compute("mul", factor, at_right(within, (number, *inner)))
            total = within.compute("add", view.at(within, (row, *inner)), term)
            put(within, view, (row, *inner), total)

        nest(inside, [data.shape[1]], add, depth=2)

    nest(build, left.shape, terms)


def add_rows(build: Builder, factors: Scalars, right: Array, data: Array) -> None:
    """Add a factor times a row of one matrix to each row of another."""
    assert isinstance(data, Data)
    view, at_factor, at_right = view_of(data), reader(build, factors), reader(build, right)

    def add(inside: Builder, counters: tuple[Operand, ...]) -> None:
        term = inside.compute("mul", at_factor(inside, counters[:1]), at_right(inside, counters))
        put(inside, view, counters, inside.compute("add", view.at(inside, counters), term))

    nest(build, data.shape, add)
