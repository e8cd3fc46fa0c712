"""Ranges of the integers that tables hold and loops carry, such as the places of a permutation."""

from collections.abc import Iterator, Mapping, Sequence

from gyrostat.codegen.carried_numbers import counts_passes
from gyrostat.codegen.program import (
    Assign,
    Branch,
    Fill,
    Function,
    Loop,
    Name,
    Number,
    Operand,
    Store,
    Table,
    statements,
)
from gyrostat.codegen.ranges import Range, union

Stored = Table | Name
"""Table of integers that a function fills, or integer that a loop carries."""


def stored_ranges(function: Function, known: Mapping[Name, Range]) -> dict[Stored, Range]:
    """Range of each table of integers that a function fills, and of each integer of a loop.

    What is only set to numbers of known ranges and to others of these, or to one of several of
    them, has the range of them all.

    Args:
        function: Function.
        known: Ranges of names.
    """
    parts = _parts(function, known)
    while True:  # leave out what has other values, and what is set from it
        unknown = {
            each
            for each, values in parts.items()
            if any(not isinstance(part, tuple) and part not in parts for part in values)
        }
        if not unknown:
            break
        parts = {each: values for each, values in parts.items() if each not in unknown}
    ranges: dict[Stored, Range] = {}
    while True:
        before = dict(ranges)
        for each, values in parts.items():
            every = [part if isinstance(part, tuple) else ranges.get(part) for part in values]
            found = union([part for part in every if part is not None] or [None])
            if found is not None:
                ranges[each] = found
        if ranges == before:
            return ranges


def _parts(function: Function, known: Mapping[Name, Range]) -> dict[Stored, list[Range | Stored]]:
    """What each table and each integer of a loop is set to: ranges, others, or unknown names."""
    flows: dict[Operand, Sequence[Operand | Table]] = {}
    values: dict[Stored, list[Operand]] = {}
    stores: list[Store] = []
    for each in statements(function.body):
        match each:
            case Assign(operation="select" | "copy"):
                flows[each.target] = each.operands[-2:]
            case Assign(table=Table() as table):
                flows[each.target] = (table,)
            case Branch():
                columns = zip(*each.values, strict=True)
                flows |= dict(zip(each.targets, columns, strict=True))
            case Fill() if each.table.kind in ("integer", "index"):
                values[each.table] = [*each.values]
            case Store():
                stores.append(each)
            case Loop():
                values |= {
                    carried.name: [carried.first, carried.next]
                    for carried in each.carried
                    if carried.name.kind == "integer" and not counts_passes(carried, each.body)
                }
    for each in stores:
        if each.table in values:
            values[each.table].append(each.value)

    def followed(first: Sequence[Operand]) -> Iterator[Range | Stored]:
        seen: set[Operand | Table] = set()
        left: list[Operand | Table] = [*first]
        while left:
            value = left.pop()
            if value in seen:
                continue
            seen.add(value)
            if isinstance(value, Number):
                yield int(value.value), int(value.value)
            elif isinstance(value, Name) and value in known:
                yield known[value]
            elif value in flows and value not in values:
                left += flows[value]
            else:
                yield value

    return {each: [*followed(first)] for each, first in values.items()}
