"""Constant tables, and operations with known zeros."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.program import ZERO, Kind, Operand, Table


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
