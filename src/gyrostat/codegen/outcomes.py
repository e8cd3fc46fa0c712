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


def implies(one: Operand, other: Operand, assigned: Mapping[Name, Assign]) -> bool:
    """Whether a logical value compares two numbers that differ if it is true, as another one says.

    Args:
        one: Logical value.
        other: The other one.
        assigned: Statements by their targets.
    """
    first, second = (assigned.get(o) if isinstance(o, Name) else None for o in (one, other))
    if first is None or second is None or second.operation != "ne":
        return False
    return first.operation in ("lt", "gt") and set(first.operands) == set(second.operands)
