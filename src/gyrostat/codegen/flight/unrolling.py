"""Loops that static analysis has to unroll."""

from gyrostat.codegen.program import Assign, Loop, Operand, Store, statements


def fills_tables(loop: Loop) -> bool:
    """Whether each pass of a loop sets other elements of tables."""
    counted: set[Operand] = {loop.counter}
    for statement in statements(loop.body):
        if isinstance(statement, Store) and not counted.isdisjoint(statement.indices):
            return True
        if isinstance(statement, Assign) and not counted.isdisjoint(statement.operands):
            counted.add(statement.target)
    return bool(loop.stacked)
