"""Parts of long functions as functions of their own, which are called once.

Reviewers and tools read a function as a whole. A compiler puts a static function that is called
once back where it is called, up to its limit on the growth of the caller.
"""

import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

from gyrostat.codegen.dependencies import read_by
from gyrostat.codegen.flight.tested_sums import TESTED_AND, TESTED_FINITE
from gyrostat.codegen.given import argument
from gyrostat.codegen.program import (
    Assign,
    Block,
    Branch,
    Call,
    Fill,
    Function,
    Loop,
    Name,
    Operand,
    Statement,
    Store,
    Table,
    statements,
)
from gyrostat.codegen.program_cost import cost_of

LONGEST = 4000
"""Largest size of a function that is left as it is; static analysis does not end on longer ones."""
PART = 1000
"""Largest size of a part."""
LEAST = 25
"""Least size of a part."""
MOST = 60
"""Largest number of scalars and tables that a part gets and gives back."""
WHOLE = 100
"""Largest number of statements of a line of Python that stay together."""

_Value = Name | Table
_Tests = Collection[Operand]


def outline(function: Function) -> list[Function]:
    """Move parts of a long function to functions of their own, in place.

    Args:
        function: Function.

    Returns:
        The parts, each after those that it calls; none of a short function.
    """
    parts: list[Function] = []
    tests = _tests_of_finiteness(function.body)
    if _size(function.body) > LONGEST:
        _shorten(function.body, function.results, PART, tests, parts)
    for part in parts:
        part.name = part.name or function.name
    return parts


def _tests_of_finiteness(block: Block) -> set[Operand]:
    """Logical values that depend on whether numbers are finite."""
    tests: set[Operand] = set()
    for each in statements(block):
        if isinstance(each, Assign) and each.target.kind == "logical":
            is_test = each.operation in ("finite", TESTED_FINITE)
            tests |= {each.target} if is_test or not tests.isdisjoint(each.operands) else set()
    return tests


