"""Intermediate representation between jaxpr and C: statements on scalars and tables, in blocks.

A scalar is a `Name` that is assigned once, or a `Number`. Only the carried names of a loop change,
at the end of each pass. A small array is one of scalars; a large one is a `Table`, filled by loops.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from gyrostat.codegen.source import NOWHERE, Source

Kind = Literal["real", "integer", "logical", "bits", "index"]
"""Kind of number; "index" counts passes of loops and elements of tables."""


@dataclass(frozen=True)
class Number:
    """A constant."""

    kind: Kind
    value: float | int | bool


ZERO, ONE, MINUS_ONE = Number("real", 0.0), Number("real", 1.0), Number("real", -1.0)


@dataclass(eq=False)
class Name:
    """A scalar variable.

    Attributes:
        kind: Kind of number.
        hint: Preferred name in C. If `fixed`, an expression of C such as memory->speed.
        group: Number of the operation that computes it: the same for all elements of an array.
        place: Index of the element in its array.
        fixed: Whether `hint` is used unchanged.
        table: Array of the caller that it is an element of; `place` is its index there.
    """

    kind: Kind
    hint: str = ""
    group: int = 0
    place: tuple[int, ...] = ()
    fixed: bool = False
    table: "Table | None" = None


@dataclass(eq=False)
class Table:
    """Array of scalars in memory, which is read at a computed index.

    Attributes:
        kind: Kind of number.
        size: Number of scalars.
        hint: Preferred name in C. If there is a `shape`, an expression of C such as memory->rates.
        kept: Whether the table is a result, which nothing in the program reads.
        memory: Memory of the inputs that contains the table, "shared" or "own"; "" for a table that
            the program fills.
        start: Index of its first word in that memory.
        parameters: Index -> parameter for the element at this index, of a table in memory.
        values: Numbers of a constant table; () for other tables.
        shape: Shape of an array of the caller, which is read and set with an index for each axis;
            () for other tables.
        changes: Whether elements change after the table was read, as those carried by a loop do.
    """

    kind: Kind
    size: int
    hint: str = ""
    kept: bool = False
    memory: Literal["", "shared", "own"] = ""
    start: int = 0
    parameters: dict[int, Name] = field(default_factory=dict)
    values: tuple[float | int | bool, ...] = ()
    shape: tuple[int, ...] = ()
    changes: bool = False

    def known(self, index: int) -> "Operand":
        """Element at a known index of a constant table, a table in memory or one of the caller."""
        if self.values:
            return Number(self.kind, self.values[int(index)])
        if self.shape:
            return self.parameters.setdefault(int(index), self._of_caller(int(index)))
        return self.parameter(index)

    def _of_caller(self, index: int) -> Name:
        place = np.unravel_index(index, self.shape)
        text = self.hint + "".join(f"[{k}]" for k in place)
        return Name(self.kind, text, place=(index,), fixed=True, table=self)

    def parameter(self, index: int) -> Name:
        """Parameter for the element at a known index, of a table in memory."""
        return self.parameters.setdefault(int(index), Name(self.kind))


Operand = Name | Number


@dataclass(eq=False)
class Assign:
    """Operation: target = operation(operands).

    An "element" is read from `table` at the index that is its operand. For a table in the memory of
    the inputs, the index is the sum of two operands, the second of which is constant; for one with
    a shape, there is an index for each axis.
    """

    target: Name
    operation: str
    operands: tuple[Operand, ...]
    source: Source = NOWHERE
    table: Table | None = None


@dataclass(eq=False)
class Fill:
    """Declaration of a table: with all its values, or with none, for loops that fill it."""

    table: Table
    values: tuple[Operand, ...]
    source: Source = NOWHERE


@dataclass(eq=False)
class Store:
    """Assignment of an element: table[index] = value, with an index for each axis of a shape."""

    table: Table
    indices: tuple[Operand, ...]
    value: Operand
    source: Source = NOWHERE


@dataclass(eq=False)
class Carried:
    """Variable carried by a loop: its name, first value and value for the next pass."""

    name: Name
    first: Operand
    next: Operand


@dataclass(eq=False)
class Loop:
    """Loop of at most `count` passes, which ends when `goes_on` is false.

    `goes_on` is computed by the `test` block. The counter begins with `start`, which leaves out the
    passes before.
    """

    count: int
    counter: Name
    carried: list[Carried]
    body: "Block"
    test: "Block"
    goes_on: Operand | None
    stacked: list[Table] = field(default_factory=list)
    source: Source = NOWHERE
    start: Operand = Number("index", 0)


@dataclass(eq=False)
class Branch:
    """Choice of one of several blocks by an index from 0; each block has values for the targets."""

    index: Operand
    blocks: list["Block"]
    values: list[list[Operand]]
    targets: list[Name]
    source: Source = NOWHERE


@dataclass(eq=False)
class Function:
    """Function of scalars; its results include `rows`, which are kept tables.

    It may also read arguments of the entry that calls it, which are `given` to it whole, and use
    `tables` of the function that calls it.
    """

    name: str
    parameters: list[Name]
    body: "Block"
    results: list[Operand]
    source: Source = NOWHERE
    rows: list[Table] = field(default_factory=list)
    given: list[str] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)


@dataclass(eq=False)
class Call:
    """Call of a function: targets = function(operands)."""

    function: Function
    operands: list[Operand]
    targets: list[Name]
    source: Source = NOWHERE


Statement = Assign | Fill | Store | Loop | Branch | Call
Block = list[Statement]


_WITH_BLOCKS = (Loop, Branch)


def inner_blocks(statement: Statement) -> list[Block]:
    """Blocks inside a statement; empty if it has none."""
    if isinstance(statement, Loop):
        return [statement.test, statement.body]
    return statement.blocks if isinstance(statement, Branch) else []


def statements(block: Block) -> Iterator[Statement]:
    """Statements of a block, each followed by the statements inside it."""
    collected: Block = []
    _collect(block, collected)
    return iter(collected)


def _collect(block: Block, collected: Block) -> None:
    # programs have 100 000 statements: generators inside generators take several times as long
    for statement in block:
        collected.append(statement)
        if isinstance(statement, _WITH_BLOCKS):
            for inner in inner_blocks(statement):
                _collect(inner, collected)
