"""Tokens of emitted C, with their lines and the lines of Python that they come from."""

import re
from typing import NamedTuple

_TOKEN = re.compile(
    r"""(?P<space>\s+|\#(?:[^\n\\]|\\.)*)
    |(?P<comment>/\*.*?\*/)
    |(?P<number>(?:\d+\.\d*(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)f?|0[xX][0-9a-fA-F]+|\d+)[uU]?
    |(?P<word>[A-Za-z_]\w*)
    |(?P<sign>->|\+\+|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%<>=!&|^~?:;,.(){}\[\]])
    |(?P<text>"[^"]*")""",
    re.VERBOSE | re.DOTALL,
)
_SOURCE = re.compile(r"/\* (\S+\.py:\d+)(: .*)? \*/", re.DOTALL)


class UnreadableError(ValueError):
    """C text that is not as flight code is written."""


class Position(NamedTuple):
    """Position in a C file.

    Attributes:
        line: Line, from 1.
        column: Column, from 1.
    """

    line: int
    column: int

    def __str__(self) -> str:
        """Line and column as compilers write them."""
        return f"{self.line}:{self.column}"


class Token(NamedTuple):
    """Token.

    Attributes:
        text: Characters.
        kind: "number", "word", "sign", "text", or "end" after the last one.
        at: Position in the file.
        source: Line of Python named by the last comment before it; "" before the first one.
    """

    text: str
    kind: str
    at: Position
    source: str


def tokens(text: str) -> list[Token]:
    """Tokens of a C file without comments and preprocessor lines.

    Raises:
        UnreadableError: A character is not part of emitted C.
    """
    found: list[Token] = []
    sources: dict[str, str] = {}  # a comment after the first one of a line of Python has no text
    line, first, place, source = 1, 0, 0, ""
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise UnreadableError(f"line {line}: found {text[place : place + 20]!r}, expected C")
        kind, word = match.lastgroup or "", match.group()
        if kind == "comment":
            named = _SOURCE.fullmatch(word)
            if named and named[2]:
                sources[named[1]] = " ".join(f"{named[1]}{named[2]}".split())
            source = sources.get(named[1], source) if named else source
        elif kind != "space":
            found.append(Token(word, kind, Position(line, place - first + 1), source))
        if "\n" in word:
            line += word.count("\n")
            first = place + word.rindex("\n") + 1
        place = match.end()
    return [*found, Token("", "end", Position(line, place - first + 1), source)]
