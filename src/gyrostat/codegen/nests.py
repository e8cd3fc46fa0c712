"""Tables filled by loops, from deferred operations and arrays of scalars and elements."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import (
    SMALL,
    Array,
    Data,
    Deferred,
    has_elements,
    joined,
    leaves,
    moved,
    of_caller,
)
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import nest
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import (
    Fill,
    Kind,
    Name,
    Number,
    Operand,
    Store,
    Table,
)
from gyrostat.codegen.regions import identities, regions
from gyrostat.codegen.views import Leaf, Ramp, Same, View, merged, regular, view_of


def declared(build: Builder, kind: Kind, size: int, *, changes: bool = False) -> Table:
    """Table that the following statements fill."""
    table = Table(kind, size, build.where.name, changes=changes)
    build.block.append(Fill(table, (), build.where))
    return table


def filled(build: Builder, array: Array, *, changes: bool = False) -> Data:
    """Array as data of a table of its own; loops fill it.

    Args:
        build: Builder.
        array: Array.
        changes: See `Table`.
    """
    table = declared(build, kind_of(array), array.size, changes=changes)
    data = Data(table, np.arange(array.size).reshape(array.shape))
    store(build, array, data)
    return data


def kind_of(array: Array) -> Kind:
    """Kind of number of an array that is not empty."""
    if isinstance(array, Data):
        return array.table.kind
    return array.kind if isinstance(array, Deferred) else array.flat[0].kind


def settled(build: Builder, array: Array) -> Scalars | Data:
    """Array without deferred operations; a small one as scalars."""
    is_known = isinstance(array, Data) and bool(
        array.table.values or array.table.memory or array.table.shape
    )
    if array.size <= (build.scope.few if not is_known else build.scope.known):
        return build.scalars(array)
    return filled(build, array) if isinstance(array, Deferred) else array


def objects(build: Builder, array: Array) -> Scalars:
    """Array of scalars and elements of tables."""
    array = settled(build, array)
    if not isinstance(array, Data):
        return array
    return (filled(build, array) if array.base is not None else array).elements()


def placed(build: Builder, array: Array) -> Data:
    """Array as data with constant distances, on the only axis of a table."""
    if isinstance(array, np.ndarray) and not has_elements(array):
        array = of_caller(array)
    if isinstance(array, Data) and len(array.table.shape) < 2 and array.strides() is not None:
        return array
    if isinstance(array, np.ndarray) and not has_elements(array):
        return build.listed(array)
    return filled(build, array)


def rearranged(build: Builder, move: Callable[..., Any], arrays: Sequence[Array]) -> list[Array]:
    """Results of a primitive that moves elements."""
    if len(arrays) == 1:
        (array,) = arrays
        if isinstance(array, Deferred) and build.size > array.size:
            array = filled(build, array)
        results = moved(move, build.params, array)
    else:
        results = [
            joined(np.asarray(each, dtype=object))
            for each in move(build.params, *(objects(build, array) for array in arrays))
        ]
    few = build.scope.few
    return [
        each if isinstance(each, Deferred) and each.size > few else settled(build, each)
        for each in results
    ]


def store(build: Builder, array: Array, target: Data) -> None:
    """Append loops that assign the elements of an array to places of a table.

    Args:
        build: Builder.
        array: Array.
        target: Places, with constant distances.
    """
    if isinstance(array, np.ndarray) and has_elements(array):
        _store_mixed(build, array, target)
        return
    if isinstance(array, np.ndarray) and _is_listed(array, target):
        for value, place in zip(array.flat, target.places.flat, strict=True):
            position = build.index("add", target.base, Number("index", int(place)))
            build.block.append(Store(target.table, (position,), value, build.where))
        return
    parts = {id(leaf): leaf for leaf in leaves(array)}
    views = [view_of(target), *(_leaf(build, leaf) for leaf in parts.values())]
    counts, (destination, *sources) = merged(array.shape, views)
    by_leaf = dict(zip(parts, sources, strict=True))
    assert isinstance(destination, View)

    def body(inside: Builder, counters: tuple[Operand, ...]) -> None:
        value = _value(inside, array, by_leaf, counters, {})
        put(inside, destination, counters, value)

    nest(build, counts, body)


def _is_listed(array: Scalars, target: Data) -> bool:
    """Whether scalars are stored one by one, because they have nothing in common."""
    if target.table.shape or 0 in array.strides or array.size > SMALL:
        return False
    is_known = all(isinstance(each, Number) for each in array.flat)
    return not is_known and isinstance(of_caller(array), np.ndarray)


def put(build: Builder, view: View, counters: Sequence[Operand], value: Operand) -> None:
    """Append the assignment of the element of a view that counters give."""
    build.block.append(Store(view.table, view.indices(build, counters), value, build.where))


def reader(build: Builder, array: Array) -> Callable[[Builder, tuple[Operand, ...]], Operand]:
    """Function (builder, counters) -> element of an array, for loops that follow."""
    by_leaf = {id(leaf): _leaf(build, leaf) for leaf in leaves(array)}
    return lambda inside, counters: _value(inside, array, by_leaf, counters, {})


def _value(
    build: Builder,
    array: Array,
    by_leaf: dict[int, Leaf],
    counters: tuple[Operand, ...],
    done: dict[Hashable, Operand],
) -> Operand:
    """Element of an array, computed in a loop."""
    if id(array) not in done:
        if not isinstance(array, Deferred):
            leaf = by_leaf[id(array)]
            # two arrays may be the same part of a table
            key = leaf if isinstance(leaf, View) else id(array)
            if key not in done:
                done[key] = leaf.at(build, counters)
            return done[key]
        operands = [_value(build, each, by_leaf, counters, done) for each in array.operands]
        inside = replace(build, where=array.source)
        name = Name(array.kind, array.source.name, next(build.groups))
        done[id(array)] = inside.assign(array.operation, operands, name)
    return done[id(array)]


def _leaf(build: Builder, array: Scalars | Data) -> Leaf:
    """Array with constant steps between its elements; it is copied to a table if it has none."""
    if isinstance(array, Data):
        view = regular(array)
        if view is not None:
            return view
        if array.table.shape:
            every = np.arange(array.table.size).reshape(array.table.shape)
            copy = filled(build, Data(array.table, every))
            return _leaf(build, Data(copy.table, array.places))
        return view_of(filled(build, _without_base(build, array)))
    if not array.ndim:
        return Same(build.scalars(array).item(), ())
    # axes along which all elements are the same
    thin = array[tuple(slice(0, 1) if step == 0 else slice(None) for step in array.strides)]
    ids = identities(thin)
    for axis in range(thin.ndim):
        if np.all(ids == ids.take([0], axis)):
            ids, thin = ids.take([0], axis), thin.take([0], axis)
    repeated = [length == 1 for length in thin.shape]
    if thin.size == 1:
        operand = build.scalars(thin.reshape(())).item()
        return Same(operand, ((0,),) * array.ndim)
    ramp = _ramp(thin)
    if ramp is not None:
        return ramp
    data = joined(thin) if has_elements(thin) else of_caller(thin)
    view = regular(data) if isinstance(data, Data) else None
    if view is None:
        view = view_of(_table(build, thin))
    nothing = (0,) * len(view.offset)
    pairs = zip(view.steps, repeated, strict=True)
    return replace(view, steps=tuple(nothing if same else step for step, same in pairs))


def _ramp(array: Scalars) -> Ramp | None:
    """Integers with constant steps; None for other arrays."""
    first = array.flat[0]
    if first.kind != "integer" or not all(isinstance(each, Number) for each in array.flat):
        return None
    values = np.vectorize(lambda number: number.value, otypes=[object])(array).astype(np.int64)
    steps = Data(Table("integer", 0), values).strides()
    return None if steps is None else Ramp("integer", first.value, tuple((s,) for s in steps))


def _table(build: Builder, array: Scalars) -> Data:
    """Array as data of a table: constant, written out, or filled by loops."""
    if has_elements(array):
        return filled(build, array)
    return build.listed(array)


def _without_base(build: Builder, data: Data) -> Scalars:
    """Elements of data without constant distances, each read at its place."""
    if data.base is None:
        return data.elements()
    names = np.empty(data.shape, dtype=object)
    for position, place in np.ndenumerate(data.places):
        name = Name(data.table.kind, build.where.name, next(build.groups))
        names[position] = build.element(data.table, data.base, int(place), name)
    return names


def _store_mixed(build: Builder, array: Scalars, target: Data) -> None:
    """Append the assignment of scalars and elements: a loop for each regular part."""
    places = target.places
    parts = regions(array)
    zero = Number(kind_of(array), False if kind_of(array) == "logical" else 0.0)
    zeros = [part for part in parts if array[part].size and array[part].flat[0] == zero]
    if len(zeros) > 1:
        store(build, np.broadcast_to(np.array(zero, dtype=object), array.shape), target)
        parts = [part for part in parts if array[part].flat[0] != zero]
    for part in parts:
        inner = joined(array[part])
        store(build, inner, Data(target.table, places[part], target.base))
