"""Syntax tree of the part of C that flight code uses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gyrostat.codegen.flight.reader.tokens import Position


@dataclass(frozen=True, eq=False)
class Literal:
    """Number. Its kind is "real", "single" (float), "integer" or "logical"."""

    value: float | int | bool
    kind: str


@dataclass(frozen=True, eq=False)
class Place:
    """Variable, or element or member of one.

    Attributes:
        name: Name of the variable.
        path: Members below it, with dots between them; "" for none.
        indices: Indices behind them.
        is_target: Whether the variable is an address, and this is the number there.
    """

    name: str
    path: str = ""
    indices: tuple["Expression", ...] = ()
    is_target: bool = False


@dataclass(frozen=True, eq=False)
class Address:
    """Address of a variable."""

    place: Place


@dataclass(frozen=True, eq=False)
class Unary:
    """Operation on one operand, also a cast such as (double); `at` is where it starts."""

    operation: str
    operand: "Expression"
    at: Position


@dataclass(frozen=True, eq=False)
class Binary:
    """Operation on two operands, which start at `at` and `right_at`."""

    operation: str
    left: "Expression"
    right: "Expression"
    at: Position
    right_at: Position


@dataclass(frozen=True, eq=False)
class Choice:
    """Conditional expression, the test of which starts at `at`."""

    test: "Expression"
    yes: "Expression"
    no: "Expression"
    at: Position


@dataclass(frozen=True, eq=False)
class Invocation:
    """Call of a function."""

    function: str
    arguments: tuple["Expression", ...]


Expression = Literal | Place | Address | Unary | Binary | Choice | Invocation


@dataclass(frozen=True, eq=False)
class Declaration:
    """Definition of a variable.

    Attributes:
        kind: Type.
        name: Name.
        sizes: Sizes of an array; () for a number.
        values: Initial value or, of an array, values in C's order; None without one.
        is_constant: Whether it keeps its initial value.
    """

    kind: str
    name: str
    sizes: tuple[int, ...]
    values: tuple[Expression, ...] | None
    is_constant: bool


@dataclass(frozen=True, eq=False)
class Assignment:
    """Assignment."""

    place: Place
    value: Expression


@dataclass(frozen=True, eq=False)
class If:
    """Choice of one of two blocks by a test, which starts at `at`."""

    test: Expression
    yes: tuple["Statement", ...]
    no: tuple["Statement", ...]
    at: Position


@dataclass(frozen=True, eq=False)
class For:
    """Loop with a counter that grows up to a limit.

    Attributes:
        counter: Name of the counter.
        start: First number of the counter.
        limit: First number that the counter does not reach.
        body: Statements of a pass.
        test: The test as an expression.
    """

    counter: str
    start: Expression
    limit: int
    body: tuple["Statement", ...]
    test: Binary


@dataclass(frozen=True, eq=False)
class Break:
    """End of the innermost loop."""


@dataclass(frozen=True, eq=False)
class Return:
    """End of the function."""

    value: Expression | None


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Expression that is evaluated for its effects."""

    value: Expression


@dataclass(frozen=True, eq=False)
class Sourced:
    """Statement with the line of Python that it comes from."""

    statement: "Plain"
    source: str


Plain = Declaration | Assignment | If | For | Break | Return | Evaluation
Statement = Sourced


@dataclass(frozen=True, eq=False)
class Parameter:
    """Parameter of a function; an array has the address of its first element."""

    kind: str
    name: str
    is_address: bool


@dataclass(frozen=True, eq=False)
class FunctionText:
    """Function of a C file."""

    name: str
    parameters: tuple[Parameter, ...]
    body: tuple[Statement, ...]


def parts(expression: Expression) -> tuple[Expression, ...]:
    """Expressions directly inside an expression."""
    match expression:
        case Place(indices=indices):
            return indices
        case Unary(operand=operand):
            return (operand,)
        case Binary(left=left, right=right):
            return (left, right)
        case Choice(test=test, yes=yes, no=no):
            return (test, yes, no)
        case Invocation(arguments=arguments):
            return arguments
    return ()


def inside(expression: Expression) -> Iterator[Expression]:
    """Expression and all expressions inside it."""
    yield expression
    for part in parts(expression):
        yield from inside(part)


def addressed(statements: Sequence[Statement]) -> set[str]:
    """Variables whose address is taken."""
    return {
        e.place.name
        for statement in statements
        for expression in _expressions(statement)
        for e in inside(expression)
        if isinstance(e, Address)
    }


def _expressions(statement: Statement) -> Iterator[Expression]:
    match statement.statement:
        case Declaration(values=values):
            yield from values or ()
        case Assignment(value=value) | Evaluation(value=value):
            yield value
        case Return(value=value) if value is not None:
            yield value
        case If(test=test, yes=yes, no=no):
            yield test
            for inner in (*yes, *no):
                yield from _expressions(inner)
        case For(start=start, body=body):
            yield start
            for inner in body:
                yield from _expressions(inner)
