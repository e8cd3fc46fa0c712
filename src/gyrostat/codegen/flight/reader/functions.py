"""Parser of statements and functions of emitted C."""

from collections.abc import Iterator

from gyrostat.codegen.flight.reader.parser import NUMBERS, Parser
from gyrostat.codegen.flight.reader.syntax import (
    Assignment,
    Binary,
    Break,
    Declaration,
    Evaluation,
    Expression,
    For,
    FunctionText,
    If,
    Literal,
    Parameter,
    Place,
    Plain,
    Return,
    Sourced,
    Statement,
)
from gyrostat.codegen.flight.reader.tokens import tokens

INTRINSIC = ("is_finite", "bits_of_real", "real_of_bits")
"""Functions of a C file whose bodies are not read: they look at the bits of a number."""


def functions(text: str) -> tuple[FunctionText, ...]:
    """Functions of an emitted C file, in its order.

    Each begins with the constant tables before it, which it may read.

    Raises:
        UnreadableError: The file has statements that emitted C has not.
    """
    return tuple(_functions(Parser(tokens(text))))


def _functions(parser: Parser) -> Iterator[FunctionText]:
    tables: list[Statement] = []
    while parser.token.kind != "end":
        if [parser.ahead(k) for k in (1, 4)] == ["const", "["]:
            tables.append(Sourced(_declaration(parser), parser.token.source))
            continue
        while parser.ahead(1) != "(":
            parser.take()
        name = parser.take().text
        parser.expect("(")
        parameters = []
        while not parser.accept(")"):
            parameters.append(_parameter(parser))
            parser.accept(",")
        if name in INTRINSIC:
            _skip_block(parser)
            continue
        parser.pointers.clear()
        body = (*tables, *_block(parser))
        yield FunctionText(name, tuple(p for p in parameters if p.name), body)


def _parameter(parser: Parser) -> Parameter:
    parser.accept("const")
    kind = parser.take().text
    is_address = parser.accept("*")
    name = "" if kind == "void" else parser.take().text
    while parser.accept("["):
        parser.take()
        is_address = True
        parser.accept("]")
    return Parameter(kind, name, is_address)


def _skip_block(parser: Parser) -> None:
    depth = 0
    while True:
        text = parser.take().text
        depth += (text == "{") - (text == "}")
        if text == "}" and depth == 0:
            return


def _block(parser: Parser) -> tuple[Statement, ...]:
    parser.expect("{")
    statements: list[Statement] = []
    while not parser.accept("}"):
        if _is_pointer(parser):
            continue
        source = parser.token.source
        statements.append(Sourced(_statement(parser), source))
    return tuple(statements)


def _is_pointer(parser: Parser) -> bool:
    """Read the declaration of a pointer if one follows; whether it does."""
    start = int(parser.token.text == "const")
    if [parser.ahead(start + 1), parser.ahead(start + 2)] != ["*", "const"]:
        return False
    parser.at += start + 3
    name = parser.take().text
    parser.expect("=", "&")
    parser.pointers[name] = parser.place()
    parser.expect(";")
    return True


def _statement(parser: Parser) -> Plain:
    match parser.token.text:
        case "if":
            return _if(parser)
        case "for":
            return _for(parser)
        case "break":
            parser.expect("break", ";")
            return Break()
        case "return":
            parser.take()
            value = None if parser.token.text == ";" else parser.expression()
            parser.expect(";")
            return Return(value)
        case "const" | "static":
            return _declaration(parser)
        case kind if kind in NUMBERS:
            return _declaration(parser)
    if parser.token.kind == "word" and parser.ahead(1) != "(":
        return _assignment(parser)
    if parser.token.text == "*":
        return _assignment(parser)
    if parser.token.text == "(" and parser.ahead(1) == "*":
        return _assignment(parser)
    value = parser.expression()
    parser.expect(";")
    return Evaluation(value)


def _assignment(parser: Parser) -> Assignment:
    place = parser.place()
    parser.expect("=")
    value = parser.expression()
    parser.expect(";")
    return Assignment(place, value)


def _declaration(parser: Parser) -> Declaration:
    parser.accept("static")
    is_constant = parser.accept("const")
    kind, name = parser.take().text, parser.take().text
    sizes = []
    while parser.accept("["):
        sizes.append(parser.integer())
        parser.expect("]")
    values = None
    if parser.accept("="):
        values = tuple(_values(parser)) if sizes else (parser.expression(),)
    parser.expect(";")
    return Declaration(kind, name, tuple(sizes), values, is_constant)


def _values(parser: Parser) -> Iterator[Expression]:
    """Values of an array in C's order."""
    if parser.token.text != "{":
        yield parser.expression()
        return
    parser.take()
    while not parser.accept("}"):
        yield from _values(parser)
        parser.accept(",")


def _if(parser: Parser) -> If:
    parser.expect("if", "(")
    at = parser.token.at
    test = parser.expression()
    parser.expect(")")
    yes, no = _block(parser), ()
    if parser.accept("else"):
        if parser.token.text == "if":
            source = parser.token.source
            no = (Sourced(_if(parser), source),)
        else:
            no = _block(parser)
    return If(test, yes, no, at)


def _for(parser: Parser) -> For:
    parser.expect("for", "(")
    parser.take()
    counter = parser.take().text
    parser.expect("=")
    start = parser.expression()
    parser.expect(";")
    at = parser.token.at
    parser.expect(counter, "<")
    right_at = parser.token.at
    limit = parser.integer()
    parser.expect(";", "++", counter, ")")
    test = Binary("<", Place(counter), Literal(limit, "integer"), at, right_at)
    return For(counter, start, limit, _block(parser), test)
