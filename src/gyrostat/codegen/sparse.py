"""Sums of a matrix and one with mostly known zeros, such as a diagonal one."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import (
    Array,
    Data,
    Deferred,
    is_plain,
    joined,
    runs_of,
    used,
)
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.constants import with_zero
from gyrostat.codegen.loops import nest
from gyrostat.codegen.nests import filled, objects, put, reader
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.product_loops import turned
from gyrostat.codegen.program import Operand
from gyrostat.codegen.views import view_of


def sparse_sum(build: Builder, operation: str, first: Array, second: Array) -> Array | None:
    """Sum or difference, in a copy of one operand; None if the other has few known zeros.

    A sum with a known zero is left out: it would only change the sign of a zero. Where both have
    known zeros, the result has.
    """
    for whole, other in ((first, second), (second, first)):
        if is_plain(whole) or not is_plain(other) or other.shape != whole.shape:
            continue
        part = _used_part(whole)
        if part is not None:
            return _in_part(build, operation, first, second, part)
        scalars = build.scalars(other)
        is_used = used(scalars).ravel()
        runs = [*runs_of(np.flatnonzero(is_used))]
        if 2 * is_used.sum() > is_used.size or len(runs) > build.scope.few:
            continue
        combined = operation
        if operation == "sub" and other is first:
            whole, combined = build.elementwise("neg", "real", whole.shape, whole), "add"
        data = filled(build, whole)
        for places in runs:
            _combine(build, combined, Data(data.table, places), scalars.flat[places])
        return data
    return None


def _used_part(array: Array) -> tuple[NDArray[np.int64], ...] | None:
    """Rows and columns of a matrix with others than known zeros; None if these are all."""
    if not isinstance(array, np.ndarray) or array.ndim != 2:
        return None
    is_used = used(array)
    rows, columns = (np.flatnonzero(is_used.any(axis=axis)) for axis in (1, 0))
    return None if rows.size * columns.size in (0, array.size) else np.ix_(rows, columns)


def _in_part(
    build: Builder, operation: str, first: Array, second: Array, part: tuple[Any, ...]
) -> Scalars:
    """Sum in some rows and columns; elsewhere, one of the operands is 0."""
    left, right = (objects(build, each) for each in (first, second))
    halves: list[Any] = [joined(each[part]) for each in (left, right)]
    rows, columns = halves[0].shape
    # the used columns one after the other: they are the rows that a product adds up
    if columns < rows:
        halves = [turned(each) for each in halves]
    made = sparse_sum(build, operation, *halves)
    if made is None:
        made = build.elementwise(operation, "real", halves[0].shape, *halves)
    made = objects(build, filled(build, made) if isinstance(made, Deferred) else made)
    results = np.empty(left.shape, dtype=object)
    results[part] = made.T if columns < rows else made
    group = next(build.groups)
    for index in np.argwhere(results == np.array(None)):
        place = (*map(int, index),)
        operands = left[place], right[place]
        result = with_zero(operation, operands)
        if result is None:
            result = build.compute(operation, *operands, group=group)
        results[place] = result
    return results


def _combine(build: Builder, operation: str, data: Data, terms: Any) -> None:
    view, at = view_of(data), reader(build, np.array(terms, dtype=object))

    def body(inside: Builder, counters: tuple[Operand, ...]) -> None:
        value = inside.compute(operation, view.at(inside, counters), at(inside, counters))
        put(inside, view, counters, value)

    nest(build, data.shape, body)
