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
    remaining = list(functions)
    # arguments of a call removed in the first round are unused in the second
    for _ in range(2):
        results = [result for root in roots for result in (*root.results, *root.rows)]
        names = reached(results, dependencies(remaining))
        used_results: dict[Function, set[int]] = {function: set() for function in remaining}
        for function in remaining:
            for call in statements(function.body):
                if isinstance(call, Call):
                    used_results[call.function] |= {
                        k for k, t in enumerate(call.targets) if t in names
                    }
        for function in remaining:
            function.body = _prune_block(function.body, names, used_results)
        for function in remaining:
            if function not in roots:
                function.results = _at(function.results, used_results[function])
                function.parameters = [p for p in function.parameters if p in names]
        remaining = [
            function for function in remaining if function in roots or used_results[function]
        ]
    return remaining


def _prune_block(
    block: Block, names: set[Name | Table], used_results: dict[Function, set[int]]
) -> Block:
    remaining: list[Statement] = []
    for statement in block:
        match statement:
            case Assign(target):
                needed = target in names
            case Fill(table) | Store(table):
                needed = table in names
            case Loop():
                statement.carried = [c for c in statement.carried if c.name in names]
                statement.stacked = [t for t in statement.stacked if t in names]
                statement.test = _prune_block(statement.test, names, used_results)
                statement.body = _prune_block(statement.body, names, used_results)
                # a loop without variables fills tables
                needed = bool(statement.carried or statement.stacked or statement.body)
            case Branch(targets=targets):
                rows = {k for k, target in enumerate(targets) if target in names}
                statement.targets = _at(targets, rows)
                statement.values = [_at(choices, rows) for choices in statement.values]
                statement.blocks = [
                    _prune_block(inner, names, used_results) for inner in statement.blocks
                ]
                needed = bool(rows) or any(statement.blocks)
            case Call(function, operands, targets):
                needed = any(target in names for target in targets)
                if needed:
                    pairs = zip(function.parameters, operands, strict=True)
                    statement.operands = [o for parameter, o in pairs if parameter in names]
                    statement.targets = _at(targets, used_results[function])
        if needed:
            remaining.append(statement)
    return remaining


def _at(items: Sequence[Any], indices: set[int]) -> list[Any]:
    return [item for k, item in enumerate(items) if k in indices]
