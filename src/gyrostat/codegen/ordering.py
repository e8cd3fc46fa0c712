"""Rules for ordering operations: sorting, cumulative sums and extremes."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from gyrostat.codegen.builder import Builder
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Operand


def _sort(build: Builder, *operands: Scalars) -> Sequence[Scalars]:
    """Sort arrays by the first ones along one axis, by exchanges of neighbours; NaN last."""
    axis, new = build.params["dimension"], partial(build.compute, group=next(build.groups))
    arrays = [np.moveaxis(array.copy(), axis, -1) for array in operands]
    keys = arrays[: build.params["num_keys"]]

    def above(first: Operand, second: Operand) -> Operand:
        larger = new("gt", first, second)
        if first.kind != "real":
            return larger
        numberless = new("and", new("ne", first, first), new("eq", second, second))
        return new("or", larger, numberless)

    def swapped(low: tuple[int, ...], high: tuple[int, ...]) -> Operand:
        swap = above(keys[-1][low], keys[-1][high])
        for key in reversed(keys[:-1]):
            tied = new("not", above(key[high], key[low]))
            swap = new("or", above(key[low], key[high]), new("and", tied, swap))
        return swap

    *rows, length = keys[0].shape
    for position in np.ndindex(*rows):
        for sweep in range(length):
            for k in range(sweep % 2, length - 1, 2):
                low, high = (*position, k), (*position, k + 1)
                swap = swapped(low, high)
                for array in arrays:
                    first, second = array[low], array[high]
                    array[low] = new("select", swap, second, first)
                    array[high] = new("select", swap, first, second)
    return [np.moveaxis(array, -1, axis) for array in arrays]


def _cumulative(operation: str) -> Callable[..., Sequence[Scalars]]:
    """Rule for the cumulative sum, product or extreme along one axis."""

    def rule(build: Builder, array: Scalars) -> Sequence[Scalars]:
        group, params = next(build.groups), build.params
        rows = np.moveaxis(array.copy(), params["axis"], 0)
        rows = rows[::-1] if params["reverse"] else rows
        for k, *position in np.ndindex(rows.shape):
            if k:
                pair: Any = rows[k - 1, *position], rows[k, *position]
                rows[k, *position] = build.compute(operation, *pair, group=group)
        return [np.moveaxis(rows[::-1] if params["reverse"] else rows, 0, params["axis"])]

    return rule


RULES: dict[str, Callable[..., Sequence[Scalars]]] = {
    "cummax": _cumulative("max"),
    "cummin": _cumulative("min"),
    "cumprod": _cumulative("mul"),
    "cumsum": _cumulative("add"),
    "sort": _sort,
}
"""Primitive -> (builder, operands) -> results."""
