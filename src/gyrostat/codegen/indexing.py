"""Rules for reading and replacing elements at constant or computed indices."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from gyrostat.codegen.builder import Builder
from gyrostat.codegen.data import Data
from gyrostat.codegen.jax_versions import closed
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Name, Number, Operand

ZERO = Number("integer", 0)


class _Base(NamedTuple):
    """Position in a table: the sum of a computed and a known index."""

    computed: Operand
    known: int


class _Pick:
    """Array with elements read at a computed index, which is clamped to the array."""

    def __init__(self, build: Builder, array: Scalars | Data, sizes: Sequence[int]) -> None:
        self._build, self._array, self._sizes = build, array, sizes
        self._table, self._first, self._strides = build.table(array)

    def base(self, starts: Sequence[Operand]) -> _Base:
        """Position in the table of the first element of the part that starts at some indices."""
        base: Operand = ZERO
        offset = self._first
        for axis, start in enumerate(map(self._build.signed, starts)):
            last = Number("integer", self._array.shape[axis] - self._sizes[axis])
            step = self._build.clamp(start, ZERO, last)
            if self._table.memory and isinstance(step, Number):
                offset += int(step.value) * self._strides[axis]
                continue
            if self._strides[axis] != 1:
                stride = Number("integer", self._strides[axis])
                step = self._build.compute("mul", step, stride, hint="index")
            base = step if base == ZERO else self._build.compute("add", base, step, hint="index")
        return _Base(base, offset)

    def element(self, base: _Base, offset: Sequence[int], name: Name) -> Operand:
        """Element of that part at an offset from its start."""
        steps = sum(step * stride for step, stride in zip(offset, self._strides, strict=True))
        return self._build.element(self._table, base.computed, base.known + steps, name)


class _Windows(NamedTuple):
    """Layout of the windows that a gather reads from an operand or a scatter writes to it.

    Attributes:
        axes: Axes of the array of windows that run inside a window.
        kept: Axes of the operand that correspond to `axes`, in order.
        started: Axis of the operand -> column of the indices that holds the window's start.
        batched: Axis of the operand -> axis of the indices, the position on which is the start.
    """

    axes: tuple[int, ...]
    kept: list[int]
    started: dict[int, int]
    batched: dict[int, int]

    def starts(self, row: tuple[int, ...], indices: Scalars, count: int) -> list[Operand]:
        """Start of the window for one row of indices, on each axis of the operand."""
        starts: list[Operand] = [ZERO] * count
        for axis, column in self.started.items():
            starts[axis] = indices[(*row, column)]
        for axis, index_axis in self.batched.items():
            starts[axis] = Number("integer", row[index_axis])
        return starts

    def places(self, shape: tuple[int, ...], count: int) -> Iterator[tuple[Any, Any, list[int]]]:
        """For each element of the array of windows: its position, row of indices and offset."""
        for position in np.ndindex(shape):
            row = tuple(p for k, p in enumerate(position) if k not in self.axes)
            offset = [0] * count
            for axis, k in zip(self.kept, self.axes, strict=True):
                offset[axis] = position[k]
            yield position, row, offset


def _fill_value(params: dict[str, Any], dtype: Any) -> Any:
    """Value of elements outside the array; None if the index is clamped instead."""
    if "FILL" not in str(params["mode"]):
        return None
    if params["fill_value"] is not None:
        return np.asarray(params["fill_value"], dtype).item()
    if np.issubdtype(dtype, np.integer):
        limits = np.iinfo(dtype)
        return int(limits.min or limits.max)
    return dtype == np.bool_ or np.nan


def _inside(build: Builder, starts: Sequence[Operand], limits: Sequence[int]) -> Operand:
    """Whether a part that starts at the given indices lies within the array."""
    inside: Operand = Number("logical", True)
    for start, limit in zip(map(build.signed, starts), limits, strict=True):
        for low, high in ((ZERO, start), (start, Number("integer", limit))):
            test = build.compute("le", low, high, hint="inside")
            inside = build.compute("and", inside, test, hint="inside")
    return inside


def _dynamic_slice(build: Builder, array: Scalars | Data, *starts: Scalars | Data) -> Scalars:
    """Part of an array that starts at computed indices."""
    pick = _Pick(build, array, build.params["slice_sizes"])
    base = pick.base([build.scalars(start).item() for start in starts])
    names: Any = build.names(build.target)
    for index in np.ndindex(names.shape):
        names[index] = pick.element(base, index, names[index])
    return names


def _gather(build: Builder, array: Scalars | Data, indices: Scalars | Data) -> Scalars:
    """Parts that start at computed indices, one for each row of an array of indices."""
    params, indices, axes = build.params, build.scalars(indices), len(array.shape)
    dimensions, sizes = params["dimension_numbers"], params["slice_sizes"]
    batched = dimensions.operand_batching_dims
    skipped_axes = (*dimensions.collapsed_slice_dims, *batched)
    windows = _Windows(
        dimensions.offset_dims,
        [k for k in range(axes) if k not in skipped_axes],
        {axis: k for k, axis in enumerate(dimensions.start_index_map)},
        dict(zip(batched, dimensions.start_indices_batching_dims, strict=True)),
    )
    limits = [size - part for size, part in zip(array.shape, sizes, strict=True)]
    fill = _fill_value(params, build.target.aval.dtype)
    pick = _Pick(build, array, sizes)
    names: Any = build.names(build.target)
    bases: dict[tuple[int, ...], tuple[_Base, Operand]] = {}
    for position, row, offset in windows.places(names.shape, axes):
        if row not in bases:
            starts = windows.starts(row, indices, axes)
            inside: Operand = Number("logical", True)
            if fill is not None:
                inside = _inside(build, starts, limits)
            bases[row] = pick.base(starts), inside
        base, inside = bases[row]
        group = names[position].group
        names[position] = element = pick.element(base, offset, names[position])
        if fill is not None:
            choice = (inside, element, Number(element.kind, fill))
            name = Name(element.kind, build.where.name, group, position)
            names[position] = build.assign("select", choice, name)
    return names


def _combine(
    build: Builder,
    arrays: Sequence[Scalars],
    windows: _Windows,
    join: Callable[[Operand, Operand], Operand],
    *,
    clipped: bool,
) -> Scalars:
    """Array with some parts combined with other arrays, at computed indices.

    Each element that the index can refer to is selected by a test of the index. If the index is
    known beforehand, so are the tests, and no code is generated for them.
    """
    array, indices, updates = arrays
    result, limits = array.copy(), list(array.shape)
    for axis, k in zip(windows.kept, windows.axes, strict=True):
        limits[axis] -= updates.shape[k] - 1

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
            new = join(old, updates[position])  # pyright: ignore[reportArgumentType]
            name = Name(new.kind, build.where.name, group, target)
            result[target] = build.assign("select", (is_target, new, old), name)
    return result


def _scatter(build: Builder, *arrays: Scalars) -> Scalars:
    """Array with some parts replaced or combined with others; parts outside it are ignored."""
    params, count = build.params, arrays[0].ndim
    dimensions = params["dimension_numbers"]
    batched = dimensions.operand_batching_dims
    skipped_axes = (*dimensions.inserted_window_dims, *batched)
    windows = _Windows(
        dimensions.update_window_dims,
        [k for k in range(count) if k not in skipped_axes],
        {axis: k for k, axis in enumerate(dimensions.scatter_dims_to_operand_dims)},
        dict(zip(batched, dimensions.scatter_indices_batching_dims, strict=True)),
    )

    def join(old: Operand, update: Operand) -> Operand:
        if params["update_jaxpr"] is None:
            return update
        inner = closed(params["update_jaxpr"], params["update_consts"])
        operands = [np.array(operand, dtype=object) for operand in (old, update)]
        (result,) = build.lower(inner, operands, build.block, build.where)
        return build.scalars(result).item()

    return _combine(build, arrays, windows, join, clipped="CLIP" in str(params["mode"]))


def _dynamic_update(build: Builder, array: Scalars, updates: Scalars, *starts: Scalars) -> Scalars:
    """Array with the part that starts at computed indices replaced."""
    axes = range(array.ndim)
    windows = _Windows(tuple(axes), list(axes), {axis: axis for axis in axes}, {})
    arrays = (array, np.array([start.item() for start in starts], dtype=object), updates)
    return _combine(build, arrays, windows, lambda _, update: update, clipped=True)


RULES: dict[str, Callable[..., Scalars]] = {
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update,
    "gather": _gather,
    "scatter": _scatter,
    **{
        f"scatter{mark}{operation}": _scatter
        for mark in "-_"
        for operation in ("add", "sub", "mul", "min", "max")
    },
}
