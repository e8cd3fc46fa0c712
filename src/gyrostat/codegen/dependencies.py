"""Data-dependency graph."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from gyrostat.codegen.program import (
    Assign,
    Block,
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


def stored(block: Block) -> set[Table]:
    """Tables that some statements assign elements of, also in functions that they call."""
    tables: set[Table] = set()
    for statement in statements(block):
        if isinstance(statement, Store):
            tables.add(statement.table)
        if isinstance(statement, Call):
            tables |= stored(statement.function.body)
    return tables


Graph = dict[Name | Table, list[Operand | Table]]
"""Names and tables that each name and table depends on directly."""


def dependencies(functions: Sequence[Function]) -> Graph:
    """Names and tables that each name and table of some functions depends on directly."""
    graph: Graph = {}
    for function in functions:
        _add(function.body, (), graph)
    return graph


def _add(block: Block, controls: tuple[Operand, ...], graph: Graph) -> None:
    """Add the dependencies of a block.

    Args:
        block: Statements.
        controls: Indices and conditions of the branches and loops around them.
        graph: Dependencies so far.
    """

    def needs(target: Name | Table) -> list[Operand | Table]:
        return graph.setdefault(target, [])

    for statement in block:
        match statement:
            case Assign():
                needs(statement.target).extend(statement.operands)
                if statement.table is not None:
                    needs(statement.target).append(statement.table)
            case Store():
                needs(statement.table).extend((*statement.indices, statement.value, *controls))
            case Fill():
                needs(statement.table).extend(statement.values)
            case Loop():
                limit = () if statement.goes_on is None else (statement.goes_on,)
                for each in statement.carried:
                    needs(each.name).extend((each.first, each.next, *limit))
                needs(statement.counter).append(statement.start)
                for table in statement.stacked:
                    needs(table).extend(limit)
                for inner in inner_blocks(statement):
                    _add(inner, (*controls, *limit), graph)
            case Branch():
                for target, *choices in zip(statement.targets, *statement.values, strict=True):
                    needs(target).extend((statement.index, *choices))
                for inner in statement.blocks:
                    _add(inner, (*controls, statement.index), graph)
            case Call():
                called = statement.function
                for target, result in zip(statement.targets, called.results, strict=True):
                    needs(target).append(result)
                for parameter, operand in zip(called.parameters, statement.operands, strict=True):
                    needs(parameter).append(operand)


_NODES = (Name, Table)


def reached(
    start: Iterable[Operand | Table], edges: Mapping[Any, Iterable[Operand | Table]]
) -> set[Name | Table]:
    """All names and tables reachable from the given ones, including those themselves."""
    nodes: set[Name | Table] = set()
    stack = list(start)
    while stack:
        node = stack.pop()
        if isinstance(node, _NODES) and node not in nodes:
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
