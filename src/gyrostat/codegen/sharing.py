"""Tables whose elements are never needed at the same time share their memory."""

from collections.abc import Iterator, Mapping
from typing import Any

from gyrostat.codegen.dependencies import read_by
from gyrostat.codegen.program import (
    Assign,
    Block,
    Fill,
    Function,
    Loop,
    Number,
    Operand,
    Statement,
    Store,
    Table,
    inner_blocks,
    statements,
)


def share_tables(function: Function) -> None:
    """Make tables of a function one where their uses follow each other, in place.

    A table that is computed element by element from another takes its place; a copy is left out.
    """
    for block in _blocks(function.body):
        _share(block, function)


def _blocks(block: Block) -> Iterator[Block]:
    yield block
    for statement in block:
        for inner in inner_blocks(statement):
            yield from _blocks(inner)


def _share(block: Block, function: Function) -> None:
    declared = [s.table for s in block if isinstance(s, Fill) and not s.values]
    if not declared:
        return
    tables = set(declared)
    first, last, elements = _lives(block, tables, function)
    owner: dict[Table, Table] = {}
    free_after: dict[Table, int] = {}
    for table in sorted((t for t in declared if t in first), key=lambda t: first[t]):
        start = first[table]
        choices = [
            other
            for other, end in free_after.items()
            if other.kind == table.kind
            and other.size >= table.size
            and (
                end < start
                or (end == start and _in_place(block[start], owner, elements, other, table))
            )
        ]
        # computed in place, or the smallest one
        best = min(choices, key=lambda t: (-free_after[t], t.size), default=table)
        owner[table] = best
        free_after[best] = max(last[table], free_after.get(best, 0))
        best.changes |= table.changes
    merged = {table: best for table, best in owner.items() if best is not table}
    if merged:
        _replace(block, merged)
        block[:] = [s for s in block if not (isinstance(s, Fill) and s.table in merged)]
        block[:] = [s for s in block if not _is_copy_of_itself(s)]
        _declare_before_use(block, set(owner.values()))


def _lives(
    block: Block, tables: set[Table], function: Function
) -> tuple[dict[Table, int], dict[Table, int], dict[Operand, Table]]:
    """Statements of a block that first set and last read or set each table.

    The third result are names of elements that are read where the name is used.
    """
    first: dict[Table, int] = {}
    last: dict[Table, int] = {}
    elements: dict[Operand, Table] = {}
    for position, statement in enumerate(block):
        if isinstance(statement, Fill) and not statement.values:
            continue
        for each in statements([statement]):
            touched = [elements[o] for o in read_by(each) if o in elements]
            table = each.table if isinstance(each, Assign | Store) else None
            if table in tables:
                touched.append(table)
                if isinstance(each, Assign) and isinstance(each.operands[0], Number):
                    # it may be read where its name is used
                    elements[each.target] = table
            for one in touched:
                first.setdefault(one, position)
                last[one] = position
    for operand in _results(block, function):
        if operand in elements:
            last[elements[operand]] = len(block)
    return first, last, elements


def _results(block: Block, function: Function) -> list[Operand]:
    """Operands that are read after a block has ended."""
    results = list(function.results)
    for statement in statements(function.body):
        if any(inner is block for inner in inner_blocks(statement)):
            results += read_by(statement)
    return results


def _in_place(
    statement: Statement,
    owner: Mapping[Table, Table],
    elements: Mapping[Operand, Table],
    source: Table,
    target: Table,
) -> bool:
    """Whether a statement reads each element of a table only to set the same one of another."""
    inside = [*statements([statement])]
    stores = [each for each in inside if isinstance(each, Store) and each.table is target]
    reads = [
        each
        for each in inside
        if isinstance(each, Assign)
        and each.table is not None
        and (owner.get(each.table, each.table) is source or each.table is target)
    ]
    others = [
        each
        for each in inside
        if isinstance(each, Store) and owner.get(each.table, each.table) is source
    ]
    if len(stores) != 1 or others or not isinstance(statement, Loop):
        return False
    named = {elements[o] for each in inside for o in read_by(each) if o in elements}
    if any(owner.get(table, table) is source for table in named):
        return False
    assigned = {each.target: each for each in inside if isinstance(each, Assign)}
    place = [_key(each, assigned) for each in stores[0].indices]
    # a loop that does not count along the table passes each element several times
    counters = [each.counter for each in inside if isinstance(each, Loop)]
    if not all(_contains(place, id(counter)) for counter in counters):
        return False
    return all([_key(o, assigned) for o in each.operands] == place for each in reads)


def _key(operand: Operand, assigned: Mapping[Any, Assign]) -> Any:
    """Expression of an index, the same for equal ones."""
    statement = assigned.get(operand)
    if statement is None or statement.table is not None:
        return operand if isinstance(operand, Number) else id(operand)
    return statement.operation, *(_key(each, assigned) for each in statement.operands)


def _contains(key: Any, part: Any) -> bool:
    return key == part or (isinstance(key, tuple | list) and any(_contains(k, part) for k in key))


def _replace(block: Block, merged: Mapping[Table, Table]) -> None:
    for statement in statements(block):
        table = statement.table if isinstance(statement, Assign | Store) else None
        if isinstance(statement, Assign | Store) and table is not None:
            statement.table = merged.get(table, table)


def _is_copy_of_itself(statement: Statement) -> bool:
    """Whether a loop only assigns elements of a table to themselves."""
    inside = [*statements([statement])]
    stores = [each for each in inside if isinstance(each, Store)]
    if not isinstance(statement, Loop) or len(stores) != 1 or statement.carried:
        return False
    assigned = {each.target: each for each in inside if isinstance(each, Assign)}
    source = assigned.get(stores[0].value)  # pyright: ignore[reportArgumentType]
    if source is None or source.table is not stores[0].table:
        return False
    keys = ([_key(o, assigned) for o in each] for each in (source.operands, stores[0].indices))
    return next(keys) == next(keys)


def _declare_before_use(block: Block, tables: set[Table]) -> None:
    """Move the declaration of each table before its first use."""
    fills = {s.table: s for s in block if isinstance(s, Fill) and s.table in tables}
    rest = [s for s in block if not (isinstance(s, Fill) and s.table in fills)]
    block.clear()
    for statement in rest:
        for each in statements([statement]):
            table = each.table if isinstance(each, Assign | Store) else None
            if table in fills:
                block.append(fills.pop(table))
        block.append(statement)
