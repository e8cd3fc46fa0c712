"""Sums of a matrix and one with mostly known zeros, such as a diagonal one."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import Array, Data, is_plain
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import nest
from gyrostat.codegen.nests import filled, put, reader
from gyrostat.codegen.program import Number, Operand
from gyrostat.codegen.views import view_of

ZERO = Number("real", 0.0)


def sparse_sum(build: Builder, operation: str, first: Array, second: Array) -> Data | None:
    """Sum or difference, in a copy of one operand; None if the other has few known zeros.

    A sum with a known zero is left out: it would only change the sign of a zero.
    """
    for whole, other in ((first, second), (second, first)):
        if is_plain(whole) or not is_plain(other) or other.shape != whole.shape:
            continue
        scalars = build.scalars(other)
        is_used = np.array([each != ZERO for each in scalars.flat], bool)
        runs = [*_runs(np.flatnonzero(is_used))]
        if 2 * is_used.sum() > is_used.size or len(runs) > build.scope.few:
            continue
        combined = operation
        if operation == "sub" and other is first:
            whole, combined = build.elementwise("neg", "real", build.shape, whole), "add"
        data = filled(build, whole)
        for places in runs:
            _combine(build, combined, Data(data.table, places), scalars.flat[places])
        return data
    return None


def _combine(build: Builder, operation: str, data: Data, terms: Any) -> None:
    view, at = view_of(data), reader(build, np.array(terms, dtype=object))

    def body(inside: Builder, counters: tuple[Operand, ...]) -> None:
        value = inside.compute(operation, view.at(inside, counters), at(inside, counters))
        put(inside, view, counters, value)

    nest(build, data.shape, body)


def _runs(places: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Places in runs of constant distance."""
    start = 0
    while start < len(places):
        end = min(start + 2, len(places))
        step = places[end - 1] - places[start]
        while end < len(places) and places[end] - places[end - 1] == step:
            end += 1
        yield places[start:end]
        start = end
