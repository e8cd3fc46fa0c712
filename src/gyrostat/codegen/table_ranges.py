"""Ranges of the integers in tables, such as the places of a permutation."""

from collections.abc import Mapping

from gyrostat.codegen.program import (
    Assign,
    Fill,
    Function,
    Name,
    Number,
    Operand,
    Store,
    Table,
    statements,
)
from gyrostat.codegen.ranges import Range, union


def table_ranges(function: Function, known: Mapping[Name, Range]) -> dict[Table, Range]:
    """Range of each table of integers that a function fills.

    A table that is only set to numbers of known ranges and to elements of such tables has their
    ranges.

    Args:
        function: Function.
        known: Ranges of names.
    """
    inside = [*statements(function.body)]
    elements = {each.target: each.table for each in inside if isinstance(each, Assign)}
    values: dict[Table, list[Operand]] = {
        each.table: [*each.values]
        for each in inside
        if isinstance(each, Fill) and each.table.kind in ("integer", "index")
    }
    for each in inside:
        if isinstance(each, Store) and each.table in values:
            values[each.table].append(each.value)
    tables = {*values}

    def source(value: Operand) -> Table | None:
        return elements.get(value) if isinstance(value, Name) else None

    def range_of(value: Operand) -> Range | None:
        if isinstance(value, Number):
            return int(value.value), int(value.value)
        return known.get(value)

    while True:  # leave out tables with other elements, and those that are set from them
        unknown = {
            table
            for table in tables
            if any(source(v) not in tables and range_of(v) is None for v in values[table])
        }
        if not unknown:
            break
        tables -= unknown
    ranges: dict[Table, Range] = {}
    while True:
        before = dict(ranges)
        for table in tables:
            parts = [
                ranges.get(other) if (other := source(v)) in tables else range_of(v)
                for v in values[table]
            ]
            found = union([part for part in parts if part is not None] or [None])
            if found is not None:
                ranges[table] = found
        if ranges == before:
            return ranges
