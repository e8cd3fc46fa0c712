"""Loops over the rows of a matrix of constants, such as the directions of forward differentiation.

`jax.jacfwd` computes with a row for each direction, which begins with a row of a unit matrix. The
operations on each row are the same, so that one loop can compute them for all: it reads its
constants from tables. Where rows meet other arrays, the loop has set tables with their results.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import Array, Data, is_plain
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.constants import constant_table
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import ZERO, Block, Loop, Name, Number, Operand, Table
from gyrostat.codegen.row_tables import has_rows, settled_rows
from gyrostat.codegen.rows import Row, RowLoop

LONG = 6
"""Smallest number of rows of a matrix whose rows may become passes of a loop."""
LINEAR = frozenset({"add", "add_any", "sub", "mul", "div"})
"""Operations on each element that directions take part in."""
LARGEST = 1024
"""Largest number of elements of a matrix whose rows may become passes of a loop."""
LEAST = 3
"""Smallest number of passes of a loop."""


def directed(build: Builder, operands: Sequence[Array], shape: tuple[int, ...]) -> Sequence[Array]:
    """Operands of one shape, with rows of constants as scalars of loops where that is possible.

    Directions are multiplied by numbers, and added to each other.
    """
    name = build.equation.primitive.name
    is_large = any(isinstance(each, Data) and each.size > LARGEST for each in operands)
    if name not in LINEAR or is_large or not _is_long(build, shape):
        return operands
    full: list[Any] = [np.broadcast_to(build.scalars(each), shape) for each in operands]
    if name not in ("mul", "div") and not all(map(_are_directions, full)):
        return operands
    axis = shape.index(max(shape))
    first, second = (~_numbers(each) for each in full)
    results = [along(build, full[0], axis, second), along(build, full[1], axis, first)]
    return results if any(map(has_rows, results)) else operands


def moved_rows(build: Builder, array: Any, move: Callable[[Any], Sequence[Any]]) -> Any:
    """Constants, with rows as scalars of loops if a move would take their columns apart.

    Args:
        build: Builder.
        array: Operand of the move.
        move: Function of an array.
    """
    if not is_plain(array) or not _is_long(build, array.shape):
        return array
    scalars, length = build.scalars(array), max(array.shape)
    axis = array.shape.index(length)
    if not _numbers(scalars).all() or not _in_runs(_by_axis(scalars, axis)).any():
        return array
    for result in move(scalars):
        if result.shape[axis] == length:
            rows = _by_axis(result, axis)
            if _used(rows[~_in_runs(rows)]).any():
                return along(build, scalars, axis, np.ones(scalars.shape, bool))
    return array


def along(build: Builder, array: Scalars, axis: int, meets: NDArray[np.bool_]) -> Scalars:
    """Array with rows of constants as scalars of loops.

    Args:
        build: Builder.
        array: Array.
        axis: Axis that counts the rows.
        meets: Whether each element is combined with one that is not constant.
    """
    if not _is_long(build, array.shape) or not _are_directions(array):
        return array
    rows = _by_axis(array, axis)
    now = len(build.memo.closings)
    wanted = [(start, stop) for number, start, stop in build.scope.rows or () if number == now]
    is_met = _by_axis(np.broadcast_to(meets, array.shape), axis)
    results = rows.copy()
    for start, stop in _runs(rows, wanted):
        if (is_met[start:stop] & _used(rows[start:stop])).any():
            loop = _loop(build, len(rows), start, stop - start)
            results[start:stop] = _read(build, loop, rows[start:stop])
    order = [array.shape[axis], *np.delete(array.shape, axis)]
    return np.moveaxis(results.reshape(order), 0, axis)


def _is_long(build: Builder, shape: tuple[int, ...]) -> bool:
    return build.scope.rows is not None and len(shape) > 1 and max(shape) >= LONG


def _are_directions(array: Scalars) -> bool:
    """Whether all rows are constants, or have become scalars of loops."""
    return all(isinstance(each, Number | Row) for each in array.flat)


def _by_axis(array: Any, axis: int) -> Any:
    """Array as a matrix of rows along an axis."""
    return np.moveaxis(array, axis, 0).reshape(array.shape[axis], -1)


def _used(rows: Scalars) -> NDArray[np.bool_]:
    return np.array([each != ZERO for each in rows.flat], bool).reshape(rows.shape)


def _in_runs(rows: Scalars) -> NDArray[np.bool_]:
    """Whether each row may be a pass of a loop."""
    flags = np.zeros(len(rows), bool)
    for start, stop in _runs(rows, ()):
        flags[start:stop] = True
    return flags


def _runs(rows: Scalars, wanted: Iterable[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Start and stop of runs of rows that are constant and have one element other than 0.

    Args:
        rows: Rows.
        wanted: Further runs, the rows of which may be 0.
    """
    if not rows.size or rows[0, 0].kind != "real":
        return
    is_constant = _numbers(rows).all(axis=1)
    counts = _used(rows).sum(axis=1)
    flags = is_constant & (counts == 1)
    for start, stop in wanted:
        if stop <= len(rows) and flags[start:stop].any():
            flags[start:stop] = (is_constant & (counts <= 1))[start:stop].all()
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    for start, stop in edges.reshape(-1, 2).tolist():
        if stop - start >= LEAST:
            yield start, stop


