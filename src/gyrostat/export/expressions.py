"""Operations as expressions of C, with no more brackets than they need."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gyrostat.export.program import Kind, Number

FLOAT_LEAST = 1.1754943508222875e-38
FLOAT_LARGEST = 3.4028234663852886e38


@dataclass(frozen=True)
class Text:
    """An expression and how strongly it holds together, from `CHOICE` to `WORD`."""

    text: str
    strength: int

    def within(self, least: int) -> str:
        """The text, in brackets where it holds together less than this."""
        return self.text if self.strength >= least else f"({self.text})"


WORD, UNARY, PRODUCT, SUM, TEST, BOTH, EITHER, CHOICE = 8, 7, 6, 5, 4, 3, 2, 1

_SUMS = {"add": "+", "sub": "-"}
_PRODUCTS = {"mul": "*", "div": "/"}
_TESTS = {
    "lt": "<",
    "le": "<=",
    "gt": ">",
    "ge": ">=",
    "eq": "==",
    "ne": "!=",
    "xor": "!=",
}
HELPERS = {
    "max": (
        "largest",
        "static {t} largest({t} a, {t} b)\n{{\n    return (a >= b || a != a) ? a : b;\n}}\n",
    ),
    "min": (
        "smallest",
        "static {t} smallest({t} a, {t} b)\n{{\n    return (a <= b || a != a) ? a : b;\n}}\n",
    ),
    "sign": (
        "sense",
        "static {t} sense({t} a)\n{{\n    return a > 0 ? 1 : (a < 0 ? -1 : a);\n}}\n",
    ),
}
"""Operation -> name and text of a function that the file has where it is used. NaN stays NaN."""


@dataclass(frozen=True)
class Dialect:
    """C with one type for real numbers.

    Attributes:
        real: "double" or "float".
    """

    real: str = "double"

    def type_of(self, kind: Kind) -> str:
        """Type of C for a kind of number."""
        return {"real": self.real, "integer": "int64_t", "logical": "_Bool"}[kind]

    def number(self, number: Number) -> Text:
        """A constant."""
        value = number.value
        if number.kind == "logical":
            return Text("1" if value else "0", WORD)
        if number.kind == "integer":
            return Text(str(value), WORD if value >= 0 else UNARY)
        if math.isnan(value):
            return Text("NAN", WORD)
        size = abs(value)
        if self.real == "float" and 0.0 < size < FLOAT_LEAST:
            size = FLOAT_LEAST
        infinite = math.isinf(size) or (self.real == "float" and size > FLOAT_LARGEST)
        text = "INFINITY" if infinite else repr(float(size)) + ("f" if self.real == "float" else "")
        return Text(f"-{text}", UNARY) if math.copysign(1.0, value) < 0 else Text(text, WORD)

    def operation(self, name: str, operands: Sequence[Text]) -> Text:
        """An operation on expressions."""
        if name in _SUMS:
            left, right = operands
            return Text(f"{left.within(SUM)} {_SUMS[name]} {right.within(PRODUCT)}", SUM)
        if name in _PRODUCTS:
            left, right = operands
            text = f"{left.within(PRODUCT)} {_PRODUCTS[name]} {right.within(UNARY)}"
            return Text(text, PRODUCT)
        if name in _TESTS:
            left, right = operands
            return Text(f"{left.within(SUM)} {_TESTS[name]} {right.within(SUM)}", TEST)
        if name == "and":
            left, right = operands
            return Text(f"{left.within(BOTH)} && {right.within(TEST)}", BOTH)
        if name == "or":
            # compilers warn of `a && b || c`, though it says what is meant
            left, right = (o.within(EITHER if o.strength == EITHER else TEST) for o in operands)
            right = f"({right})" if operands[1].strength == EITHER else right
            return Text(f"{left} || {right}", EITHER)
        if name == "select":
            test, yes, no = operands
            return Text(f"{test.within(TEST)} ? {yes.within(EITHER)} : {no.within(EITHER)}", CHOICE)
        if name in ("neg", "not"):
            sign = "-" if name == "neg" else "!"
            return Text(sign + operands[0].within(WORD), UNARY)
        if name in ("to_real", "to_integer"):
            kind = self.real if name == "to_real" else "int64_t"
            return Text(f"({kind}){operands[0].within(WORD)}", UNARY)
        return self._call(name, operands)

    def _call(self, name: str, operands: Sequence[Text]) -> Text:
        arguments = ", ".join(operand.text for operand in operands)
        if name == "finite":
            return Text(f"isfinite({arguments}) != 0", TEST)
        if name in HELPERS:
            return Text(f"{HELPERS[name][0]}({arguments})", WORD)
        function = "fabs" if name == "abs" else name
        return Text(f"{function}{'f' if self.real == 'float' else ''}({arguments})", WORD)
