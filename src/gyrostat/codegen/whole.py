"""Operations that are computed differently for integer and logical numbers than for real ones."""

from collections.abc import Callable

from gyrostat.codegen.program import Number, Operand

Append = Callable[..., Operand]
"""(operation, operands) -> result; appends the operation to a block."""


def _largest(append: Append, a: Operand, b: Operand) -> Operand:
    return append("or", a, b) if a.kind == "logical" else append("select", append("gt", a, b), a, b)


def _smallest(append: Append, a: Operand, b: Operand) -> Operand:
    if a.kind == "logical":
        return append("and", a, b)
    return append("select", append("lt", a, b), a, b)


def _size(append: Append, a: Operand) -> Operand:
    if a.kind == "bits":
        return a
    return append("select", append("lt", a, Number(a.kind, 0)), append("neg", a), a)


def _sign(append: Append, a: Operand) -> Operand:
    zero, one = Number(a.kind, 0), Number(a.kind, 1)
    above = append("select", append("gt", a, zero), one, zero)
    if a.kind == "bits":
        return above
    return append("select", append("lt", a, zero), Number(a.kind, -1), above)


OPERATIONS: dict[str, Callable[..., Operand]] = {
    "abs": _size,
    "div": lambda append, a, b: append("quotient", a, b),
    "fmod": lambda append, a, b: append("remainder", a, b),
    "max": _largest,
    "min": _smallest,
    "sign": _sign,
}
"""Operation -> (appending function, operands) -> result."""
