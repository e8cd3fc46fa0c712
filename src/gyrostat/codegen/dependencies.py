"""Data-dependency graph."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from gyrostat.codegen.program import (
    Assign,
    Branch,
    Call,
    Fill,
    Function,
    Loop,
    Name,
    Operand,
    Statement,
    Store,
    Table,
    inner_blocks,
    statements,
)


def used(statement: Statement) -> list[Operand]:
    """Operands that a statement reads in its own block."""
    match statement:
        case Assign(operands=operands) | Call(operands=operands):
            return list(operands)
        case Fill(values=values):
            return list(values)
        case Store(indices=indices, value=value):
            return [*indices, value]
        case Loop(carried=carried):
            return [*(each.first for each in carried), statement.start]
        case Branch(index=index):
            return [index]


def read_by(statement: Statement) -> list[Operand]:
    """Operands that a statement reads in its own block or at the end of those inside it."""
    operands = used(statement)
    if isinstance(statement, Loop):
        operands += [each.next for each in statement.carried]
        operands += [statement.goes_on] if statement.goes_on is not None else []
    if isinstance(statement, Branch):
        operands += [value for values in statement.values for value in values]
    return operands


def dependencies(functions: Sequence[Function]) -> dict[Name | Table, list[Operand | Table]]:
    """Names and tables that each name and table of some functions depends on directly."""
    graph: dict[Name | Table, list[Operand | Table]] = {}
    for function in functions:
        for statement in statements(function.body):
            for target, needs in _needs(statement):
                graph.setdefault(target, []).extend(need for need in needs if need is not None)
    return graph


def _needs(statement: Statement) -> Iterator[tuple[Name | Table, Sequence[Operand | Table | None]]]:
    match statement:
        case Assign(target, _, operands, _, table):
            yield target, (*operands, table)
        case Fill(table, values):
            yield table, values
        case Loop(carried=carried, goes_on=goes_on, stacked=stacked):
            yield from ((each.name, (each.first, each.next, goes_on)) for each in carried)
            yield statement.counter, (statement.start,)
            yield from ((table, (goes_on,)) for table in (*stacked, *_stored(statement)))
        case Store(table, indices, value):
            yield table, (*indices, value)
        case Branch(index, _, values, targets):
            yield from ((table, (index,)) for table in _stored(statement))
            for target, *choices in zip(targets, *values, strict=True):
                yield target, (index, *choices)
        case Call(function, operands, targets):
            for target, result in zip(targets, function.results, strict=True):
                yield target, (result,)
            for parameter, operand in zip(function.parameters, operands, strict=True):
                yield parameter, (operand,)


def _stored(statement: Statement) -> Iterator[Table]:
    """Tables that the blocks inside a statement store elements of."""
    for block in inner_blocks(statement):
        yield from (each.table for each in statements(block) if isinstance(each, Store))


def reached(
    start: Iterable[Operand | Table], edges: Mapping[Any, Iterable[Operand | Table]]
) -> set[Name | Table]:
    """All names and tables reachable from the given ones, including those themselves."""
    nodes: set[Name | Table] = set()
    stack = list(start)
    while stack:
        node = stack.pop()
        if isinstance(node, Name | Table) and node not in nodes:
            nodes.add(node)
            stack += edges.get(node, ())
    return nodes


def uses(function: Function) -> dict[Operand | Table, set[Name | Table]]:
    """Names and tables that use each operand and table of a function; its results are left out."""
    users: dict[Operand | Table, set[Name | Table]] = {}
    for target, needs in dependencies([function]).items():
        for need in needs:
            users.setdefault(need, set()).add(target)
    return users


def made_from(function: Function, given: Iterable[Name | Table]) -> set[Name | Table]:
    """All names and tables of a function that depend on any of the given ones."""
    return reached(given, uses(function))
