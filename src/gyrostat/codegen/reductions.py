"""Rules for reductions along some axes, such as sums, largest elements and their places."""

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from gyrostat.codegen.arrays import Array, Data, is_plain, moved
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import accumulated, carried, nest
from gyrostat.codegen.nests import declared, put, reader, settled
from gyrostat.codegen.program import Kind, Number, Operand
from gyrostat.codegen.views import view_of

LONGEST = 256
"""Largest number of scalars whose reduction is written out."""
PLACE = 6
"""Operations of an element where the place of the largest one is sought."""
_START: dict[str, dict[Kind, float | int | bool]] = {
    "add": {"real": 0.0, "integer": 0, "bits": 0},
    "mul": {"real": 1.0, "integer": 1, "bits": 1},
    "max": {"real": -math.inf, "integer": -(2**63), "bits": 0, "logical": False},
    "min": {"real": math.inf, "integer": 2**63 - 1, "bits": 2**64 - 1, "logical": True},
    "and": {"logical": True, "integer": -1, "bits": 2**64 - 1},
    "or": {"logical": False, "integer": 0, "bits": 0},
    "xor": {"logical": False, "integer": 0, "bits": 0},
}
"""Operation -> kind -> number that changes no other number."""


def _reduction(operation: str) -> Callable[..., Array]:
    """Rule for a reduction, from the first element to the last."""

    def rule(build: Builder, array: Array) -> Array:
        axes = build.params["axes"]
        kept = [axis for axis in range(array.ndim) if axis not in axes]
        shape = *(array.shape[k] for k in kept), math.prod(array.shape[k] for k in axes)
        move = moved(lambda _, each: [each.transpose([*kept, *axes]).reshape(shape)], {}, array)
        rows, kind = move[0], build.scope.kind(build.target)
        longest = LONGEST if is_plain(array) else build.scope.written
        if array.size <= longest or kind not in _START[operation]:
            return _written(build, operation, rows)
        return _looped(build, operation, rows, Number(kind, _START[operation][kind]))

    return rule


def _written(build: Builder, operation: str, rows: Array) -> Array:
    scalars = build.scalars(rows)
    results = np.empty(rows.shape[:-1], dtype=object)
    for position in np.ndindex(results.shape):
        results[position] = build.fold(operation, list(scalars[position]))
    return results


def _looped(build: Builder, operation: str, rows: Array, start: Number) -> Array:
    at = reader(build, rows)

    def total(inside: Builder, counters: tuple[Operand, ...]) -> Operand:
        def step(within: Builder, inner: tuple[Operand, ...], so_far: Operand) -> Operand:
            return within.compute(operation, so_far, at(within, (*counters, *inner)))

        return accumulated(inside, rows.shape[-1:], start, step, depth=len(counters))

    if math.prod(rows.shape[:-1]) == 1:
        position = (Number("index", 0),) * (rows.ndim - 1)
        return np.array(total(build, position), dtype=object).reshape(rows.shape[:-1])
    return _by_row(build, start.kind, rows.shape[:-1], total)


def _by_row(
    build: Builder,
    kind: Kind,
    shape: tuple[int, ...],
    result: Callable[[Builder, tuple[Operand, ...]], Operand],
) -> Array:
    """Array of the results of loops: (builder, counters) -> result."""
    table = declared(build, kind, math.prod(shape))
    data = Data(table, np.arange(table.size).reshape(shape))
    view = view_of(data)
    nest(
        build,
        data.shape,
        lambda inside, counters: put(inside, view, counters, result(inside, counters)),
    )
    return settled(build, data)


def _place(test: str) -> Callable[..., Array]:
    """Rule for the index of the largest or smallest element: the first if several, or a NaN."""

    def rule(build: Builder, array: Array) -> Array:
        axes = build.params["axes"]
        if len(axes) != 1:
            raise build.refused(f"{len(axes)} axes", "one")
        order = [*(k for k in range(array.ndim) if k != axes[0]), axes[0]]
        rows = moved(lambda _, each: [each.transpose(order)], {}, array)[0]
        longest = LONGEST if is_plain(array) else build.scope.written
        if array.size * PLACE <= longest:
            return _place_written(build, test, rows)
        return _place_looped(build, test, rows)

    return rule


def _place_written(build: Builder, test: str, rows: Array) -> Array:
    scalars, group = build.scalars(rows), next(build.groups)
    indices = np.empty(rows.shape[:-1], dtype=object)
    for position in np.ndindex(indices.shape):
        row = scalars[position]
        best, index = row[0], Number("integer", 0)
        for k in range(1, len(row)):
            better = _is_better(build, test, row[k], best, group)
            best = build.compute("select", better, row[k], best, group=group)
            index = build.compute("select", better, Number("integer", k), index, group=group)
        indices[position] = index
    return indices


def _place_looped(build: Builder, test: str, rows: Array) -> Array:
    at, one = reader(build, rows), Number("index", 1)

    def place(inside: Builder, counters: tuple[Operand, ...]) -> Operand:
        def step(
            within: Builder, counter: Operand, found: tuple[Operand, ...]
        ) -> tuple[Operand, ...]:
            best, index = found
            element, number = at(within, (*counters, counter)), within.as_integer(counter)
            better = _is_better(within, test, element, best)
            select = partial(within.compute, "select", better)
            return select(element, best), select(number, index)

        first = at(inside, (*counters, Number("index", 0))), Number("integer", 0)
        return carried(inside, rows.shape[-1], first, step, len(counters), one)[1]

    if math.prod(rows.shape[:-1]) == 1:
        position = (Number("index", 0),) * (rows.ndim - 1)
        return np.array(place(build, position), dtype=object).reshape(rows.shape[:-1])
    return _by_row(build, "integer", rows.shape[:-1], place)


def _is_better(
    build: Builder, test: str, element: Operand, best: Operand, group: int | None = None
) -> Operand:
    """Whether an element is above, or below, the best one so far, or the first NaN."""
    new = partial(build.compute, group=group)
    if best.kind == "logical":  # C orders no truth values
        high, low = (element, best) if test == "gt" else (best, element)
        return new("and", high, new("not", low))
    better = new(test, element, best)
    if best.kind != "real":
        return better
    first_nan = new("and", new("ne", element, element), new("eq", best, best))
    return new("or", better, first_nan)


RULES: dict[str, Callable[..., Array | Sequence[Array]]] = {
    "argmax": _place("gt"),
    "argmin": _place("lt"),
    "reduce_and": _reduction("and"),
    "reduce_max": _reduction("max"),
    "reduce_min": _reduction("min"),
    "reduce_or": _reduction("or"),
    "reduce_prod": _reduction("mul"),
    "reduce_sum": _reduction("add"),
    "reduce_xor": _reduction("xor"),
}
"""Primitive -> (builder, operand) -> result."""
