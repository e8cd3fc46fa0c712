"""Passes of the loops of a file of C, read from its text."""

import ast
import operator
import re
from collections.abc import Mapping
from dataclasses import dataclass

from .listing import UnboundedError

Interval = tuple[int, int]
"""Least and largest value of an integer."""

_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\])*\"", re.DOTALL)
_CAST = re.compile(r"\((?:u?int\d+_t|size_t|int)\)|INT64_C")
_FIRST = re.compile(r"(?:\w+\s+)?(\w+)\s*=\s*(.+)", re.DOTALL)
_TEST = re.compile(r"(\w+)\s*(<=|<|>=|>)\s*(.+)", re.DOTALL)
_STEP = re.compile(r"(?:(\+\+|--)(\w+)|(\w+)(\+\+|--)|(\w+)\s*([+-]=)\s*(\d+))")


@dataclass(frozen=True)
class CLoop:
    """A `for` loop.

    Attributes:
        first: First line of its header.
        body: Line on which the header ends and the body begins.
        last: Line of the closing brace.
        passes: Largest number of passes.
        function: Line on which the body of its function begins.
    """

    first: int
    body: int
    last: int
    passes: int
    function: int = 0

    def contains(self, other: "CLoop") -> bool:
        """Whether another loop is inside this one."""
        return self.first <= other.first and other.last <= self.last and self != other


def c_loops(text: str) -> list[CLoop]:
    """Loops of a file, each after those that contain it.

    The start and the limit of a loop are sums and products of integers, of the counters of loops
    that contain it, and of constants that are such sums; the body leaves the counter alone.

    Args:
        text: C.

    Raises:
        UnboundedError: Control flow of another form; the message names the line.
    """
    text = _COMMENT.sub(lambda part: re.sub(r"[^\n]", " ", part[0]), text)
    for word in re.finditer(r"\b(while|do|goto|setjmp|longjmp)\b", text):
        raise UnboundedError(f"line {_line(text, word.start())}: found {word[0]}, expected for")
    loops: list[CLoop] = []
    counters: list[tuple[int, str, Interval]] = []  # end of the loop, counter, its values
    for word in re.finditer(r"\bfor\s*\(", text):
        header_end = _closing(text, word.end() - 1)
        line = _line(text, word.start())
        opening = re.compile(r"\)\s*\{").match(text, header_end)
        if opening is None:
            raise UnboundedError(f"line {line}: found for without braces, expected {{ after it")
        end = _closing(text, opening.end() - 1)
        inside = {name: values for last, name, values in counters if last > word.start()}
        function = text.rfind("\n{", 0, word.start()) + 1
        known = _Values(inside, text[function : word.start()])
        header = text[word.end() : header_end]
        name, values, passes = _counted(header, known, f"line {line}")
        _check_body(text[header_end:end], name, f"line {line}")
        counters.append((end, name, values))
        lines = (line, _line(text, header_end), _line(text, end))
        loops.append(CLoop(*lines, passes, _line(text, function)))
    return loops


@dataclass(frozen=True)
class _Values:
    """Values of integers at a place in a function.

    Attributes:
        counters: Counter of a loop around the place -> its values.
        before: Text of the function up to the place.
    """

    counters: Mapping[str, Interval]
    before: str

    def interval(self, text: str, where: str) -> Interval:
        """Least and largest value of an expression."""
        try:
            return self._of(ast.parse(_CAST.sub("", text).strip(), mode="eval").body, where)
        except (SyntaxError, LookupError):
            message = f"{where}: found {text.strip()}, expected a constant limit"
            raise UnboundedError(message) from None

    def _of(self, node: ast.AST, where: str) -> Interval:
        match node:
            case ast.Constant(value=int(number)):
                return number, number
            case ast.Name(id=name) if name in self.counters:
                return self.counters[name]
            case ast.Name(id=name):
                definition = rf"\bconst u?int\d+_t {name} = ([^;]+);"
                return self.interval(re.findall(definition, self.before)[-1], where)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                low, high = self._of(operand, where)
                return -high, -low
            case ast.BinOp(left=left, op=operation, right=right):
                of = _ARITHMETIC[type(operation)]
                lefts, rights = self._of(left, where), self._of(right, where)
                ends = [of(x, y) for x in lefts for y in rights]
                return min(ends), max(ends)
        raise LookupError


_ARITHMETIC = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul}


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def _closing(text: str, opening: int) -> int:
    """Place of the bracket that closes another."""
    depth, pair = 0, {"(": "()", "{": "{}"}[text[opening]]
    for place in range(opening, len(text)):
        depth += (text[place] == pair[0]) - (text[place] == pair[1])
        if depth == 0:
            return place
    raise UnboundedError(f"line {_line(text, opening)}: a bracket is not closed")


def _counted(header: str, known: _Values, where: str) -> tuple[str, Interval, int]:
    """Counter of a loop, its values in the body, and the largest number of passes."""
    parts = [part.strip() for part in _CAST.sub("", header).split(";")]
    patterns = (_FIRST, _TEST, _STEP)
    first, test, step = (p.fullmatch(part) for p, part in zip(patterns, parts, strict=True))
    if not (first and test and step):
        raise UnboundedError(f"{where}: found for ({header.strip()}), expected a counted loop")
    name, sign = first[1], step[1] or step[4] or step[6]
    size, rises = int(step[7] or 1), sign[0] == "+"
    names = {name, test[1], step[2] or step[3] or step[5]}
    if len(names) > 1 or rises != (test[2][0] == "<") or size == 0:
        raise UnboundedError(f"{where}: the counter does not approach its limit")
    start, limit = known.interval(first[2], where), known.interval(test[3], where)
    least, most = (start[0], limit[1]) if rises else (limit[0], start[1])
    length = max(most - least + ("=" in test[2]), 0)
    others = max(length - 1, 0)
    values = (least, least + others) if rises else (most - others, most)
    return name, values, -(-length // size)


def _check_body(body: str, counter: str, where: str) -> None:
    changed = rf"(?:\+\+|--|&)\s*{counter}\b|(?<![\w.>]){counter}\s*(?:\+\+|--|[-+*/]?=(?!=))"
    if re.search(changed, body):
        raise UnboundedError(f"{where}: the body changes the counter {counter}")
