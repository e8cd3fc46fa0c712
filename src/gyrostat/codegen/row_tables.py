"""Tables that loops over rows set, where scalars of rows meet other arrays."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import Element
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Block, Name, Operand, Table
from gyrostat.codegen.rows import Row, RowLoop
from gyrostat.codegen.source import Source
from gyrostat.codegen.views import index


def has_rows(array: Any) -> bool:
    """Whether an array has scalars of rows."""
    return isinstance(array, np.ndarray) and any(isinstance(each, Row) for each in array.flat)


def settled_rows(build: Builder, array: Any) -> Any:
    """Array with scalars of rows as elements of a table that their loops set."""
    if not has_rows(array):
        return array
    if not array.ndim:
        return settled_rows(build, array.reshape(1)).reshape(())
    array = _stored(array)
    if not has_rows(array):
        return array
    is_row = np.array([isinstance(each, Row) for each in array.flat], bool).reshape(array.shape)
    kept = [
        np.flatnonzero(is_row.any(axis=(*range(k), *range(k + 1, array.ndim))))
        for k in range(array.ndim)
    ]
    box = array[np.ix_(*kept)]
    places = np.arange(box.size).reshape(box.shape)
    table = Table(array[is_row][0].kind, box.size, build.where.name)
    results, columns = box.copy(), {}
    for place, each in zip(places.flat, box.flat, strict=True):
        if isinstance(each, Row):
            columns.setdefault((each.loop, each.name), []).append((each.number, int(place)))
    build.memo.closings.append(array)
    closed: list[RowLoop] = []
    for (loop, name), pairs in columns.items():
        ramp = _ramp(loop, pairs)
        if ramp is None:
            own = loop.table(name)
            for number, place in pairs:
                results.flat[place] = Element(own, number)
            continue
        loop.close()
        closed.append(loop)
        loop.store(name, table, partial(_place, build, loop.loop.counter, ramp))
        loop.places[name] = table, *ramp
        for _, place in pairs:
            results.flat[place] = Element(table, place)
    if closed:
        first = min(closed, key=lambda loop: _position(loop))
        first.declare(table, build.where)
    whole = array.copy()
    whole[np.ix_(*kept)] = results
    return whole


def _place(
    build: Builder, counter: Name, ramp: tuple[int, int], block: Block, source: Source
) -> Operand:
    """Append the computation of the index of a row to a block."""
    return index(replace(build, block=block, where=source), None, ramp[0], (counter,), ramp[1:])


def _stored(array: Scalars) -> Scalars:
    """Array with those scalars of rows as elements that tables have already."""
    results = array.copy()
    for place, each in np.ndenumerate(array):
        if isinstance(each, Row) and each.name in each.loop.places:
            table, first, step = each.loop.places[each.name]
            results[place] = Element(table, first + step * each.number)
    return results


def _position(loop: RowLoop) -> int:
    return next(k for k, each in enumerate(loop.block) if each is loop.loop)


def _ramp(loop: RowLoop, pairs: list[tuple[int, int]]) -> tuple[int, int] | None:
    """First place and distance of the places of all passes; None if they are not so."""
    pairs = sorted(pairs)
    if [number for number, _ in pairs] != list(range(loop.loop.count)):
        return None
    places = np.array([place for _, place in pairs])
    steps = np.diff(places)
    return (int(places[0]), int(steps[0])) if np.all(steps == steps[0]) else None
