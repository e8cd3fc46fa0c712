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
    (total,) = carried(
        build,
        counts[0],
        (first,),
        lambda inside, counter, values: [
            accumulated(
                inside,
                counts[1:],
                values[0],
                lambda within, inner, value: step(within, (counter, *inner), value),
                depth + 1,
            )
        ],
        depth,
        start,
    )
    return total


def carried(
    build: Builder,
    count: int,
    first: Sequence[Operand],
    step: Callable[[Builder, Operand, tuple[Operand, ...]], Sequence[Operand]],
    depth: int = 0,
    start: Operand = FIRST,
) -> tuple[Operand, ...]:
    """Values after the passes of a loop.

    Args:
        build: Builder.
        count: Number of passes.
        first: Values before the first pass.
        step: Function that appends a pass: (builder, counter, values) -> values.
        depth: Number of loops around this one.
        start: First number of the counter, which leaves out the passes before.
    """
    loop = _loop(build, count, depth)
    loop.start = start
    names = tuple(Name(each.kind, build.where.name, next(build.groups)) for each in first)
    last = step(build.inside(loop.body), loop.counter, names)
    loop.carried.extend(Carried(*each) for each in zip(names, first, last, strict=True))
    return names
