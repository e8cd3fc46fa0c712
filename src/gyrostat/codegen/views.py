"""Parts of tables that loops read and set: indices from the counters of the loops."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.codegen.arrays import Data
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.program import Kind, Name, Number, Operand, Table

Steps = tuple[int, ...]
"""Change of the index on each axis of a table from one pass of a loop to the next."""


@dataclass(frozen=True)
class View:
    """Part of a table with constant distances between its elements.

    Attributes:
        table: Table.
        base: Index that is added on the only axis of the table; None for 0.
        offset: Index of the first element on each axis of the table.
        steps: Steps along each axis of the part.
    """

    table: Table
    base: Operand | None
    offset: Steps
    steps: tuple[Steps, ...]

    def indices(self, build: Builder, counters: Sequence[Operand]) -> tuple[Operand, ...]:
        """Index on each axis of the table of the element that counters of loops give."""
        by_axis = zip(*self.steps, strict=True) if self.steps else [()] * len(self.offset)
        return tuple(
            index(build, self.base, first, counters, steps)
            for first, steps in zip(self.offset, by_axis, strict=True)
        )

    def at(self, build: Builder, counters: Sequence[Operand]) -> Operand:
        """Element that counters of loops give."""
        name = Name(self.table.kind, build.where.name, next(build.groups))
        if self.table.memory:
            steps = [each[0] for each in self.steps]
            start = index(build, self.base, 0, counters, steps)
            return build.element(self.table, start, self.offset[0], name)
        return build.indexed(self.table, self.indices(build, counters), name)


@dataclass(frozen=True)
class Ramp:
    """Integers that grow by constant steps along each axis."""

    kind: Kind
    first: int
    steps: tuple[Steps, ...]

    def at(self, build: Builder, counters: Sequence[Operand]) -> Operand:
        """Number that counters of loops give."""
        total: Operand = Number(self.kind, self.first)
        for counter, (step,) in zip(counters, self.steps, strict=True):
            if step:
                name = Name(self.kind, "number", next(build.groups))
                number = build.assign(f"to_{self.kind}", (counter,), name)
                factor = Number(self.kind, step)
                term = number if step == 1 else build.compute("mul", number, factor)
                total = term if total == Number(self.kind, 0) else build.compute("add", total, term)
        return total


@dataclass(frozen=True)
class Same:
    """One operand at all places."""

    operand: Operand
    steps: tuple[Steps, ...]

    def at(self, build: Builder, counters: Sequence[Operand]) -> Operand:
        """The operand."""
        return self.operand


Leaf = View | Ramp | Same


def index(
    build: Builder,
    base: Operand | None,
    offset: int,
    counters: Sequence[Operand],
    steps: Sequence[int],
) -> Operand:
    """Sum of a base, an offset and counters times their steps."""
    total = base
    terms = [(step, counter) for step, counter in zip(steps, counters, strict=True) if step]
    for step, counter in sorted(terms, key=lambda term: term[0] < 0):
        if step < 0 and (offset or total is None):
            total = build.index("add", total, Number("index", offset))
            offset = 0
        term = counter
        if abs(step) != 1:
            term = build.index("mul", Number("index", abs(step)), counter)
        total = build.index("sub" if step < 0 else "add", total, term)
    if offset or total is None:
        total = build.index("add", total, Number("index", offset))
    return total


def view_of(data: Data) -> View:
    """View of data with constant distances."""
    view = regular(data)
    assert view is not None
    return view


def regular(data: Data) -> View | None:
    """View of data; None if the distances between its elements are not constant."""
    strides = data.strides()
    if strides is None:
        return None
    first, shape = int(data.places.flat[0]), data.table.shape
    if not shape:
        return View(data.table, data.base, (first,), tuple((s,) for s in strides))
    offset = tuple(int(k) for k in np.unravel_index(first, shape))
    steps = []
    for stride in strides:
        places = np.unravel_index(abs(stride), shape)
        steps.append(tuple(int(np.sign(stride) * k) for k in places))
    # an index may not leave its axis
    for axis, length in enumerate(shape):
        ends = [step[axis] * (count - 1) for step, count in zip(steps, data.shape, strict=True)]
        low, high = (sum(f(end, 0) for end in ends) for f in (min, max))
        if not 0 <= offset[axis] + low <= offset[axis] + high < length:
            return None
    return View(data.table, data.base, offset, tuple(steps))


def merged(shape: Sequence[int], parts: Sequence[Leaf]) -> tuple[list[int], list[Leaf]]:
    """Numbers of passes and parts with neighbouring axes made one where all parts allow it."""
    counts: list[int] = []
    steps: list[list[Steps]] = [[] for _ in parts]
    for axis, count in enumerate(shape):
        new = [part.steps[axis] for part in parts]
        if count == 1 and len(shape) > 1:
            continue
        if counts and all(
            each[-1] == tuple(count * s for s in step)
            for each, step in zip(steps, new, strict=True)
        ):
            counts[-1] *= count
            for each, step in zip(steps, new, strict=True):
                each[-1] = step
            continue
        counts.append(count)
        for each, step in zip(steps, new, strict=True):
            each.append(step)
    return counts, [
        replace(part, steps=tuple(each)) for part, each in zip(parts, steps, strict=True)
    ]
