"""Remove statements that no result depends on."""

from collections.abc import Sequence
from typing import Any

from gyrostat.codegen.dependencies import dependencies, reached
from gyrostat.codegen.program import (
    Assign,
    Block,
    Branch,
    Call,
    Fill,
    Function,
    Loop,
    Name,
    Statement,
    Store,
    Table,
    statements,
)


def prune(functions: Sequence[Function], roots: Sequence[Function]) -> list[Function]:
    """Remove, in place, each statement, parameter and result that the roots do not need.

    Args:
        functions: All functions, each after those that it calls.
        roots: Functions whose results and parameters are all kept.

    Returns:
        The remaining functions.
    """
    left = list(functions)
    # arguments of a call removed in the first round are unused in the second
    for _ in range(2):
        wanted = [thing for root in roots for thing in (*root.results, *root.rows)]
        names = reached(wanted, dependencies(left))
        given: dict[Function, set[int]] = {function: set() for function in left}
        for function in left:
            for call in statements(function.body):
                if isinstance(call, Call):
                    given[call.function] |= {k for k, t in enumerate(call.targets) if t in names}
        for function in left:
            function.body = _kept(function.body, names, given)
        for function in left:
            if function not in roots:
                function.results = _at(function.results, given[function])
                function.parameters = [p for p in function.parameters if p in names]
        left = [function for function in left if function in roots or given[function]]
    return left


def _kept(block: Block, names: set[Name | Table], given: dict[Function, set[int]]) -> Block:
    kept: list[Statement] = []
    for statement in block:
        match statement:
            case Assign(target):
                needed = target in names
            case Fill(table) | Store(table):
                needed = table in names
            case Loop():
                statement.carried = [c for c in statement.carried if c.name in names]
                statement.stacked = [t for t in statement.stacked if t in names]
                needed = bool(statement.carried or statement.stacked)
                statement.test = _kept(statement.test, names, given)
                statement.body = _kept(statement.body, names, given)
            case Branch(targets=targets):
                rows = {k for k, target in enumerate(targets) if target in names}
                statement.targets = _at(targets, rows)
                statement.values = [_at(made, rows) for made in statement.values]
                statement.blocks = [_kept(inner, names, given) for inner in statement.blocks]
                needed = bool(rows)
            case Call(function, operands, targets):
                needed = any(target in names for target in targets)
                if needed:
                    pairs = zip(function.parameters, operands, strict=True)
                    statement.operands = [o for parameter, o in pairs if parameter in names]
                    statement.targets = _at(targets, given[function])
        if needed:
            kept.append(statement)
    return kept


def _at(items: Sequence[Any], places: set[int]) -> list[Any]:
    return [item for k, item in enumerate(items) if k in places]