def _shorten(
    block: Block, results: Sequence[Operand], most: int, tests: _Tests, parts: list[Function]
) -> None:
    """Cut a block that is longer than `most`, and such blocks inside it; add the parts."""
    for statement in block:
        size = _size([statement])
        if size > most:
            for inner, ends in _blocks_inside(statement):
                _shorten(inner, ends, most * _size(inner) // size, tests, parts)
    if _size(block) > most:
        block[:] = _cut(block, results, tests, parts)


def _size(block: Block) -> int:
    return cost_of(block).size


def _blocks_inside(statement: Statement) -> list[tuple[Block, list[Operand]]]:
    """Blocks inside a statement, with the operands that are read at their ends.

    The test of a loop is left out, because the body may read its values too.
    """
    if isinstance(statement, Loop):
        return [(statement.body, [each.next for each in statement.carried])]
    is_branch = isinstance(statement, Branch)
    return [*zip(statement.blocks, statement.values, strict=True)] if is_branch else []


def _cut(block: Block, results: Sequence[Operand], tests: _Tests, parts: list[Function]) -> Block:
    """Block with calls of parts in the place of their statements; add the parts.

    Of all ways to choose the parts, this one leaves the fewest statements, calls and arguments.
    """
    groups = [_Group.of(each) for each in _groups(block)]
    last: dict[_Value, int] = {}
    for number, group in enumerate(groups):
        last.update(dict.fromkeys(group.used, number))
    last.update((each, len(groups)) for each in results if isinstance(each, Name))
    # what is left of the groups before each end, and the span that ends there if there is one
    best: list[tuple[int, _Span | None]] = [(0, None)]
    for end, group in enumerate(groups, 1):
        choice = best[-1][0] + group.size, None
        span = _Span()
        for start in range(end - 1, -1, -1):
            span = span.extended(groups[start], last, end)
            if span.size > PART:
                break
            left = best[start][0] + 1 + span.width
            if left < choice[0] and span.is_allowed(tests):
                choice = left, span
        best.append(choice)
    pieces: list[_Span | _Group] = []
    end = len(groups)
    while end > 0:
        span = best[end][1]
        pieces.append(groups[end - 1] if span is None else span)
        end -= 1 if span is None else len(span.groups)
    new: Block = []
    for piece in reversed(pieces):
        new += piece.block if isinstance(piece, _Group) else piece.moved(parts)
    return new


def _groups(block: Block) -> Iterator[Block]:
    """Statements that stay together, because a line of Python is written as few expressions.

    A line with many statements is one group for each of its operations.
    """
    for _, each in groupby(block, lambda statement: statement.source):
        line = [*each]
        if _size(line) <= WHOLE:
            yield line
        else:
            yield from ([*part] for _, part in groupby(line, _operation))


def _operation(statement: Statement) -> object:
    """Operation on arrays that a statement is part of."""
    return statement.target.group if isinstance(statement, Assign) else statement


@dataclass(frozen=True)
class _Group:
    """Statements that stay together.

    Attributes:
        block: The statements.
        size: Their size.
        used: Scalars and tables from before that they use, in order.
        declared: Scalars and tables that they declare, and the statements that do so.
        stays: Whether they cannot be in a part: they read a number that an entry gets by its
            address, or test a sum, whose annotations keep states apart until the function ends.
    """

    block: Block
    size: int
    used: list[_Value]
    declared: Mapping[_Value, Statement]
    stays: bool

    @classmethod
    def of(cls, block: Block) -> "_Group":
        """Group of some statements."""
        declared = {value: each for each in block for value in _declared(each)}
        used = dict.fromkeys(value for each in block for value in _used(each))
        stays = any(map(_stays, statements(block)))
        used = [value for value in used if value not in declared]
        return cls(block, _size(block), used, declared, stays)


@dataclass(frozen=True)
class _Span:
    """Groups that follow each other and may become a part.

    Attributes:
        groups: The groups.
        inputs: Scalars and tables from before that they use, in order.
        outputs: Those that they declare and that are used later, with their declarations.
        size: Size of the statements.
    """

    groups: tuple[_Group, ...] = ()
    inputs: Mapping[_Value, None] = field(default_factory=dict)
    outputs: Mapping[_Value, Statement] = field(default_factory=dict)
    size: int = 0

    def extended(self, front: _Group, last: Mapping[_Value, int], end: int) -> "_Span":
        """Span with one more group in front; `last` are the groups of the last uses of values."""
        inputs = dict.fromkeys((*front.used, *self.inputs))
        outputs = {v: each for v, each in front.declared.items() if last.get(v, -1) >= end}
        return _Span(
            (front, *self.groups),
            {value: None for value in inputs if value not in front.declared},
            {**outputs, **self.outputs},
            self.size + front.size,
        )

    @property
    def width(self) -> int:
        return len(self.inputs) + len(self.outputs)

    def is_allowed(self, tests: _Tests) -> bool:
        """Whether the groups may become a part.

        Static analysis knows what a test says about numbers in the function of the test alone.
        """
        return (
            self.size >= LEAST
            and self.width <= MOST
            and not any(each.stays for each in self.groups)
            and not any(each in tests for each in self.outputs)
            and all(map(_can_be_outside, self.outputs, self.outputs.values()))
        )

    def moved(self, parts: list[Function]) -> Block:
        """Call of a new part, after the tables that it fills for others; add the part."""
        block = [statement for group in self.groups for statement in group.block]
        tables = [each for each in block if isinstance(each, Fill) and each.table in self.outputs]
        body = [each for each in block if each not in tables]
        names = Counter(_python_name(each) for each in statements(body))
        name = max(names, key=lambda each: (each != "", names[each]))
        source = next(each.source for each in statements(body) if _python_name(each) == name)
        parameters = [each for each in self.inputs if isinstance(each, Name)]
        results = [each for each in self.outputs if isinstance(each, Name)]
        shared = [each for each in (*self.inputs, *self.outputs) if isinstance(each, Table)]
        part = Function(name, parameters, body, [*results], source, tables=shared)
        parts.append(part)
        return [*tables, Call(part, [*parameters], results, source)]


def _python_name(statement: Statement) -> str:
    """Name in C for what a statement comes from: its function in Python, or a callable class."""
    source = statement.source
    names = [each for each in source.definition.name.split(".") if not each.startswith("__")]
    name = (names or [source.part])[-1].strip("_")
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def _stays(statement: Statement) -> bool:
    if isinstance(statement, Assign) and statement.operation in (TESTED_FINITE, TESTED_AND):
        return True
    return any(
        isinstance(each, Name) and each.fixed and argument(each) is None
        for each in read_by(statement)
    )


def _can_be_outside(value: _Value, declaration: Statement) -> bool:
    is_empty = isinstance(declaration, Fill) and not declaration.values
    return isinstance(value, Name) or is_empty


def _declared(statement: Statement) -> list[_Value]:
    """Scalars and tables that statements after one may use."""
    match statement:
        case Assign(target=target):
            return [target]
        case Fill(table=table):
            return [table]
        case Loop(carried=carried, stacked=stacked):
            return [*(each.name for each in carried), *stacked]
        case Branch(targets=targets) | Call(targets=targets):
            return [*targets]
        case _:
            return []


def _used(statement: Statement) -> list[_Value]:
    """Scalars and tables from before a statement that it and those inside it use."""
    used: dict[_Value, None] = {}
    inner: set[_Value] = set()
    for each in statements([statement]):
        names = (o for o in read_by(each) if isinstance(o, Name) and not o.fixed)
        used.update(dict.fromkeys(names))
        if isinstance(each, Assign | Store) and each.table is not None:
            is_local = not (each.table.values or each.table.shape)
            used.update({each.table: None} if is_local else {})
        if isinstance(each, Call):
            used.update(dict.fromkeys(each.function.tables))
        if isinstance(each, Loop):
            inner.add(each.counter)
        inner.update(_declared(each))
    return [value for value in used if value not in inner]
