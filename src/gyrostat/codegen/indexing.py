"""Rules for reading elements at constant or computed indices."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from gyrostat.codegen.arrays import Array, Data, joined
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.loops import nest
from gyrostat.codegen.nests import declared, placed, put, reader, settled
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Name, Number, Operand
from gyrostat.codegen.views import view_of

ZERO = Number("integer", 0)


class _Base(NamedTuple):
    """Index in a table: the sum of a computed and a known one.

    Attributes:
        computed: Computed index; None for 0.
        known: Known index.
    """

    computed: Operand | None
    known: int


class Pick:
    """Array with elements read at a computed index, which is clamped to the array."""

    def __init__(self, build: Builder, array: Array, sizes: Sequence[int]) -> None:
        self.data = placed(build, array)
        self._sizes, self._strides = sizes, self.data.strides() or []

    def base(self, build: Builder, starts: Sequence[Operand]) -> _Base:
        """Index in the table of the first element of the part that starts at some indices."""
        base, offset = self.data.base, int(self.data.places.flat[0])
        for axis, start in enumerate(map(build.signed, starts)):
            if start.kind == "index":  # the counter of a loop
                term = build.index("mul", Number("index", self._strides[axis]), start)
                base = build.index("add", base, term)
                continue
            last = Number("integer", self.data.shape[axis] - self._sizes[axis])
            step = build.as_index(build.clamp(start, ZERO, last))
            if isinstance(step, Number):
                offset += int(step.value) * self._strides[axis]
                continue
            if self._strides[axis] != 1:
                step = build.index("mul", Number("index", self._strides[axis]), step)
            base = build.index("add", base, step)
        return _Base(base, offset)

    def part(self, base: _Base) -> Data:
        """Part of the array that starts at an index of its table."""
        first = self.data.places[tuple(slice(0, size) for size in self._sizes)]
        return Data(self.data.table, first - first.flat[0] + base.known, base.computed)


class Windows(NamedTuple):
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

    def starts(
        self,
        row: tuple[int, ...],
        indices: Scalars,
        count: int,
        counters: Sequence[Operand] = (),
    ) -> list[Operand]:
        """Start of the window for one row of indices, on each axis of the operand.

        Args:
            row: Row.
            indices: Indices.
            count: Number of axes of the operand.
            counters: Row, if loops count it.
        """
        starts: list[Operand] = [ZERO] * count
        for axis, column in self.started.items():
            starts[axis] = indices[(*row, column)]
        for axis, index_axis in self.batched.items():
            number = Number("integer", row[index_axis])
            starts[axis] = counters[index_axis] if counters else number
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


def inside_limits(build: Builder, starts: Sequence[Operand], limits: Sequence[int]) -> Operand:
    """Whether a part that starts at the given indices lies within the array."""
    inside: Operand = Number("logical", True)
    for start, limit in zip(map(build.signed, starts), limits, strict=True):
        if start.kind == "index":  # the counter of a loop
            continue
        for low, high in ((ZERO, start), (start, Number("integer", limit))):
            test = build.compute("le", low, high, hint="inside")
            inside = build.compute("and", inside, test, hint="inside")
    return inside


def _dynamic_slice(build: Builder, array: Array, *starts: Array) -> Array:
    """Part of an array that starts at computed indices."""
    pick = Pick(build, array, build.params["slice_sizes"])
    base = pick.base(build, [build.scalars(start).item() for start in starts])
    return settled(build, pick.part(base))


def _gather(build: Builder, array: Array, indices: Array) -> Array:
    """Parts that start at computed indices, one for each row of an array of indices."""
    params, indices, axes = build.params, build.scalars(indices), array.ndim
    dimensions, sizes = params["dimension_numbers"], params["slice_sizes"]
    batched = dimensions.operand_batching_dims
    skipped_axes = (*dimensions.collapsed_slice_dims, *batched)
    windows = Windows(
        dimensions.offset_dims,
        [k for k in range(axes) if k not in skipped_axes],
        {axis: k for k, axis in enumerate(dimensions.start_index_map)},
        dict(zip(batched, dimensions.start_indices_batching_dims, strict=True)),
    )
    limits = [size - part for size, part in zip(array.shape, sizes, strict=True)]
    fill = _fill_value(params, build.target.aval.dtype)
    pick = Pick(build, array, sizes)
    if build.size > build.scope.few and not all(isinstance(each, Number) for each in indices.flat):
        return _gathered(build, pick, windows, indices, limits, fill)
    elements = np.empty(build.shape, dtype=object)
    bases: dict[tuple[int, ...], tuple[Data, Operand]] = {}
    group = next(build.groups)
    for position, row, offset in windows.places(elements.shape, axes):
        if row not in bases:
            starts = windows.starts(row, indices, axes)
            inside: Operand = Number("logical", True)
            if fill is not None:
                inside = inside_limits(build, starts, limits)
            bases[row] = pick.part(pick.base(build, starts)), inside
        part, inside = bases[row]
        element: Any = _element(build, part, offset)
        if fill is not None:
            number = Number(element.kind, fill)
            name = Name(element.kind, build.where.name, group, position)
            element = build.assign("select", (inside, build.scalar(element), number), name)
        elements[position] = element
    return settled(build, joined(elements))


def _gathered(
    build: Builder,
    pick: "Pick",
    windows: Windows,
    indices: Scalars,
    limits: Sequence[int],
    fill: Any,
) -> Data:
    """Parts that start at computed indices, in a loop over the rows of indices."""
    kind, shape = build.scope.kind(build.target), build.shape
    table = declared(build, kind, build.size)
    rows, axes = [k for k in range(len(shape)) if k not in windows.axes], pick.data.ndim
    order = [*rows, *windows.axes]  # the elements of a part are next to each other
    places = np.arange(table.size).reshape([shape[k] for k in order])
    data = Data(table, places.transpose(np.argsort(order)))
    target = view_of(data)
    # each column has a table of its own, with the range of its axis
    columns = [_column(build, indices[..., k]) for k in range(indices.shape[-1])]

    def body(inside: Builder, row: tuple[Operand, ...]) -> None:
        picked = np.empty((1,) * len(rows) + (len(columns),), dtype=object)
        for k, column in enumerate(columns):
            picked[..., k] = column(inside, row)
        starts = windows.starts((0,) * len(rows), picked, axes, row)
        is_inside: Operand = Number("logical", True)
        if fill is not None:
            is_inside = inside_limits(inside, starts, limits)
        part = view_of(pick.part(pick.base(inside, starts)))

        def copy(within: Builder, window: tuple[Operand, ...]) -> None:
            place: list[Operand] = [Number("index", 0)] * axes
            counters: list[Operand] = [Number("index", 0)] * len(shape)
            for axis, k, counter in zip(windows.kept, windows.axes, window, strict=True):
                place[axis] = counters[k] = counter
            for k, counter in zip(rows, row, strict=True):
                counters[k] = counter
            value = part.at(within, place)
            if fill is not None:
                name = Name(kind, within.where.name, next(within.groups))
                value = within.assign("select", (is_inside, value, Number(kind, fill)), name)
            put(within, target, counters, value)

        nest(inside, [shape[k] for k in windows.axes], copy, depth=len(rows))

    nest(build, [shape[k] for k in rows], body)
    return data


def _column(build: Builder, indices: Scalars) -> Callable[[Builder, tuple[Operand, ...]], Operand]:
    """Function (builder, counters) -> element of a column of indices, for a loop over the rows."""
    first = indices.flat[0]
    if isinstance(first, Number) and all(each == first for each in indices.flat):
        return lambda *_: first
    return reader(build, indices)


def _element(build: Builder, data: Data, position: Sequence[int]) -> Any:
    """Element of data at a position, read if its index is computed."""
    one = Data(data.table, data.places[tuple(position)].reshape(()), data.base)
    return build.scalars(one).item() if data.base is not None else one.elements().item()


RULES: dict[str, Callable[..., Array]] = {"dynamic_slice": _dynamic_slice, "gather": _gather}
"""Primitive -> (builder, operands) -> result."""
