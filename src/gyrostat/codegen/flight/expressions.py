"""C expressions for operations, with brackets only where they are needed."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from gyrostat.codegen.flight.tested_sums import TESTED_ADD, TESTED_AND, TESTED_FINITE
from gyrostat.codegen.program import Kind, Number, Operand

FLOAT_LEAST = 1.1754943508222875e-38
FLOAT_LARGEST = 3.4028234663852886e38


@dataclass(frozen=True)
class Text:
    """Expression and its operator precedence, from `CHOICE` (lowest) to `WORD` (highest)."""

    text: str
    strength: int

    def beside(self, own: int = 8) -> str:
        """Expression as an operand, in brackets if needed.

        A word, a signed word and an operation of the same precedence as the one that uses it need
        no brackets. All others get brackets, so that the code does not rely on C's precedence.
        """
        return self.text if self.strength >= UNARY or self.strength == own else f"({self.text})"

    def word(self) -> str:
        """Expression, in brackets unless it is a single word."""
        return self.text if self.strength == WORD else f"({self.text})"


WORD, UNARY, PRODUCT, SUM, TEST, BOTH, EITHER, CHOICE = 8, 7, 6, 5, 4, 3, 2, 1

_TESTS = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!=", "xor": "!="}
_BINARY = (
    ({"add": "+", "sub": "-"}, SUM),
    ({"mul": "*", "div": "/", "quotient_of": "/", "remainder_of": "%"}, PRODUCT),
    (_TESTS, TEST),
    ({"and": "&&", TESTED_AND: "&&"}, BOTH),
    ({"or": "||"}, EITHER),
    ({"bits_and": "&", "bits_or": "|", "bits_xor": "^"}, TEST),
)
_SIGNS = {"neg": "-", "not": "!", "bits_not": "~"}
OF_INTEGERS = {
    **{name: f"bits_{name}" for name in ("and", "or", "xor", "not")},
    **{name: f"integer_{name}" for name in ("add", "sub", "mul", "neg")},
}
"""Operation on logical values or real numbers -> operation on integers."""
_OF_CONSTANTS = {"max": 0, "min": 0, "quotient": 1, "remainder": 1}


def simplest(operation: str, operands: Sequence[Operand]) -> str:
    """Operation that needs fewer tests, because an operand is a constant.

    A constant is not NaN, and a divisor that is neither 0 nor -1 gives what C gives.
    """
    constant = operands[_OF_CONSTANTS[operation]] if operation in _OF_CONSTANTS else None
    if not isinstance(constant, Number) or constant.value != constant.value:
        return operation
    if operation in ("quotient", "remainder") and constant.value in (0, -1):
        return operation
    return f"{operation}_of"


_CONVERSIONS: dict[str, Kind] = {
    "to_real": "real",
    "to_integer": "integer",
    "to_index": "index",
}
COPIES = frozenset({"finite", TESTED_FINITE, "as_integer", "as_real"})
"""Operations whose functions copy bits by `memcpy`."""
HELPERS = {
    "as_integer": "bits_of_real",
    "as_real": "real_of_bits",
    "max": "largest",
    "min": "smallest",
    "max_of": "at_least",
    "min_of": "at_most",
    "sign": "sense",
    "finite": "is_finite",
    TESTED_FINITE: "is_finite",
    TESTED_ADD: "plus",
    "to_whole": "integer_of",
    "integer_add": "integer_sum",
    "integer_sub": "integer_difference",
    "integer_mul": "integer_product",
    "integer_neg": "integer_opposite",
    "quotient": "integer_quotient",
    "remainder": "integer_rest",
    "shift_left": "integer_left",
    "shift_right": "integer_right",
}
"""Operation -> name of its function in the file helpers.h."""


@dataclass(frozen=True)
class Dialect:
    """C with one type for real numbers.

    Attributes:
        real: Type of real numbers, "double" or "float".
    """

    real: str = "double"

    def helper(self, operation: str) -> str:
        """C text of the function that implements an operation."""
        largest = FLOAT_LARGEST if self.real == "float" else float(np.finfo(np.float64).max)
        values = {"zero": 0.0, "one": 1.0, "limit": 2.0**63, "largest": largest}
        texts = {name: self.number(Number("real", value)).text for name, value in values.items()}
        texts |= {"bits": "uint64_t", "exponent": "UINT64_C(0x7ff0000000000000)"}
        if self.real == "float":
            texts |= {"bits": "uint32_t", "exponent": "UINT32_C(0x7f800000)"}
        texts["real"] = self.real
        return re.sub(r"@(\w+)@", lambda gap: texts[gap[1]], _helpers()[HELPERS[operation]])

    def type_of(self, kind: Kind) -> str:
        """C type for a kind of number."""
        kinds = {"integer": "int64_t", "logical": "bool", "index": "int32_t"}
        return self.real if kind == "real" else kinds[kind]

    def number(self, number: Number) -> Text:
        """Constant as an expression."""
        value = number.value
        if number.kind == "logical":
            return Text("true" if value else "false", WORD)
        if number.kind == "integer" and value == -(2**63):  # C has no such literal
            return Text("(-INT64_MAX - 1)", WORD)
        if number.kind in ("integer", "index"):
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
        """Operation on expressions."""
        for table, strength in _BINARY:
            if name in table:
                left, right = operands
                # comparisons are not chained
                first = left.beside(WORD if strength == TEST else strength)
                return Text(f"{first} {table[name]} {right.beside()}", strength)
        if name == "select":
            test, yes, no = (operand.beside() for operand in operands)
            # literals have type int, which the other operand may not have
            yes, no = (re.sub(r"^-?\d+$", r"INT64_C(\g<0>)", text) for text in (yes, no))
            return Text(f"{test} ? {yes} : {no}", CHOICE)
        if name == "copy":
            return operands[0]
        if name in _SIGNS:
            return Text(f"{_SIGNS[name]}{operands[0].word()}", UNARY)
        if name in _CONVERSIONS:
            return Text(f"({self.type_of(_CONVERSIONS[name])}){operands[0].word()}", UNARY)
        if name == "to_word":
            return self.operation("bits_and", [*operands, Text("4294967295", WORD)])
        if name == "to_half":
            half = Text("2147483648", WORD)
            word = self.operation("to_word", [self.operation("bits_xor", [*operands, half])])
            return self.operation("sub", [word, half])
        return self._call(name, operands)

    def _call(self, name: str, operands: Sequence[Text]) -> Text:
        arguments = ", ".join(operand.text for operand in operands)
        if name in HELPERS:
            return Text(f"{HELPERS[name]}({arguments})", WORD)
        function = "fabs" if name == "abs" else name
        return Text(f"{function}{'f' if self.real == 'float' else ''}({arguments})", WORD)


@cache
def _helpers() -> dict[str, str]:
    """Name of each helper function -> its text with placeholders."""
    content = files("gyrostat.codegen.flight").joinpath("helpers.h").read_text(encoding="utf-8")
    _, *texts = content.rstrip().split("\n\n")
    return {re.findall(r"^static \S+ (\w+)", text, re.MULTILINE)[0]: f"{text}\n" for text in texts}
