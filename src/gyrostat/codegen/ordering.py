"""Elements compared with each other: the largest, a sorted array, running sums and extremes."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Block, Name, Number, Operand
from gyrostat.codegen.source import Source, refused

if TYPE_CHECKING:
    from gyrostat.codegen.lower import Lowering

_RUNNING = {"cumsum": "add", "cumprod": "mul", "cummax": "max", "cummin": "min"}


def _assigner(lowering: "Lowering", block: Block, where: Source) -> Callable[..., Operand]:
    """A function that appends one operation and returns its result."""
    group = lowering.new_group()

    def new(operation: str, *operands: Operand) -> Operand:
        tests = operation in ("lt", "gt", "eq", "ne", "and", "or")
        kind = "logical" if tests else operands[-1].kind
        return lowering.assigned(block, operation, operands, Name(kind, where.name, group), where)

    return new


def _largest(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """Place of the largest or smallest element along an axis; the first of several, or a NaN."""
    axes = equation.params["axes"]
    if len(axes) != 1:
        raise refused(equation, where, f"{len(axes)} axes", "one")
    rows, new = np.moveaxis(given[0], axes[0], -1), _assigner(lowering, block, where)
    test = "gt" if equation.primitive.name == "argmax" else "lt"
    places = np.empty(rows.shape[:-1], dtype=object)
    for which in np.ndindex(places.shape):
        row = rows[which]
        best, place = row[0], Number("integer", 0)
        for k in range(1, len(row)):
            better = new(test, row[k], best)
            if best.kind == "real":
                fresh = new("and", new("ne", row[k], row[k]), new("eq", best, best))
                better = new("or", better, fresh)
            best = new("select", better, row[k], best)
            place = new("select", better, Number("integer", k), place)
        places[which] = place
    return [places]


def _sorted(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    """Arrays sorted by the first along one axis, by exchanges of neighbours; NaN last."""
    if equation.params["num_keys"] != 1:
        raise refused(equation, where, f"{equation.params['num_keys']} arrays to sort by", "one")
    axis, new = equation.params["dimension"], _assigner(lowering, block, where)
    arrays = [np.moveaxis(array.copy(), axis, -1) for array in given]
    keys = arrays[0]
    for place in np.ndindex(keys.shape[:-1]):
        for sweep in range(keys.shape[-1]):
            for k in range(sweep % 2, keys.shape[-1] - 1, 2):
                low, high = keys[*place, k], keys[*place, k + 1]
                swap = new("gt", low, high)
                if low.kind == "real":
                    numberless = new("and", new("ne", low, low), new("eq", high, high))
                    swap = new("or", swap, numberless)
                for array in arrays:
                    first, second = array[*place, k], array[*place, k + 1]
                    array[*place, k] = new("select", swap, second, first)
                    array[*place, k + 1] = new("select", swap, first, second)
    return [np.moveaxis(array, -1, axis) for array in arrays]


def _running(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """Sums, products or extremes of all elements so far along one axis."""
    operation, params = _RUNNING[equation.primitive.name], equation.params
    rows, new = np.moveaxis(given[0].copy(), params["axis"], 0), _assigner(lowering, block, where)
    if params["reverse"]:
        rows = rows[::-1]
    for k, *place in np.ndindex(rows.shape):
        if k:
            rows[k, *place] = new(operation, rows[k - 1, *place], rows[k, *place])
    rows = rows[::-1] if params["reverse"] else rows
    return [np.moveaxis(rows, 0, params["axis"])]


LOWERED: dict[str, Callable[..., Sequence[Scalars]]] = {
    "argmax": _largest,
    "argmin": _largest,
    "sort": _sorted,
    **dict.fromkeys(_RUNNING, _running),
}
"""Primitive -> (lowering, equation, operands, block, source) -> results."""
