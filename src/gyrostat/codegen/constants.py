"""Constant tables, and operations with known zeros."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.primitives import FOLDED, LOGICAL_ONLY, WRAPPED
from gyrostat.codegen.program import ONE, ZERO, Kind, Number, Operand, Table


class TooManyError(Exception):
    """More operations than a limit."""


def constant_table(tables: dict[Any, Table], kind: Kind, values: Sequence[Any]) -> Table:
    """Constant table; equal ones are one.

    Args:
        tables: Tables so far.
        kind: Kind of number.
        values: Elements.
    """
    key = kind, np.array(values).tobytes(), len(values)
    return tables.setdefault(key, Table(kind, len(values), values=tuple(values)))


def with_zero(operation: str, operands: tuple[Operand, ...]) -> Operand | None:
    """Result of an operation one operand of which is the constant 0; None for other operations."""
    if ZERO not in operands:
        return None
    if operation == "mul" or (operation == "div" and operands[0] == ZERO):
        return ZERO
    if operation in ("add", "sub") and operands[1] == ZERO:
        return operands[0]
    if operation == "add":
        return operands[1]
    return None


def folded(operation: str, operands: Sequence[Operand], kind: Kind) -> Operand | None:
    """Constant or operand that an operation always gives; None if it has to be computed.

    Args:
        operation: Name of the operation.
        operands: Operands.
        kind: Kind of number of the result.
    """
    if operation in FOLDED and all(isinstance(o, Number) for o in operands):
        value = FOLDED[operation](*(o.value for o in operands if isinstance(o, Number)))
        return Number(kind, WRAPPED.get(kind, lambda v: v)(value))
    if operation == "select":
        test, yes, no = operands
        if isinstance(test, Number):
            return yes if test.value else no
        if yes is no or (isinstance(yes, Number) and repr(yes) == repr(no)):
            return yes
    if len(operands) != 2:
        return None
    for first, second in (operands, operands[::-1]):
        if operation == "mul" and first == ONE:
            return second
        if operation == "ne" and first == Number("logical", False):
            return second
        is_test = operation in LOGICAL_ONLY and operation != "xor" and kind == "logical"
        if is_test and isinstance(first, Number):
            return second if first.value == (operation == "and") else first
    return None