def _numbers(array: Scalars) -> NDArray[np.bool_]:
    return np.array([isinstance(each, Number) for each in array.flat], bool).reshape(array.shape)


def _loop(build: Builder, length: int, start: int, count: int) -> RowLoop:
    """Loop over some rows of arrays of a length; the same until it is in its block."""
    key = len(build.memo.closings), id(build.block), length, start, count
    loop = build.memo.loops.get(key)
    if loop is None or loop.block is not build.block or not loop.is_open:
        counter = Name("index", "i", next(build.groups))
        loop = RowLoop(build.block, Loop(count, counter, [], [], [], None, [], build.where))
        build.memo.loops[key] = loop
    return loop


def _read(build: Builder, loop: RowLoop, rows: Scalars) -> Scalars:
    """Rows of constants as scalars of a loop; a constant that all rows have remains one.

    A column with one number beside zeros is a part of a table with that number in the middle.
    """
    results = rows.copy()
    count = len(rows)
    for column in range(rows.shape[1]):
        numbers = rows[:, column]
        if all(each == numbers[0] for each in numbers):
            continue
        values, first = [each.value for each in numbers], 0
        used = [k for k, each in enumerate(numbers) if each != ZERO]
        if len(used) == 1:
            first = count - 1 - used[0]
            values = [0.0] * (count - 1) + [values[used[0]]] + [0.0] * (count - 1)
        table = constant_table(build.memo.tables, "real", values)
        for number in range(count):
            results[number, column] = loop.computed(
                number,
                ("element", table, first),
                partial(_element, build, table, first, loop.loop.counter),
            )
    return results


def _element(build: Builder, table: Table, first: int, counter: Name, body: Block) -> Operand:
    """Append the reading of an element of a constant table to the body of a loop."""
    inside, name = build.inside(body), Name("real", "direction", next(build.groups))
    at = inside.index("add", counter, Number("index", first))
    return inside.indexed(table, (at,), name)


def rows_of(build: Builder, operands: Sequence[Array], *, are_rows: bool) -> list[Array]:
    """Operands of an equation, with scalars of rows only where it computes them row by row.

    Args:
        build: Builder of the equation.
        operands: Operands.
        are_rows: Whether the rule takes scalars of rows.
    """
    if not any(map(has_rows, operands)):
        return [*operands]
    arrays: list[Any] = [array for array in operands if has_rows(array)]
    loops = {each.loop for array in arrays for each in array.flat if isinstance(each, Row)}
    is_open = all(loop.is_open and loop.block is build.block for loop in loops)
    if are_rows and is_open and all(map(is_plain, operands)):
        return [*operands]
    return [settled_rows(build, array) for array in operands]


def are_parallel(left: Scalars, right: Scalars) -> bool:
    """Whether each sum of products of two matrices is of one row."""
    rows, columns = ([_of(each) for each in side] for side in (left, right.T))
    return all(len(row | column) <= 1 for row in rows for column in columns)


def _of(scalars: Scalars) -> set[tuple[RowLoop, int]]:
    return {(each.loop, each.number) for each in scalars if isinstance(each, Row)}
