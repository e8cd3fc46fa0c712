"""Rules for replacing elements at constant or computed indices."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import SMALL, Array, Data, is_plain, joined, moved
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.indexing import ZERO, Pick, Windows, inside_limits
from gyrostat.codegen.jax_versions import closed
from gyrostat.codegen.loops import nest
from gyrostat.codegen.nests import filled, objects, put, reader, settled
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Name, Number, Operand
from gyrostat.codegen.views import view_of


def _combine(
    build: Builder,
    arrays: Sequence[Array],
    windows: Windows,
    join: Callable[[Builder, Any, Any], Operand],
    *,
    clipped: bool,
) -> Array:
    """Array with some parts combined with other arrays, at computed indices."""
    array, indices, updates = arrays[0], build.scalars(arrays[1]), arrays[2]
    limits = list(array.shape)
    for axis, k in zip(windows.kept, windows.axes, strict=True):
        limits[axis] -= updates.shape[k] - 1
    is_known = all(isinstance(each, Number) for each in indices.flat)
    if is_known or array.size <= (SMALL if is_plain(array) else build.scope.few):
        scalars = objects(build, array), indices, objects(build, updates)
        return settled(build, joined(_selected(build, scalars, windows, join, limits, clipped)))
    return _stored(build, (array, indices, updates), windows, join, limits, clipped)


def _stored(
    build: Builder,
    arrays: tuple[Array, Scalars, Array],
    windows: Windows,
    join: Callable[[Builder, Any, Any], Operand],
    limits: Sequence[int],
    clipped: bool,
) -> Data:
    """Copy of an array, with parts set at computed indices."""
    array, indices, updates = arrays
    data, updates = filled(build, array), settled(build, updates)
    axes, shape = data.ndim, updates.shape
    sizes = [length - limit + 1 for length, limit in zip(data.shape, limits, strict=True)]
    pick = Pick(build, data, sizes)
    rows = [k for k in range(len(shape)) if k not in windows.axes]
    for row in np.ndindex(*(shape[k] for k in rows)):
        starts = windows.starts(row, indices, axes)
        last = [limit - 1 for limit in limits]
        inside = Number("logical", True) if clipped else inside_limits(build, starts, last)
        # with the ellipsis, a single element is an array without axes
        selected: list[Any] = [*[slice(None)] * len(shape), ...]
        for k, number in zip(rows, row, strict=True):
            selected[k] = number
        update = moved(lambda _, each, at=tuple(selected): [each[at]], {}, updates)[0]
        part = pick.part(pick.base(build, starts))
        target = Data(part.table, part.places.reshape(update.shape), part.base)
        _combined(build, target, update, inside, join)
    return data


def _combined(
    build: Builder,
    target: Data,
    update: Array,
    inside: Operand,
    join: Callable[[Builder, Any, Any], Operand],
) -> None:
    view, at = view_of(target), reader(build, update)

    def body(within: Builder, counters: tuple[Operand, ...]) -> None:
        old = view.at(within, counters)
        new = join(within, old, at(within, counters))
        name = Name(new.kind, within.where.name, next(within.groups))
        put(within, view, counters, within.assign("select", (inside, new, old), name))

    nest(build, target.shape, body)


def _selected(
    build: Builder,
    arrays: tuple[Scalars, Scalars, Scalars],
    windows: Windows,
    join: Callable[[Builder, Any, Any], Operand],
    limits: Sequence[int],
    clipped: bool,
) -> Scalars:
    """Array with each element that an index can refer to selected by a test of the index.

    If the index is known beforehand, so are the tests, and no code is generated for them.
    """
    array, indices, updates = arrays
    result = array.copy()

    def tests(row: tuple[int, ...]) -> list[list[Operand]]:
        axis_tests = []
        starts = map(build.signed, windows.starts(row, indices, array.ndim))
        for start, limit in zip(starts, limits, strict=True):
            index = build.clamp(start, ZERO, Number("integer", limit - 1)) if clipped else start
            numbers = (Number("integer", k) for k in range(limit))
            axis_tests.append(
                [build.compute("eq", index, number, hint="chosen") for number in numbers]
            )
        return axis_tests

    row_tests: dict[tuple[int, ...], list[list[Operand]]] = {}
    group = next(build.groups)
    for position, row, offset in windows.places(updates.shape, array.ndim):
        if row not in row_tests:
            row_tests[row] = tests(row)
        for cell in np.ndindex(*limits):
            is_target: Operand = Number("logical", True)
            for axis, k in enumerate(cell):
                is_target = build.compute("and", is_target, row_tests[row][axis][k], hint="chosen")
            if is_target == Number("logical", False):
                continue
            target = tuple(k + step for k, step in zip(cell, offset, strict=True))
            old: Any = result[target]
            new = join(build, old, updates[position])
            if is_target != Number("logical", True):
                name = Name(new.kind, build.where.name, group, target)
                choice = is_target, build.scalar(new), build.scalar(old)
                new = build.assign("select", choice, name)
            result[target] = new
    return result


def _scatter(build: Builder, *arrays: Array) -> Array:
    """Array with some parts replaced or combined with others; parts outside it are ignored."""
    params, count = build.params, arrays[0].ndim
    dimensions = params["dimension_numbers"]
    batched = dimensions.operand_batching_dims
    skipped_axes = (*dimensions.inserted_window_dims, *batched)
    windows = Windows(
        dimensions.update_window_dims,
        [k for k in range(count) if k not in skipped_axes],
        {axis: k for k, axis in enumerate(dimensions.scatter_dims_to_operand_dims)},
        dict(zip(batched, dimensions.scatter_indices_batching_dims, strict=True)),
    )

    def join(inside: Builder, old: Any, update: Any) -> Any:
        if params["update_jaxpr"] is None:
            return update
        inner = closed(params["update_jaxpr"], params["update_consts"])
        operands = [np.array(inside.scalar(each), dtype=object) for each in (old, update)]
        (result,) = inside.lower(inner, operands, inside.block, inside.where)
        return inside.scalars(result).item()

    return _combine(build, arrays, windows, join, clipped="CLIP" in str(params["mode"]))


def _dynamic_update(build: Builder, array: Array, updates: Array, *starts: Array) -> Array:
    """Array with the part that starts at computed indices replaced."""
    axes = range(array.ndim)
    windows = Windows(tuple(axes), list(axes), {axis: axis for axis in axes}, {})
    indices = np.array([build.scalars(start).item() for start in starts], dtype=object)
    return _combine(
        build, (array, indices, updates), windows, lambda _, old, update: update, clipped=True
    )


RULES: dict[str, Callable[..., Array]] = {
    "dynamic_update_slice": _dynamic_update,
    "scatter": _scatter,
    **{
        f"scatter{mark}{operation}": _scatter
        for mark in "-_"
        for operation in ("add", "sub", "mul", "min", "max")
    },
}
