"""Constant tables of a module: their columns that are read, and those that functions share."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from gyrostat.codegen.arrays import SMALL
from gyrostat.codegen.dependencies import read_by
from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.program import Assign, Block, Function, Name, Number, Table, statements


def constant_tables(block: Block) -> list[Table]:
    """Constant tables that a block reads, each once."""
    read = (each.table for each in statements(block) if isinstance(each, Assign))
    return [table for table in dict.fromkeys(read) if table is not None and table.values]


def shared_tables(functions: Iterable[Function]) -> list[Table]:
    """Constant tables that two or more functions read."""
    readers = Counter(table for each in functions for table in constant_tables(each.body))
    return [table for table, count in readers.items() if count > 1]


def declared(table: Table, name: str, dialect: Dialect) -> str:
    """C declaration of a constant table."""
    numbers = (dialect.number(Number(table.kind, value)).text for value in table.values)
    elements = ", ".join(numbers)
    return f"static const {dialect.type_of(table.kind)} {name}[{table.size}] = {{{elements}}};"


class _Read(NamedTuple):
    """Reading of a table at `stride * row + column`.

    Attributes:
        read: Statement that reads the element.
        added: Statement that adds the column; None for column 0.
        start: Statement that multiplies the row.
        column: Column; from the number of columns on, one of a later row.
    """

    read: Assign
    added: Assign | None
    start: Assign
    column: int

    @property
    def stride(self) -> int:
        """Number of columns."""
        return int(next(o.value for o in self.start.operands if isinstance(o, Number)))


def leave_out_columns(functions: Sequence[Function]) -> bool:
    """Leave out, in place, the columns of large constant tables that nothing reads.

    The rows of such a table are read at a computed index, each column at a known distance: so are
    both ends of a piece of splines of many quantities, of which a controller needs a few.

    Args:
        functions: All functions of a module.

    Returns:
        Whether a table has changed; statements may be left that nothing needs.
    """
    every = [each for function in functions for each in statements(function.body)]
    definitions = {each.target: each for each in every if isinstance(each, Assign)}
    uses = Counter(o for each in every for o in read_by(each) if isinstance(o, Name))
    uses.update(o for f in functions for o in f.results if isinstance(o, Name))
    reads: dict[Table, list[_Read | None]] = {}
    for each in every:
        if isinstance(each, Assign) and each.table is not None and each.table.values:
            reads.setdefault(each.table, []).append(_read(each, definitions))
    changes = [_leave_out(table, found, uses) for table, found in reads.items()]
    return any(changes)


def _read(statement: Assign, definitions: dict[Name, Assign]) -> _Read | None:
    """Row and column of a reading; None if they are not found."""
    index = statement.operands[0]
    added = definitions.get(index) if isinstance(index, Name) else None
    if added is None or added.operation != "add":
        start, added, column = added, None, 0
    else:
        base, distance = added.operands
        start = definitions.get(base) if isinstance(base, Name) else None
        if not isinstance(distance, Number):
            return None
        column = int(distance.value)
    if start is None or start.operation != "mul" or start.target.kind != "index":
        return None
    if sum(isinstance(operand, Number) for operand in start.operands) != 1:
        return None
    return _Read(statement, added, start, column)


def _leave_out(table: Table, found: Sequence[_Read | None], uses: Counter[Name]) -> bool:
    reads = [each for each in found if each is not None]
    if table.size <= SMALL or len(reads) < len(found):
        return False
    (stride, *others) = {each.stride for each in reads}
    columns = sorted({each.column % stride for each in reads})
    if others or table.size % stride or any(each.column < 0 for each in reads):
        return False
    # nothing else may read these indices
    expected: Counter[Name] = Counter()
    starts = {id(each.start): each.start for each in reads}
    for each in {id(e.added or e.read): e.added or e.read for e in reads}.values():
        expected[_start(each)] += 1
    expected.update(each.added.target for each in reads if each.added is not None)
    if len(columns) == stride or any(uses[name] != count for name, count in expected.items()):
        return False
    rows = range(0, table.size, stride)
    table.values = tuple(table.values[row + column] for row in rows for column in columns)
    table.size = len(table.values)
    for start in starts.values():
        start.operands = tuple(
            Number(o.kind, len(columns)) if isinstance(o, Number) else o for o in start.operands
        )
    for each in reads:
        later, left = divmod(each.column, stride)
        column = Number("index", later * len(columns) + columns.index(left))
        if column.value == 0:
            each.read.operands = (each.start.target,)
        elif each.added is not None:
            each.added.operands = (each.start.target, column)
    return True


def _start(statement: Assign) -> Name:
    """Index of the row that a reading, or the addition of its column, begins from."""
    name = statement.operands[0]
    assert isinstance(name, Name)
    return name
