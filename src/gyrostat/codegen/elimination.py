"""Rules for Cholesky and LU factors and triangular solutions of larger matrices, in loops.

Those of small matrices are written out: see `linear_algebra.py`. Source: Golub and Van Loan, Matrix
Computations, 4th edition (sections below).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import Array, Data, moved
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import accumulated, nest, spanned
from gyrostat.codegen.nests import declared, filled, put, reader, settled
from gyrostat.codegen.program import ONE, ZERO, Kind, Name, Number, Operand
from gyrostat.codegen.views import View, view_of

TRUE, NAN = Number("logical", True), Number("real", np.nan)


@dataclass(frozen=True)
class _Cells:
    """Elements of a table, inside loops over the matrices of a batch.

    Attributes:
        view: All matrices.
        batch: Counters of the loops over the matrices.
    """

    view: View
    batch: tuple[Operand, ...]

    def get(self, build: Builder, *indices: Operand) -> Operand:
        """Element."""
        return self.view.at(build, (*self.batch, *indices))

    def set(self, build: Builder, value: Operand, *indices: Operand) -> None:
        """Assign an element."""
        put(build, self.view, (*self.batch, *indices), value)


def _next(build: Builder, counter: Operand) -> Operand:
    return build.index("add", counter, Number("index", 1))


def _minus_product(build: Builder, first: Operand, second: Operand, third: Operand) -> Operand:
    return build.compute("sub", first, build.compute("mul", second, third))


def _batch(
    build: Builder, tables: Sequence[Data], axes: Sequence[int], body: Callable[..., None]
) -> None:
    """Append loops over the matrices of a batch: (builder, cells of each table)."""
    shape = tables[0].shape[: tables[0].ndim - axes[0]]

    def inner(inside: Builder, counters: tuple[Operand, ...]) -> None:
        body(inside, *(_Cells(view_of(data), counters) for data in tables))

    nest(build, shape, inner, depth=_DEPTH)


_DEPTH = 3
"""Loops over a batch have other counters than those of a matrix."""


def _cholesky(build: Builder, matrix: Array) -> Array:
    """Lower factor (section 4.2); all NaN if the matrix is not positive definite, as in JAX."""
    data, size = filled(build, matrix), matrix.shape[-1]

    def factor(inside: Builder, rows: _Cells) -> None:
        def step(within: Builder, counters: tuple[Operand, ...], definite: Operand) -> Operand:
            (k,) = counters
            pivot = rows.get(within, k, k)
            refused = within.compute("le", pivot, ZERO)
            root = within.compute("sqrt", pivot)
            rows.set(within, root, k, k)
            start = _next(within, k)

            def divide(b: Builder, i: Operand) -> None:
                rows.set(b, b.compute("div", rows.get(b, i, k), root), i, k)

            def subtract(b: Builder, i: Operand) -> None:
                ratio = rows.get(b, i, k)

                def below(c: Builder, j: Operand) -> None:
                    old, other = rows.get(c, j, i), rows.get(c, j, k)
                    rows.set(c, _minus_product(c, old, other, ratio), j, i)

                spanned(b, i, size, below, depth=2)

            spanned(within, start, size, divide, depth=1)
            spanned(within, start, size, subtract, depth=1)
            return within.compute("and", definite, within.compute("not", refused))

        definite = accumulated(inside, [size], TRUE, step)

        def finish(within: Builder, counters: tuple[Operand, ...]) -> None:
            i, j = counters
            is_lower = within.compute("le", j, i)
            value = within.compute("select", is_lower, rows.get(within, i, j), ZERO)
            rows.set(within, within.compute("select", definite, value, NAN), i, j)

        nest(inside, [size, size], finish)

    _batch(build, [data], [2], factor)
    return settled(build, data)


def _triangular_solve(build: Builder, matrix: Array, right: Array) -> Array:
    """Solution of op(A) X = B, or of X op(A) = B, by substitution (section 3.1)."""
    params = build.params
    left_side, lower = params["left_side"], params["lower"]
    data = filled(build, right)
    rows = data if left_side else _turned(data)
    if params["transpose_a"] == left_side:
        matrix, lower = _turned(matrix), not lower
    if not lower:  # an upper triangle from its end is a lower one
        matrix = moved(lambda _, each: [each[..., ::-1, ::-1]], {}, matrix)[0]
        rows = moved(lambda _, each: [each[..., ::-1, :]], {}, rows)[0]
    at, (size, width) = reader(build, matrix), rows.shape[-2:]

    def solve(inside: Builder, cells: _Cells) -> None:
        def step(within: Builder, counters: tuple[Operand, ...]) -> None:
            (k,) = counters
            if not params["unit_diagonal"]:
                pivot = at(within, (*cells.batch, k, k))

                def divide(b: Builder, inner: tuple[Operand, ...]) -> None:
                    cells.set(b, b.compute("div", cells.get(b, k, *inner), pivot), k, *inner)

                nest(within, [width], divide, depth=1)

            def subtract(b: Builder, i: Operand) -> None:
                factor = at(b, (*cells.batch, i, k))

                def one(c: Builder, inner: tuple[Operand, ...]) -> None:
                    old, pivot_row = cells.get(c, i, *inner), cells.get(c, k, *inner)
                    cells.set(c, _minus_product(c, old, factor, pivot_row), i, *inner)

                nest(b, [width], one, depth=2)

            spanned(within, _next(within, k), size, subtract, depth=1)

        nest(inside, [size], step)

    assert isinstance(rows, Data)
    _batch(build, [rows], [2], solve)
    return settled(build, data)


def _turned(array: Any) -> Any:
    return moved(lambda _, each: [np.swapaxes(each, -1, -2)], {}, array)[0]


def _lu(build: Builder, matrix: Array) -> Sequence[Array]:
    """Triangular factors in one matrix, row exchanged at each step, permutation (section 3.4).

    Partial pivoting; a column without a pivot is left as it is, as in LAPACK.
    """
    data, batch, (height, width) = filled(build, matrix), matrix.shape[:-2], matrix.shape[-2:]
    count = min(height, width)
    pivots = _integers(build, "integer", (*batch, count))
    permutation = _integers(build, "integer", (*batch, height))

    def factor(inside: Builder, rows: _Cells, steps: _Cells, order: _Cells) -> None:
        def number(within: Builder, counters: tuple[Operand, ...]) -> None:
            order.set(within, _as_integer(within, counters[0]), *counters)

        nest(inside, [height], number)

        def step(within: Builder, counters: tuple[Operand, ...]) -> None:
            (k,) = counters
            best = _pivot(within, rows, k, height)
            steps.set(within, _as_integer(within, best), k)
            for cells, columns in ((rows, [width]), (order, [])):
                nest(within, columns, lambda b, j, c=cells: _exchange(b, c, k, best, j), depth=1)
            pivot = rows.get(within, k, k)
            is_zero = within.compute("eq", pivot, ZERO)
            divisor = within.compute("select", is_zero, ONE, pivot)

            def eliminate(b: Builder, i: Operand) -> None:
                ratio = b.compute("div", rows.get(b, i, k), divisor)
                rows.set(b, ratio, i, k)

                def subtract(c: Builder, j: Operand) -> None:
                    old, above = rows.get(c, i, j), rows.get(c, k, j)
                    rows.set(c, _minus_product(c, old, ratio, above), i, j)

                spanned(b, _next(b, k), width, subtract, depth=2)

            spanned(within, _next(within, k), height, eliminate, depth=1)

        nest(inside, [count], step)

    _batch(build, [data, pivots, permutation], [2, 1, 1], factor)
    return [settled(build, each) for each in (data, pivots, permutation)]


def _pivot(build: Builder, rows: _Cells, k: Operand, height: int) -> Operand:
    """Row, from k on, of the element of column k that is largest; the first NaN if there is one."""

    def step(inside: Builder, counters: tuple[Operand, ...], best: Operand) -> Operand:
        (i,) = counters
        size, largest = (inside.compute("abs", rows.get(inside, row, k)) for row in (i, best))
        is_first_nan = inside.compute(
            "and", inside.compute("ne", size, size), inside.compute("eq", largest, largest)
        )
        is_better = inside.compute("or", inside.compute("gt", size, largest), is_first_nan)
        return inside.compute("select", is_better, i, best)

    return accumulated(build, [height], k, step, depth=1, start=k)


def _exchange(
    build: Builder, cells: _Cells, first: Operand, second: Operand, place: tuple[Operand, ...]
) -> None:
    """Exchange the elements of two rows at one place."""
    old, new = cells.get(build, first, *place), cells.get(build, second, *place)
    cells.set(build, old, second, *place)
    cells.set(build, new, first, *place)


def _integers(build: Builder, kind: Kind, shape: tuple[int, ...]) -> Data:
    table = declared(build, kind, int(np.prod(shape)))
    return Data(table, np.arange(table.size).reshape(shape))


def _as_integer(build: Builder, index: Operand) -> Operand:
    name = Name("integer", "row", next(build.groups))
    return build.assign("to_integer", (index,), name)


RULES: dict[str, Callable[..., Array | Sequence[Array]]] = {
    "cholesky": _cholesky,
    "lu": _lu,
    "triangular_solve": _triangular_solve,
}
"""Primitive -> (builder, operands) -> result, or results."""
