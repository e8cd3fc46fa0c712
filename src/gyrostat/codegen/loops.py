"""Loops that a builder appends."""

from collections.abc import Callable, Sequence

from gyrostat.codegen.builder import Builder
from gyrostat.codegen.program import Carried, Loop, Name, Number, Operand

FIRST = Number("index", 0)
_COUNTERS = ("i", "j", "k", "m", "n")


def nest(
    build: Builder,
    counts: Sequence[int],
    body: Callable[[Builder, tuple[Operand, ...]], None],
    depth: int = 0,
) -> None:
    """Append nested loops.

    Args:
        build: Builder.
        counts: Number of passes of each loop; one pass is no loop.
        body: Function that appends the body: (builder, counters).
        depth: Number of loops around these.
    """
    counters: list[Operand] = []
    for count in counts:
        if count == 1:
            counters.append(Number("index", 0))
            continue
        loop = _loop(build, count, depth)
        build, depth = build.inside(loop.body), depth + 1
        counters.append(loop.counter)
    body(build, tuple(counters))


def spanned(
    build: Builder,
    start: Operand,
    stop: int,
    body: Callable[[Builder, Operand], None],
    depth: int = 0,
) -> None:
    """Append a loop whose counter goes from a computed start to the number before `stop`."""
    loop = _loop(build, stop, depth)
    loop.start = start
    body(build.inside(loop.body), loop.counter)


def _loop(build: Builder, count: int, depth: int) -> Loop:
    counter = Name("index", _COUNTERS[min(depth, len(_COUNTERS) - 1)], next(build.groups))
    loop = Loop(count, counter, [], [], [], None, [], build.where)
    build.block.append(loop)
    return loop


def accumulated(
    build: Builder,
    counts: Sequence[int],
    first: Operand,
    step: Callable[[Builder, tuple[Operand, ...], Operand], Operand],
    depth: int = 0,
    start: Operand = FIRST,
) -> Operand:
    """Value after the passes of nested loops.

    Args:
        build: Builder.
        counts: Number of passes of each loop.
        first: Value before the first pass.
        step: Function that appends a pass: (builder, counters, value) -> value.
        depth: Number of loops around these.
        start: First number of the counter of the first loop.
    """
    if not counts:
        return step(build, (), first)
    loop = _loop(build, counts[0], depth)
    loop.start = start
    total = Name(first.kind, build.where.name, next(build.groups))
    last = accumulated(
        build.inside(loop.body),
        counts[1:],
        total,
        lambda inside, inner, value: step(inside, (loop.counter, *inner), value),
        depth + 1,
    )
    loop.carried.append(Carried(total, first, last))
    return total
