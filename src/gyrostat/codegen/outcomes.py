"""What the outcome of a test decides."""

from collections.abc import Iterator, Mapping

from gyrostat.codegen.program import Assign, Name, Operand


def decided(
    operand: Operand, value: bool, assigned: Mapping[Name, Assign]
) -> Iterator[tuple[Assign, bool]]:
    """Statements of which a logical value decides the result, each with its result.

    Args:
        operand: Logical value.
        value: What it is.
        assigned: Statements by their targets.
    """
    statement = assigned.get(operand) if isinstance(operand, Name) else None
    if statement is None:
        return
    yield statement, value
    if statement.operation == "not":
        yield from decided(statement.operands[0], not value, assigned)
    elif statement.operation == ("and" if value else "or"):
        for each in statement.operands:
            yield from decided(each, value, assigned)
