"""Rules for reductions along some axes, such as sums and largest elements."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from gyrostat.codegen.arrays import Array, Data, is_plain, moved
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import accumulated, nest
from gyrostat.codegen.nests import declared, put, reader, settled
from gyrostat.codegen.program import Kind, Number, Operand
from gyrostat.codegen.views import view_of

LONGEST = 256
"""Largest number of scalars whose reduction is written out."""
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
    table = declared(build, start.kind, math.prod(rows.shape[:-1]))
    data = Data(table, np.arange(table.size).reshape(rows.shape[:-1]))
    view = view_of(data)
    nest(
        build,
        data.shape,
        lambda inside, counters: put(inside, view, counters, total(inside, counters)),
    )
    return settled(build, data)


RULES: dict[str, Callable[..., Array | Sequence[Array]]] = {
    "reduce_and": _reduction("and"),
    "reduce_max": _reduction("max"),
    "reduce_min": _reduction("min"),
    "reduce_or": _reduction("or"),
    "reduce_prod": _reduction("mul"),
    "reduce_sum": _reduction("add"),
    "reduce_xor": _reduction("xor"),
}
"""Primitive -> (builder, operand) -> result."""
