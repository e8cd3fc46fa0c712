"""Intermediate representation between jaxpr and C: statements on scalars, in blocks.

A scalar is a `Name` that is given a value once, or a `Number`. Only a loop's carried names change,
at the end of each pass.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from gyrostat.codegen.source import NOWHERE, Source

Kind = Literal["real", "integer", "logical", "bits"]


@dataclass(frozen=True)
class Number:
    """A constant."""

    kind: Kind
    value: float | int | bool


@dataclass(eq=False)
class Name:
    """A scalar.

    Attributes:
        kind: of number.
        hint: what to call it, if that is free; a `fixed` one is a text of C, as memory->speed.
        group: the operation that it comes from: one for all elements of an array.
        place: of an element in its array.
        fixed: whether `hint` stands as it is.
    """

    kind: Kind
    hint: str = ""
    group: int = 0
    place: tuple[int, ...] = ()
    fixed: bool = False


@dataclass(eq=False)
class Table:
    """Scalars that a running index picks from, row by row.

    Attributes:
        kind: of number.
        size: its scalars.
        hint: what to call it.
        kept: whether it is a result: nothing in the program reads it.
    """

    kind: Kind
    size: int
    hint: str = ""
    kept: bool = False


Operand = Name | Number


@dataclass(eq=False)
class Assign:
    """target = operation(operands); `table` is what an "element" is picked from."""

    target: Name
    operation: str
    operands: tuple[Operand, ...]
    source: Source = NOWHERE
    table: Table | None = None


@dataclass(eq=False)
class Fill:
    """A table of values that are all there."""

    table: Table
    values: tuple[Operand, ...]
    source: Source = NOWHERE


@dataclass(eq=False)
class Store:
    """table[width * index + offset] = value, in a loop that declares the table."""

    table: Table
    index: Name
    width: int
    offset: int
    value: Operand
    source: Source = NOWHERE


@dataclass(eq=False)
class Carried:
    """What a loop carries from pass to pass."""

    name: Name
    first: Operand
    next: Operand


@dataclass(eq=False)
class Loop:
    """`count` passes, or fewer: while `goes_on`, which the `test` block computes."""

    count: int
    counter: Name
    carried: list[Carried]
    body: "Block"
    test: "Block"
    goes_on: Operand | None
    stacked: list[Table] = field(default_factory=list)
    source: Source = NOWHERE


@dataclass(eq=False)
class Branch:
    """One of several blocks, by a number from 0; each gives the targets its own values."""

    index: Operand
    blocks: list["Block"]
    values: list[list[Operand]]
    targets: list[Name]
    source: Source = NOWHERE


@dataclass(eq=False)
class Function:
    """A function of scalars; `rows` are results too, as kept tables."""

    name: str
    parameters: list[Name]
    body: "Block"
    results: list[Operand]
    source: Source = NOWHERE
    rows: list[Table] = field(default_factory=list)


@dataclass(eq=False)
class Call:
    """targets = function(operands)."""

    function: Function
    operands: list[Operand]
    targets: list[Name]
    source: Source = NOWHERE


Statement = Assign | Fill | Store | Loop | Branch | Call
Block = list[Statement]


def inner_blocks(statement: Statement) -> list[Block]:
    """The blocks of a statement that has some."""
    if isinstance(statement, Loop):
        return [statement.test, statement.body]
    return statement.blocks if isinstance(statement, Branch) else []


def statements(block: Block) -> Iterator[Statement]:
    """The statements of a block, each followed by those in it."""
    for statement in block:
        yield statement
        for inner in inner_blocks(statement):
            yield from statements(inner)
