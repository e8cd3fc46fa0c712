"""Elements picked and replaced by indices, known beforehand or computed."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Assign, Block, Fill, Name, Number, Operand, Table
from gyrostat.codegen.source import Source
from gyrostat.codegen.tracing import closed

if TYPE_CHECKING:
    from gyrostat.codegen.lower import Lowering

ZERO = Number("integer", 0)


class _Pick:
    """An array whose elements are picked by a running index, kept within it."""

    def __init__(
        self,
        lowering: "Lowering",
        array: Scalars,
        sizes: Sequence[int],
        block: Block,
        where: Source,
    ) -> None:
        self._lowering, self._block, self._where = lowering, block, where
        self._array, self._sizes = array, sizes
        self._strides = [int(np.prod(array.shape[k + 1 :])) for k in range(array.ndim)]
        self._table = Table(array.flat[0].kind, array.size, where.name)
        block.append(Fill(self._table, tuple(array.flat), where))

    def base(self, starts: Sequence[Operand]) -> Operand:
        """Where a part that starts at some indices begins in the table."""
        base: Operand = ZERO
        for axis, start in enumerate(starts):
            last = Number("integer", self._array.shape[axis] - self._sizes[axis])
            kept = self._lowering.within(self._block, start, ZERO, last, self._where)
            step = self._new("mul", kept, Number("integer", self._strides[axis]))
            base = step if base == ZERO else self._new("add", base, step)
        return base

    def element(self, base: Operand, offset: Sequence[int], name: Name) -> Name:
        """An element of that part."""
        steps = sum(place * stride for place, stride in zip(offset, self._strides, strict=True))
        index = self._new("add", base, Number("integer", steps)) if steps else base
        self._block.append(Assign(name, "element", (index,), self._where, self._table))
        return name

    def _new(self, operation: str, *operands: Operand) -> Operand:
        if operation == "mul" and operands[1] == Number("integer", 1):
            return operands[0]
        name = Name("integer", "index", self._lowering.new_group())
        return self._lowering.assigned(self._block, operation, operands, name, self._where)


class _Windows(NamedTuple):
    """How a gather or scatter lays an array of windows over an operand.

    Attributes:
        axes: of the array of windows that run inside a window.
        kept: axes of the operand that those are, in order.
        started: axis of the operand -> column of the indices that a window starts at.
        batched: axis of the operand -> axis of the indices whose number a window starts at.
    """

    axes: tuple[int, ...]
    kept: list[int]
    started: dict[int, int]
    batched: dict[int, int]

    def starts(self, row: tuple[int, ...], indices: Scalars, count: int) -> list[Operand]:
        """Where the window of a row of indices starts, for each axis of the operand."""
        found: list[Operand] = [ZERO] * count
        for axis, column in self.started.items():
            found[axis] = indices[(*row, column)]
        for axis, other in self.batched.items():
            found[axis] = Number("integer", row[other])
        return found

    def places(self, shape: tuple[int, ...], count: int) -> Iterator[tuple[Any, Any, list[int]]]:
        """Each place of the array of windows: itself, its row of indices, its offset."""
        for place in np.ndindex(shape):
            row = tuple(p for k, p in enumerate(place) if k not in self.axes)
            offset = [0] * count
            for axis, k in zip(self.kept, self.axes, strict=True):
                offset[axis] = place[k]
            yield place, row, offset


def _filling(params: dict[str, Any], dtype: Any) -> Any:
    """What stands for elements beyond the array; None where the index is kept within it."""
    if "FILL" not in str(params["mode"]):
        return None
    if params["fill_value"] is not None:
        return np.asarray(params["fill_value"], dtype).item()
    if np.issubdtype(dtype, np.integer):
        limits = np.iinfo(dtype)
        return int(limits.min or limits.max)
    return dtype == np.bool_ or np.nan


def _inside(
    lowering: "Lowering",
    block: Block,
    starts: Sequence[Operand],
    limits: Sequence[int],
    where: Source,
) -> Operand:
    """Whether a part that starts at some indices lies within the array."""
    inside: Operand = Number("logical", True)
    for start, limit in zip(starts, limits, strict=True):
        for test, operands in (("le", (ZERO, start)), ("le", (start, Number("integer", limit)))):
            name = Name("logical", "inside", lowering.new_group())
            one = lowering.assigned(block, test, operands, name, where)
            name = Name("logical", "inside", lowering.new_group())
            inside = lowering.assigned(block, "and", (inside, one), name, where)
    return inside


def _dynamic_slice(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """A part that starts at a running index."""
    pick = _Pick(lowering, given[0], equation.params["slice_sizes"], block, where)
    base = pick.base([start.item() for start in given[1:]])
    names: Any = lowering.names(equation.outvars[0], where)
    for place in np.ndindex(names.shape):
        pick.element(base, place, names[place])
    return names


def _gather(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source):
    """Parts that start at running indices, one for each element of an array of indices."""
    array, indices = given
    params = equation.params
    dimensions, sizes = params["dimension_numbers"], params["slice_sizes"]
    batched = dimensions.operand_batching_dims
    gone = (*dimensions.collapsed_slice_dims, *batched)
    windows = _Windows(
        dimensions.offset_dims,
        [k for k in range(array.ndim) if k not in gone],
        {axis: k for k, axis in enumerate(dimensions.start_index_map)},
        dict(zip(batched, dimensions.start_indices_batching_dims, strict=True)),
    )
    limits = [size - part for size, part in zip(array.shape, sizes, strict=True)]
    filled = _filling(params, equation.outvars[0].aval.dtype)
    pick = _Pick(lowering, array, sizes, block, where)
    names: Any = lowering.names(equation.outvars[0], where)
    bases: dict[tuple[int, ...], tuple[Operand, Operand]] = {}
    for place, row, offset in windows.places(names.shape, array.ndim):
        if row not in bases:
            starts = windows.starts(row, indices, array.ndim)
            inside: Operand = Number("logical", True)
            if filled is not None:
                inside = _inside(lowering, block, starts, limits, where)
            bases[row] = pick.base(starts), inside
        base, inside = bases[row]
        element = pick.element(base, offset, names[place])
        if filled is not None:
            choice = (inside, element, Number(element.kind, filled))
            name = Name(element.kind, where.name, element.group, place)
            names[place] = lowering.assigned(block, "select", choice, name, where)
    return names


def _placed(
    lowering: "Lowering",
    block: Block,
    arrays: Sequence[Scalars],
    windows: _Windows,
    join: Callable[[Operand, Operand], Operand],
    *,
    clipped: bool,
    where: Source,
) -> Scalars:
    """An array some of whose parts are joined with others, at indices.

    Every element that an index can mean is chosen by a test of the index: where that is known, so
    are the tests, and elements only change their places.
    """
    array, indices, updates = arrays
    made, limits = array.copy(), list(array.shape)
    for axis, k in zip(windows.kept, windows.axes, strict=True):
        limits[axis] -= updates.shape[k] - 1

    def test(operation: str, *operands: Operand) -> Operand:
        name = Name("logical", "chosen", lowering.new_group())
        return lowering.assigned(block, operation, operands, name, where)

    def tests(row: tuple[int, ...]) -> list[list[Operand]]:
        found = []
        for start, limit in zip(windows.starts(row, indices, array.ndim), limits, strict=True):
            last = Number("integer", limit - 1)
            kept = lowering.within(block, start, ZERO, last, where) if clipped else start
            found.append([test("eq", kept, Number("integer", k)) for k in range(limit)])
        return found

    known: dict[tuple[int, ...], list[list[Operand]]] = {}
    group = lowering.new_group()
    for place, row, offset in windows.places(updates.shape, array.ndim):
        if row not in known:
            known[row] = tests(row)
        for cell in np.ndindex(*limits):
            chosen: Operand = Number("logical", True)
            for axis, k in enumerate(cell):
                chosen = test("and", chosen, known[row][axis][k])
            if chosen == Number("logical", False):
                continue
            target = tuple(k + step for k, step in zip(cell, offset, strict=True))
            old: Any = made[target]
            new = join(old, updates[place])  # pyright: ignore[reportArgumentType]
            name = Name(new.kind, where.name, group, target)
            made[target] = lowering.assigned(block, "select", (chosen, new, old), name, where)
    return made


def _scatter(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """An array some of whose parts are replaced or joined with others; those beyond it are left."""
    params, count = equation.params, given[0].ndim
    dimensions, batched = (
        params["dimension_numbers"],
        params["dimension_numbers"].operand_batching_dims,
    )
    gone = (*dimensions.inserted_window_dims, *batched)
    windows = _Windows(
        dimensions.update_window_dims,
        [k for k in range(count) if k not in gone],
        {axis: k for k, axis in enumerate(dimensions.scatter_dims_to_operand_dims)},
        dict(zip(batched, dimensions.scatter_indices_batching_dims, strict=True)),
    )

    def join(old: Operand, update: Operand) -> Operand:
        if params["update_jaxpr"] is None:
            return update
        inner = closed(params["update_jaxpr"], params["update_consts"])
        both = [np.array(operand, dtype=object) for operand in (old, update)]
        return lowering.library(inner, both, block, where)[0].item()

    clipped = "CLIP" in str(params["mode"])
    return _placed(lowering, block, given, windows, join, clipped=clipped, where=where)


def _dynamic_update(
    lowering: "Lowering", equation: Any, given: list[Scalars], block: Block, where: Source
):
    """An array of which a part that starts at running indices is replaced."""
    array, updates, *starts = given
    axes = range(array.ndim)
    windows = _Windows(tuple(axes), list(axes), {axis: axis for axis in axes}, {})
    arrays = (array, np.array([start.item() for start in starts], dtype=object), updates)
    return _placed(
        lowering, block, arrays, windows, lambda _, update: update, clipped=True, where=where
    )


LOWERED: dict[str, Callable[..., Scalars]] = {
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update,
    "gather": _gather,
    **{
        f"scatter{operation}": _scatter
        for operation in ("", "-add", "_add", "_sub", "-sub", "-mul", "_mul", "-min", "_min")
    },
    "scatter-max": _scatter,
    "scatter_max": _scatter,
}
"""Primitive -> (lowering, equation, operands, block, source) -> result."""
