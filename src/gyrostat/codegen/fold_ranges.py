"""Ranges of integers decide comparisons, so that what they never give is not in the code.

An index that is chosen from known ones, or counted by a loop, is within the array that it is an
index of: the tests that would bring it there are never true. The same holds for a test of which the
outcome is known where a branch was taken, and for an index that the branch or a choice limits.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from gyrostat.codegen.carried_numbers import counted, counts_of
from gyrostat.codegen.constants import folded
from gyrostat.codegen.outcomes import decided, implies
from gyrostat.codegen.program import (
    ZERO,
    Assign,
    Block,
    Branch,
    Call,
    Fill,
    Function,
    Kind,
    Loop,
    Name,
    Number,
    Operand,
    Statement,
    Store,
)
from gyrostat.codegen.ranges import (
    ALWAYS,
    ARITHMETIC,
    EVERY,
    MIRRORED,
    OPPOSITE,
    UNCHANGED,
    Range,
    narrowed,
    of_kind,
    union,
    within,
)
from gyrostat.codegen.signs import Signs
from gyrostat.codegen.stored_ranges import Stored, stored_ranges

TRUE, FIRST = Number("logical", True), Number("index", 0)
ROUNDS = 10
"""Largest number of times that ranges of what is stored give others; those of any round hold."""


def fold_ranges(function: Function) -> None:
    """Replace comparisons that are always true or false by their outcome, in place.

    Statements that become unused remain.
    """
    stored: dict[Stored, Range] = {}
    for _ in range(ROUNDS):
        facts = _Facts(stored)
        function.body = facts.block(function.body)
        function.results = facts.known_as(function.results)
        ranges = stored_ranges(function, facts.ranges)
        if ranges == stored:
            return
        stored = ranges


class _Facts:
    """What is known of the values of a function, up to a statement.

    Attributes:
        ranges: Ranges of integers.
    """

    def __init__(self, stored: Mapping[Stored, Range]) -> None:
        self.ranges: dict[Name, Range] = {}
        self._stored = stored
        self._same: dict[Name, Operand] = {}
        self._assigned: dict[Name, Assign] = {}
        self._signs = Signs(self._assigned)

    def known_as(self, operands: Iterable[Operand]) -> list[Operand]:
        """Operands, with each one that has a known value replaced by it."""
        return [self._same.get(o, o) if isinstance(o, Name) else o for o in operands]

    def _one(self, operand: Operand) -> Operand:
        return self.known_as([operand])[0]

    def block(self, block: Block) -> Block:
        """Statements of a block, without branches of which one side is always taken."""
        remaining: Block = []
        for statement in block:
            remaining += self._statement(statement)
        return remaining

    def _statement(self, statement: Statement) -> Sequence[Statement]:
        match statement:
            case Assign():
                return self._assign(statement)
            case Fill():
                statement.values = tuple(self.known_as(statement.values))
            case Store():
                statement.indices = tuple(self.known_as(statement.indices))
                statement.value = self._one(statement.value)
            case Call():
                statement.operands = self.known_as(statement.operands)
            case Loop():
                return self._loop(statement)
            case Branch():
                return self._branch(statement)
        return (statement,)

    def _assign(self, statement: Assign) -> Sequence[Statement]:
        operands = statement.operands = tuple(self.known_as(statement.operands))
        same = self._simpler(statement.operation, operands, statement.target.kind)
        if same is not None:
            self._same[statement.target] = same
            return ()
        self._assigned[statement.target] = statement
        self._signs.add(statement)
        found = self._result(statement)
        if found is not None and found != EVERY:
            self.ranges[statement.target] = found
            if found[0] == found[1]:
                self._same[statement.target] = Number(statement.target.kind, found[0])
        return (statement,)

    def _simpler(self, operation: str, operands: Sequence[Operand], kind: Kind) -> Operand | None:
        """Number or operand that an operation always gives; None if there is none."""
        if operation in ALWAYS:
            ranges = [self._range(operand) for operand in operands]
            if ranges[0] is not None and ranges[1] is not None:
                for name, value in ((operation, True), (OPPOSITE[operation], False)):
                    if ALWAYS[name](ranges[0], ranges[1]):
                        return Number("logical", value)
        # NaN compares as false too
        is_below_zero = operation == "lt" and operands[1] == ZERO
        if is_below_zero and self._signs.has_none(operands[0]):
            return Number("logical", False)
        if operation == "to_index":
            made = self._assigned.get(operands[0]) if isinstance(operands[0], Name) else None
            if (
                made is not None
                and made.operation == "to_integer"
                and made.operands[0].kind == "index"
            ):
                return made.operands[0]
        if operation == "sub" and repr(operands[1]) == repr(ZERO):
            return operands[0]
        if operation == "add" and FIRST in operands:
            return operands[1] if operands[0] == FIRST else operands[0]
        if operation in UNCHANGED and within(self._range(operands[0]), UNCHANGED[operation]):
            return operands[0]
        if operation == "and":
            for one, other in (operands, operands[::-1]):
                if implies(one, other, self._assigned):
                    return one
        is_choice = kind == "logical" or operation == "select"
        return folded(operation, operands, kind) if is_choice else None

    def _range(self, operand: Operand) -> Range | None:
        """Range of an integer; None for other numbers, and where counters of loops have none."""
        if isinstance(operand, Name):
            return self.ranges.get(operand, EVERY if operand.kind == "integer" else None)
        if operand.kind in ("integer", "index"):
            return int(operand.value), int(operand.value)
        return None

    def _result(self, statement: Assign) -> Range | None:
        """Range of the result of an operation on integers; None if it may be any number."""
        operation, operands, kind = statement.operation, statement.operands, statement.target.kind
        if kind not in ("integer", "index"):
            return None
        if statement.table is not None:
            values = statement.table.values
            limits = (int(min(values)), int(max(values))) if values else None
            return limits or self._stored.get(statement.table)
        if operation in ("to_integer", "to_index") and operands[0].kind == "logical":
            return 0, 1
        ranges = [self._range(operand) for operand in operands]
        if operation in UNCHANGED:
            return UNCHANGED[operation]
        if operation in ("to_integer", "to_index", "copy"):
            return None if ranges[0] is None else of_kind(ranges[0], kind)
        if operation == "select":
            return union([self._range_if(operands[0], bool(k), operands[2 - k]) for k in (1, 0)])
        if operation not in ARITHMETIC or ranges[0] is None or ranges[1] is None:
            return None
        ends = ARITHMETIC[operation](ranges[0], ranges[1])
        return of_kind((min(ends), max(ends)), kind)

    def _range_if(self, test: Operand, outcome: bool, value: Operand) -> Range | None:
        """Range of a value where a test has an outcome."""
        with self._where(test, outcome):
            made = self._assigned.get(value) if isinstance(value, Name) else None
            narrow = self._result(made) if made and made.operation in ARITHMETIC else None
            known = self._range(value)
            if narrow is None or known is None:
                return narrow or known
            return max(narrow[0], known[0]), min(narrow[1], known[1])

    @contextmanager
    def _where(self, test: Operand, outcome: bool) -> Iterator[None]:
        """Narrow the ranges of numbers to what they are where a test has an outcome."""
        before: dict[Name, Range | None] = {}
        for name, narrow in self._implied(test, outcome):
            before.setdefault(name, self.ranges.get(name))
            self.ranges[name] = narrow
        yield
        for name, range_ in before.items():
            if range_ is None:
                del self.ranges[name]
            else:
                self.ranges[name] = range_

    def _implied(self, test: Operand, outcome: bool) -> Iterator[tuple[Name, Range]]:
        """Ranges of the numbers that a test compares, where it has an outcome."""
        for statement, is_true in decided(test, outcome, self._assigned):
            operation = statement.operation
            if operation not in OPPOSITE:
                continue
            operation = operation if is_true else OPPOSITE[operation]
            one, other = statement.operands
            for name, relation, limit in (
                (one, operation, other),
                (other, MIRRORED[operation], one),
            ):
                range_, bound = self._range(name), self._range(limit)
                if isinstance(name, Name) and range_ is not None and bound is not None:
                    yield name, narrowed(range_, relation, bound)

    def _loop(self, loop: Loop) -> Sequence[Statement]:
        for each in loop.carried:
            each.first = self._one(each.first)
        loop.start = self._one(loop.start)
        self.ranges[loop.counter] = (0, max(loop.count - 1, 0))
        counts = counts_of(loop)
        for name, first in counts.items():
            self.ranges[name] = (first, first + max(loop.count - 1, 0))
        for each in loop.carried:
            if each.name in self._stored:
                self.ranges[each.name] = self._stored[each.name]
        outer = dict(self._same)
        for name, first in counts.items():
            if name.kind == "integer" and loop.start == FIRST:
                begin = counted(loop, name, first)
                (loop.body if loop.goes_on is None else loop.test)[:0] = begin
                self._same[name] = begin[-1].target
        loop.test = self.block(loop.test)
        goes_on = TRUE if loop.goes_on is None else self._one(loop.goes_on)
        if isinstance(goes_on, Number) and not goes_on.value:  # there is no pass
            self._same = outer | {each.name: each.first for each in loop.carried}
            return ()
        if goes_on == TRUE:  # the count alone ends the loop
            loop.body, loop.test = [*loop.test, *loop.body], []
        loop.goes_on = None if goes_on == TRUE else goes_on
        with self._assuming(goes_on, True):
            loop.body = self.block(loop.body)
            for each in loop.carried:
                each.next = self._one(each.next)
        self._same = outer
        # behind the loop, a count may have reached its end
        for name, first in counts.items():
            self.ranges[name] = (first, first + loop.count)
        return (loop,)

    def _branch(self, branch: Branch) -> Sequence[Statement]:
        branch.index = index = self._one(branch.index)
        if isinstance(index, Number):
            number = min(max(int(index.value), 0), len(branch.blocks) - 1)
            remaining = self.block(branch.blocks[number])
            chosen = self.known_as(branch.values[number])
            self._same.update(zip(branch.targets, chosen, strict=True))
            return remaining
        ranges: list[list[Range | None]] = []
        for number, block in enumerate(branch.blocks):
            is_two_way = index.kind == "logical"
            known, outcome = (index, bool(number)) if is_two_way else (TRUE, True)
            with self._assuming(known, outcome):
                branch.blocks[number] = self.block(block)
                branch.values[number] = self.known_as(branch.values[number])
                ranges.append([self._range(value) for value in branch.values[number]])
        for target, *choices in zip(branch.targets, *ranges, strict=True):
            found = union(choices)
            if found is not None and found != EVERY:
                self.ranges[target] = found
        return (branch,)

    @contextmanager
    def _assuming(self, operand: Operand, value: bool) -> Iterator[None]:
        """Take a logical value as known, with the operands that it decides, and restore it."""
        outer = dict(self._same)
        if isinstance(operand, Name):
            self._same[operand] = Number("logical", value)
        for statement, is_true in decided(operand, value, self._assigned):
            self._same[statement.target] = Number("logical", is_true)
        with self._where(operand, value):
            yield
        self._same = outer
