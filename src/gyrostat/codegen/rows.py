"""Scalars that a loop computes for each row of an array, such as each direction of a derivative.

`Row(loop, name, number)` is what the body of the loop calls `name`, in the pass with that number.
Equal operations on the scalars of all rows are one statement of the body.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from gyrostat.codegen.program import (
    Assign,
    Block,
    Fill,
    Kind,
    Loop,
    Name,
    Number,
    Operand,
    Store,
    Table,
)
from gyrostat.codegen.source import Source


@dataclass(eq=False)
class RowLoop:
    """Loop over rows that is being built.

    Attributes:
        block: Block that contains the loop.
        loop: The loop.
        known: Operation and operands -> the result in the body.
        names: Names that the body assigns.
        tables: Name -> table of its values in all passes.
        places: Name -> table with its values, index of that of the first pass, and distance.
        is_open: Whether the loop is not in its block yet, so that its body can read all that is.
    """

    block: Block
    loop: Loop
    known: dict[Any, Operand] = field(default_factory=dict)
    names: set[Operand] = field(default_factory=set)
    tables: dict[Name, Table] = field(default_factory=dict)
    places: dict[Name, tuple[Table, int, int]] = field(default_factory=dict)
    is_open: bool = True

    def close(self) -> None:
        """Append the loop to its block."""
        if self.is_open:
            self.block.append(self.loop)
            self.is_open = False

    def computed(
        self, number: int, key: Any, compute: Callable[[Block], Operand]
    ) -> "Operand | Row":
        """Row of a result that the body has or that is appended to it."""
        if key not in self.known:
            length = len(self.loop.body)
            result = compute(self.loop.body)
            if len(self.loop.body) > length:
                self.names.add(result)
            self.known[key] = result
        result = self.known[key]
        return Row(self, result, number) if result in self.names else result

    def table(self, name: Name) -> Table:
        """Table of the values of a name, which are read after the loop."""
        self.close()
        if name not in self.tables:
            table = Table(name.kind, self.loop.count, name.hint)
            self.tables[name] = table
            self.declare(table, self.loop.source)
            self.store(name, table, lambda *_: self.loop.counter)
        return self.tables[name]

    def store(self, name: Name, table: Table, index: Callable[[Block, Source], Operand]) -> None:
        """Assign a name to an element of a table, where the body computes it.

        Args:
            name: Name that the body assigns.
            table: Table.
            index: Function that appends the computation of the index to a block, with a line of
                Python.
        """
        body = self.loop.body
        for place, each in enumerate(body):
            if isinstance(each, Assign) and each.target is name:
                inside: Block = []
                inside.append(Store(table, (index(inside, each.source),), name, each.source))
                body[place + 1 : place + 1] = inside
                return

    def declare(self, table: Table, source: Source) -> None:
        """Declare a table before the loop."""
        place = next(k for k, each in enumerate(self.block) if each is self.loop)
        self.block.insert(place, Fill(table, (), source))


@dataclass(frozen=True)
class Row:
    """Scalar of one row: the value of a name in one pass of a loop."""

    loop: RowLoop
    name: Any
    number: int

    @property
    def kind(self) -> Kind:
        """Kind of number."""
        return self.name.kind


def assigned(build: Any, operation: str, operands: Sequence[Any], target: Name) -> Any:
    """Result of an operation on scalars of rows: that of the row, if they are of one.

    Args:
        build: Builder that appends to the block of the loop.
        operation: Name of the operation.
        operands: Operands, some of which are scalars of rows.
        target: Name for the result.
    """
    rows = [each for each in operands if isinstance(each, Row)]
    loop, number = rows[0].loop, rows[0].number
    is_one = all(each.loop is loop and each.number == number for each in rows)
    if not is_one or loop.block is not build.block or not loop.is_open:
        return build.assign(operation, [read(build, each) for each in operands], target)
    inner = [each.name if isinstance(each, Row) else each for each in operands]
    key = operation, target.kind, *map(operand_key, inner)
    name = Name(target.kind, target.hint, target.group)
    return loop.computed(
        number, key, lambda body: build.inside(body).assign(operation, inner, name)
    )


def operand_key(operand: Operand) -> Any:
    """Key that is equal for equal operands."""
    return (operand.kind, repr(operand.value)) if isinstance(operand, Number) else operand


def read(build: Any, operand: Any) -> Any:
    """Scalar of a row, read from a table after the loop; another operand remains."""
    if not isinstance(operand, Row):
        return operand
    table = operand.loop.table(operand.name)
    name = Name(operand.kind, operand.name.hint, next(build.groups))
    return build.element(table, Number("index", operand.number), 0, name)
