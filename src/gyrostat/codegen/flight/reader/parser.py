"""Parser of expressions of emitted C."""

from gyrostat.codegen.flight.reader.syntax import (
    Address,
    Binary,
    Choice,
    Expression,
    Invocation,
    Literal,
    Place,
    Unary,
)
from gyrostat.codegen.flight.reader.tokens import Token, UnreadableError

NUMBERS = ("double", "float", "int64_t", "int32_t", "uint64_t", "uint32_t", "bool", "int")
"""Types of numbers."""
_NAMED = {
    "true": (True, "logical"),
    "false": (False, "logical"),
    "INFINITY": (float("inf"), "real"),
    "NAN": (float("nan"), "real"),
    "INT64_MIN": (-(2**63), "integer"),
    "INT64_MAX": (2**63 - 1, "integer"),
}
_LEVELS = (
    ("||",),
    ("&&",),
    ("|",),
    ("^",),
    ("&",),
    ("==", "!="),
    ("<", "<=", ">", ">="),
    ("<<", ">>"),
    ("+", "-"),
    ("*", "/", "%"),
)
_SIGNS = ("-", "!", "~")


class Parser:
    """Reads expressions from a list of tokens, from the one at `at` on.

    Attributes:
        at: Number of the next token.
        pointers: Name of each pointer of the function -> what it points to.
    """

    def __init__(self, tokens: list[Token]) -> None:
        self._tokens = tokens
        self.at = 0
        self.pointers: dict[str, Place] = {}

    @property
    def token(self) -> Token:
        """Next token."""
        return self._tokens[self.at]

    def ahead(self, count: int) -> str:
        """Text of a later token."""
        return self._tokens[min(self.at + count, len(self._tokens) - 1)].text

    def take(self) -> Token:
        """Read a token."""
        token = self.token
        self.at += 1
        return token

    def accept(self, text: str) -> bool:
        """Read a token if it has a given text; whether it has."""
        if self.token.text != text:
            return False
        self.at += 1
        return True

    def expect(self, *texts: str) -> Token:
        """Read tokens of given texts and return the last one.

        Raises:
            UnreadableError: Another token follows.
        """
        token = self.token
        for text in texts:
            token = self.take()
            if token.text != text:
                raise UnreadableError(f"{token.at}: found {token.text!r}, expected {text!r}")
        return token

    def integer(self) -> int:
        """Read an integer."""
        token = self.take()
        if not token.text.isdecimal():
            raise UnreadableError(f"{token.at}: found {token.text!r}, expected an integer")
        return int(token.text)

    def expression(self) -> Expression:
        """Read an expression."""
        at = self.token.at
        test = self._binary(0)
        if not self.accept("?"):
            return test
        yes = self.expression()
        self.expect(":")
        return Choice(test, yes, self.expression(), at)

    def _binary(self, level: int) -> Expression:
        if level == len(_LEVELS):
            return self._unary()
        at = self.token.at
        left = self._binary(level + 1)
        while self.token.text in _LEVELS[level]:
            operation = self.take().text
            right_at = self.token.at
            left = Binary(operation, left, self._binary(level + 1), at, right_at)
        return left

    def _unary(self) -> Expression:
        token = self.token
        if token.text in _SIGNS:
            self.take()
            return Unary(token.text, self._unary(), token.at)
        if token.text == "&":
            self.take()
            return Address(self.place())
        if token.text == "(" and self.ahead(1) in (*NUMBERS, "void"):
            kind = self._tokens[self.at + 1].text
            self.expect("(", kind, ")")
            return Unary(kind, self._unary(), token.at)
        return self._word()

    def _word(self) -> Expression:
        token = self.token
        if token.text == "(" and not (self.ahead(1) == "*" and self.ahead(3) == ")"):
            self.take()
            inner = self.expression()
            self.expect(")")
            return inner
        if token.kind == "number":
            return _number(self.take().text)
        if token.text in _NAMED:
            self.take()
            return Literal(*_NAMED[token.text])
        if token.text in ("INT64_C", "UINT64_C", "UINT32_C"):
            self.expect(token.text, "(")
            sign = -1 if self.accept("-") else 1
            number = int(self.take().text, 0)
            self.expect(")")
            return Literal(sign * number, "integer")
        if token.kind == "word" and self.ahead(1) == "(":
            return self._invocation()
        return self.place()

    def _invocation(self) -> Invocation:
        token = self.take()
        self.expect("(")
        arguments: list[Expression] = []
        while not self.accept(")"):
            arguments.append(self.expression())
            if self.token.text != ")":
                self.expect(",")
        return Invocation(token.text, tuple(arguments))

    def place(self) -> Place:
        """Read a variable with its members and indices."""
        is_target = self.token.text in ("*", "(")
        in_brackets = self.accept("(")
        if is_target:
            self.expect("*")
        token = self.take()
        if token.kind != "word":
            raise UnreadableError(f"{token.at}: found {token.text!r}, expected a variable")
        if in_brackets:
            self.expect(")")
        to = self.pointers.get(token.text, Place(token.text))
        path = [to.path] if to.path else []
        while self.token.text in ("->", "."):
            self.take()
            path.append(self.take().text)
        indices: list[Expression] = []
        while self.accept("["):
            indices.append(self.expression())
            self.expect("]")
        return Place(to.name, ".".join(path), tuple(indices), is_target)


def _number(text: str) -> Literal:
    if text.lower().startswith("0x") or text.rstrip("uU").isdecimal():
        return Literal(int(text.rstrip("uU"), 0), "integer")
    if text.endswith("f"):
        return Literal(float(text[:-1]), "single")
    return Literal(float(text), "real")
