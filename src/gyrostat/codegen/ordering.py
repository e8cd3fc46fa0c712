"""Rules for ordering operations: sorting, cumulative sums and extremes."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import Array, Data, moved
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import nest
from gyrostat.codegen.nests import filled, put, settled
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Operand
from gyrostat.codegen.views import view_of


def _sort(build: Builder, *operands: Array) -> Sequence[Array]:
    """Sort arrays by the first ones along one axis, by exchanges of neighbours; NaN last.

    In turn, the pairs that begin at even and at odd places; as many sweeps as elements sort them.
    """
    axis, keys = build.params["dimension"], build.params["num_keys"]
    turned = [
        moved(lambda _, each: [np.moveaxis(each, axis, -1)], {}, each)[0] for each in operands
    ]
    *rows, length = turned[0].shape
    exchanges = math.prod(rows) * length * (length - 1) // 2
    in_order = _written_out if exchanges <= build.scope.written else _in_loops
    results = in_order(build, turned, keys)
    return [moved(lambda _, each: [np.moveaxis(each, -1, axis)], {}, each)[0] for each in results]


def _written_out(build: Builder, arrays: Sequence[Array], keys: int) -> Sequence[Array]:
    sorted_arrays = [build.scalars(array).copy() for array in arrays]
    group = next(build.groups)
    *rows, length = sorted_arrays[0].shape
    for position in np.ndindex(*rows):
        for sweep in range(length):
            for k in range(sweep % 2, length - 1, 2):
                low, high = (*position, k), (*position, k + 1)
                pairs = [(array[low], array[high]) for array in sorted_arrays]
                exchanged = _exchanged(build, pairs, keys, group)
                for array, pair in zip(sorted_arrays, exchanged, strict=True):
                    array[low], array[high] = pair
    return sorted_arrays


def _in_loops(build: Builder, arrays: Sequence[Array], keys: int) -> Sequence[Array]:
    tables = [filled(build, array) for array in arrays]

    def sweeps(inside: Builder, _: tuple[Operand, ...]) -> None:
        for first in (0, 1):
            lows = [Data(each.table, each.places[..., first:-1:2]) for each in tables]
            highs = [Data(each.table, each.places[..., first + 1 :: 2]) for each in tables]
            if lows[0].size:  # a row of two has no pair that begins at an odd place
                nest(inside, lows[0].shape, partial(exchange, lows, highs), depth=1)

    def exchange(
        lows: list[Data], highs: list[Data], within: Builder, counters: tuple[Operand, ...]
    ) -> None:
        views = [(view_of(low), view_of(high)) for low, high in zip(lows, highs, strict=True)]
        pairs = [(low.at(within, counters), high.at(within, counters)) for low, high in views]
        exchanged = _exchanged(within, pairs, keys, next(within.groups))
        for (low, high), (first, second) in zip(views, exchanged, strict=True):
            put(within, low, counters, first)
            put(within, high, counters, second)

    nest(build, [(arrays[0].shape[-1] + 1) // 2], sweeps)
    return [settled(build, each) for each in tables]


def _exchanged(
    build: Builder, pairs: Sequence[tuple[Operand, Operand]], keys: int, group: int
) -> list[tuple[Operand, Operand]]:
    """Pairs of neighbours, exchanged if the first is above the second by the keys."""
    new = partial(build.compute, group=group)

    def above(first: Operand, second: Operand) -> Operand:
        larger = new("gt", first, second)
        if first.kind != "real":
            return larger
        numberless = new("and", new("ne", first, first), new("eq", second, second))
        return new("or", larger, numberless)

    *earlier, last = pairs[:keys]
    swap = above(*last)
    for low, high in reversed(earlier):
        swap = new("or", above(low, high), new("and", new("not", above(high, low)), swap))
    return [(new("select", swap, *pair[::-1]), new("select", swap, *pair)) for pair in pairs]


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


OF_ARRAYS = frozenset({"sort"})
"""Primitives whose rules take large arrays as they are."""
RULES: dict[str, Callable[..., Sequence[Array]]] = {
    "cummax": _cumulative("max"),
    "cummin": _cumulative("min"),
    "cumprod": _cumulative("mul"),
    "cumsum": _cumulative("add"),
    "sort": _sort,
}
"""Primitive -> (builder, operands) -> results."""
