"""Which rows of constants become passes of a loop: the choice with the smallest program."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TypeVar

from gyrostat.codegen.memo import Memo
from gyrostat.codegen.program_cost import Cost
from gyrostat.codegen.scope import Scope

MORE_WORK = 1.05
"""Largest work with loops, over that of the same program written out."""

Program = TypeVar("Program")


def smallest(
    lower: Callable[[Scope], tuple[Program, Memo, Cost]],
    scope: Scope,
) -> Program:
    """Program with loops over rows of constants where that is smaller and takes hardly longer.

    Loops over rows that follow each other may be one, with the operations of both.

    Args:
        lower: Function that gives a program, what its lowering has made, and its cost.
        scope: Scope of the program.
    """
    program, memo, cost = lower(scope)
    if not memo.loops:
        return program
    written, _, most = lower(replace(scope, rows=None))

    def is_better(cost: Cost, than: Cost) -> bool:
        return cost.size < than.size and cost.work <= MORE_WORK * most.work

    best, least = (program, cost) if is_better(cost, most) else (written, most)
    rows: tuple[tuple[int, int, int], ...] = ()
    for group in _ranges(memo):
        chosen = rows
        for one in group:
            program, _, cost = lower(replace(scope, rows=(*rows, one)))
            if is_better(cost, least):
                best, least, chosen = program, cost, (*rows, one)
        rows = chosen
    return best


def _ranges(memo: Memo) -> Iterable[list[tuple[int, int, int]]]:
    """Ranges of rows of loops that follow each other, of one array and then the next."""
    arrays: dict[tuple[int, int], set[tuple[int, int]]] = {}
    for number, _, length, start, count in memo.loops:
        arrays.setdefault((number, length), set()).add((start, start + count))
    for (number, _), parts in sorted(arrays.items()):
        ranges = set(parts)
        for _ in parts:
            ranges |= {(a, d) for a, b in ranges for c, d in parts if b == c}
        yield [(number, *each) for each in sorted(ranges - parts)]
