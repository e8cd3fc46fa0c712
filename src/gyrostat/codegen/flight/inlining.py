"""Expressions that a statement may contain instead of a name, and names of the others."""

from collections import Counter
from collections.abc import Sequence

from gyrostat.codegen.dependencies import read_by
from gyrostat.codegen.flight.expressions import WORD, Text
from gyrostat.codegen.flight.tested_sums import TESTED_ADD, TESTED_AND, TESTED_FINITE
from gyrostat.codegen.program import (
    Assign,
    Block,
    Loop,
    Name,
    Number,
    Operand,
    Statement,
    Store,
    statements,
)

LONGEST = 140
"""Largest length of an expression that may be inlined in another."""
LONGEST_TEST = 70
"""The same of a logical expression, the conditions of which test vectors have to show, and of a
part of a tested sum."""
STORED = 160
"""Largest length of an expression that changes a variable or an element of a table."""


def takes_in(reader: Statement, statement: Assign, expression: Text) -> bool:
    """Whether a statement may contain the expression of another instead of its name."""
    is_change = isinstance(reader, Store) or (
        isinstance(reader, Assign) and reader.operation == "set"
    )
    is_test = statement.target.kind == "logical" or statement.operation == TESTED_ADD
    longest = STORED if is_change else LONGEST_TEST if is_test else LONGEST
    if reader.source != statement.source or len(expression.text) > longest:
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


def uses_of(block: Block, results: Sequence[Operand]) -> Counter[Name]:
    """Number of statements and results that read each name."""
    operands = [each for statement in statements(block) for each in read_by(statement)]
    return Counter(each for each in (*operands, *results) if isinstance(each, Name))


def is_known_element(statement: Assign) -> bool:
    """Whether a statement reads an element at a known index that never changes."""
    table = statement.table
    return (
        table is not None
        and not (table.changes or table.shape)
        and all(isinstance(operand, Number) for operand in statement.operands)
    )


def last_change(loop: Loop) -> list[Assign]:
    """Change of the only variable that a loop carries, at the end of a pass."""
    if len(loop.carried) != 1 or not loop.body or isinstance(loop.carried[0].next, Number):
        return []
    (each,) = loop.carried
    return [Assign(each.name, "set", (each.next,), loop.body[-1].source)]
