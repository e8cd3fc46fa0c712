"""Expressions that a statement may contain instead of a name, and names of the others."""

from gyrostat.codegen.flight.expressions import WORD, Text
from gyrostat.codegen.flight.tested_sums import TESTED_AND, TESTED_FINITE
from gyrostat.codegen.program import (
    Assign,
    Block,
    Call,
    Function,
    Loop,
    Number,
    Statement,
    Store,
    Table,
    statements,
)

LONGEST = 70
"""Largest length of an expression that may be inlined in another."""


def takes_in(reader: Statement, statement: Assign, expression: Text) -> bool:
    """Whether a statement may contain the expression of another instead of its name."""
    if reader.source != statement.source or len(expression.text) > LONGEST:
        return False
    # annotations name the results of tests
    if statement.operation == TESTED_AND:
        return False
    if statement.operation == TESTED_FINITE:
        if not isinstance(reader, Assign) or reader.operation != TESTED_AND:
            return False
        return reader.operands[-1] is statement.target
    # the alternatives of a conditional expression are most readable as names
    if isinstance(reader, Assign) and reader.operation == "select":
        return expression.strength == WORD or reader.operands[0] is statement.target
    return True


def hint_for(statement: Assign, following: Block) -> str:
    """Name for a value: that on its Python line for the last operation, a part for others."""
    name = statement.target.hint or "value"
    for later in following:
        if later.source != statement.source:
            break
        if isinstance(later, Assign) and later.target.group != statement.target.group:
            return f"{name}_part"
    return name


def stored(block: Block) -> set[Table]:
    """Tables that some statements assign elements of."""
    return {each.table for each in statements(block) if isinstance(each, Store)}


def is_known_element(statement: Assign) -> bool:
    """Whether a statement reads an element at a known index that never changes."""
    table = statement.table
    return (
        table is not None
        and not (table.changes or table.shape)
        and all(isinstance(operand, Number) for operand in statement.operands)
    )


def may_stop_early(function: Function) -> bool:
    """Whether a loop in a function or its callees has a test that its bound may cut short."""
    return any(
        (isinstance(statement, Loop) and statement.goes_on is not None)
        or (isinstance(statement, Call) and may_stop_early(statement.function))
        for statement in statements(function.body)
    )
