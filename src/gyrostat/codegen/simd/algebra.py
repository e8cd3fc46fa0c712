"""Algebraic simplifications of single operations."""

import math
import sys
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from gyrostat.codegen.primitives import FOLDED, WRAPPED
from gyrostat.codegen.program import Assign, Kind, Number, Operand

_FOLDED: dict[str, Callable[..., Any]] = {
    "sqrt": lambda x: math.sqrt(x) if x >= 0.0 else math.nan,
    "abs": abs,
    "max": max,
    "min": min,
}


class Known(Protocol):
    """Operations that a program has computed so far."""

    def made(self, operand: Operand) -> Assign | None:
        """Statement that computes an operand; None if there is none."""
        ...

    def value(self, of: Assign, operation: str, *operands: Operand) -> Operand:
        """Result of an operation that replaces a statement or a part of it."""
        ...

    def is_exact(self, of: Assign) -> bool:
        """Whether a replacement of this statement must give the same bits."""
        ...

    def reciprocal(self, of: Assign, divisor: Operand) -> Operand | None:
        """Reciprocal of a divisor, if a product is cheaper than the division; None otherwise."""
        ...


def simpler(known: Known, of: Assign, operation: str, operands: Sequence[Operand]):
    """Constant, operand or simpler operation that replaces an operation; None if there is none.

    Args:
        known: Operations computed so far.
        of: Statement that contains the operation.
        operation: Name of the operation.
        operands: Operands of the operation.
    """
    if all(isinstance(operand, Number) for operand in operands):
        folded = _fold(operation, of.target.kind, operands)
        if folded is not None:
            return folded
    rule = _RULES.get(operation)
    return rule(known, of, *operands) if rule is not None else None


def key(operand: Operand) -> tuple[str, str]:
    """Sortable key that identifies an operand."""
    if isinstance(operand, Number):
        return (operand.kind, repr(operand.value))
    return ("name", f"{id(operand):x}")


def _fold(operation: str, kind: Kind, operands: Sequence[Operand]) -> Number | None:
    values = [operand.value for operand in operands if isinstance(operand, Number)]
    if operation in _FOLDED and kind == "real" and not any(v != v for v in values):
        return Number(kind, _FOLDED[operation](*values))
    if operation == "div" and values[1]:
        return Number(kind, values[0] / values[1])
    if operation in FOLDED:
        return Number(kind, WRAPPED.get(kind, lambda v: v)(FOLDED[operation](*values)))
    return None


def _is(operand: Operand, value: int) -> bool:
    return isinstance(operand, Number) and operand.kind != "logical" and operand.value == value


def _is_normal(value: float) -> bool:
    """Whether a number is finite and neither zero nor subnormal, which SIMD lanes take as zero."""
    return sys.float_info.min <= abs(value) < math.inf


def _operand_of(known: Known, operand: Operand, operation: str) -> Operand | None:
    """Operand x if the given operand is the result of an operation on x; None otherwise."""
    assign = known.made(operand)
    return assign.operands[0] if assign is not None and assign.operation == operation else None


def _negated(known: Known, operand: Operand) -> Operand | None:
    """Operand x if the given operand is -x; None otherwise."""
    return _operand_of(known, operand, "neg")


def _add(known: Known, of: Assign, a: Operand, b: Operand) -> Operand | None:
    for first, second in ((a, b), (b, a)):
        if _is(first, 0):
            return second
        negated = _negated(known, first)
        if negated is not None:
            return known.value(of, "sub", second, negated)
    return None


def _sub(known: Known, of: Assign, a: Operand, b: Operand) -> Operand | None:
    if _is(b, 0):
        return a
    if _is(a, 0):
        return known.value(of, "neg", b)
    negated = _negated(known, b)
    if negated is not None:
        return known.value(of, "add", a, negated)
    negated = _negated(known, a)
    if negated is not None:
        return known.value(of, "neg", known.value(of, "add", negated, b))
    return None


def _mul(known: Known, of: Assign, a: Operand, b: Operand) -> Operand | None:
    kind = of.target.kind
    for first, second in ((a, b), (b, a)):
        if _is(first, 0):
            return Number(kind, 0.0 if kind == "real" else 0)
        if _is(first, 1):
            return second
        if kind == "real" and _is(first, -1):
            return known.value(of, "neg", second)
        negated = _negated(known, first)
        if negated is not None:
            return known.value(of, "neg", known.value(of, "mul", negated, second))
        assign = known.made(second)
        if kind == "real" and isinstance(first, Number) and assign and assign.operation == "mul":
            inner, factor = assign.operands  # a constant operand comes first
            if isinstance(inner, Number) and not known.is_exact(of):
                product = inner.value * first.value
                if _is_normal(product):
                    return known.value(of, "mul", Number(kind, product), factor)
    return None


def _div(known: Known, of: Assign, a: Operand, b: Operand) -> Operand | None:
    if _is(b, 1):
        return a
    if known.is_exact(of):
        return None
    if isinstance(b, Number):
        share = 1.0 / b.value if b.value else math.inf
        return known.value(of, "mul", a, Number("real", share)) if _is_normal(share) else None
    negated = _negated(known, a)
    if negated is not None:
        return known.value(of, "neg", known.value(of, "div", negated, b))
    if _is(a, 1):
        return None
    share = known.reciprocal(of, b)
    return None if share is None else known.value(of, "mul", a, share)


def _neg(known: Known, of: Assign, a: Operand) -> Operand | None:
    assign = known.made(a)
    if assign is not None and assign.operation == "sub":
        return known.value(of, "sub", *assign.operands[::-1])
    return _negated(known, a)


def _select(known: Known, of: Assign, test: Operand, yes: Operand, no: Operand) -> Operand | None:
    if isinstance(test, Number):
        return yes if test.value else no
    if key(yes) == key(no):
        return yes
    condition = _operand_of(known, test, "not")
    return None if condition is None else known.value(of, "select", condition, no, yes)


def _beside(a: Operand, b: Operand, value: float) -> Operand | None:
    """Other operand if one of the two is the constant `value`; None otherwise."""
    return next((y for x, y in ((a, b), (b, a)) if x == Number("real", value)), None)


_RULES: dict[str, Callable[..., Operand | None]] = {
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "div": _div,
    "neg": _neg,
    "not": lambda known, of, a: _operand_of(known, a, "not"),
    "select": _select,
    "max": lambda known, of, a, b: _beside(a, b, -math.inf),
    "min": lambda known, of, a, b: _beside(a, b, math.inf),
}
