"""Real numbers that are never negative, such as sizes and squares."""

from collections.abc import Mapping

from gyrostat.codegen.program import ZERO, Assign, Name, Number, Operand


class Signs:
    """Which real numbers are zero, positive or NaN."""

    def __init__(self, assigned: Mapping[Name, Assign]) -> None:
        """Begin without a number.

        Args:
            assigned: Statements that came before the one that is added.
        """
        self._assigned = assigned
        self._never_negative: set[Name] = set()

    def add(self, statement: Assign) -> None:
        """Learn from a statement."""
        if statement.target.kind == "real" and self._is_never_negative(statement):
            self._never_negative.add(statement.target)

    def has_none(self, operand: Operand) -> bool:
        """Whether a real number is zero, positive or NaN."""
        if isinstance(operand, Name):
            return operand in self._never_negative
        return operand.kind == "real" and not operand.value < 0.0

    def _is_never_negative(self, statement: Assign) -> bool:
        operation, operands = statement.operation, statement.operands
        if operation in ("abs", "sqrt", "exp"):
            return True
        if operation == "mul" and operands[0] is operands[1]:
            return True
        if operation == "max":
            return any(map(self.has_none, operands))
        if operation == "select" and self._is_size(*operands):
            return True
        if operation == "div":  # a quotient over -0.0 is negative
            is_positive = isinstance(operands[1], Number) and operands[1].value > 0.0
            return is_positive and self.has_none(operands[0])
        values = operands[1:] if operation == "select" else operands
        return operation in ("add", "mul", "min", "select") and all(map(self.has_none, values))

    def _is_size(self, test: Operand, yes: Operand, no: Operand) -> bool:
        """Whether a choice is -x where x < 0, and x elsewhere."""
        below, negative = (
            self._assigned.get(each) if isinstance(each, Name) else None for each in (test, yes)
        )
        return (
            below is not None
            and negative is not None
            and (below.operation, below.operands) == ("lt", (no, ZERO))
            and (negative.operation, negative.operands) == ("neg", (no,))
        )
