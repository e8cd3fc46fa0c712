"""Rarely taken branches: compute values that few lanes need only if a lane needs them.

A select computes both alternatives. If its test asks whether two real numbers are equal, such as a
wheel's speed and zero, few lanes take one of them. Everything that only this alternative needs
becomes a branch, which is skipped if no lane takes it.
"""

from collections.abc import Container, Iterable, Mapping

from gyrostat.codegen.dependencies import uses
from gyrostat.codegen.program import (
    Assign,
    Block,
    Branch,
    Function,
    Loop,
    Name,
    Number,
    Operand,
    Table,
    statements,
)

_CHEAP = frozenset({"add", "sub", "mul", "neg", "abs", "max", "min", "sign", "select", "finite"})
_CHEAP |= frozenset({"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "xor", "not"})
_DEAR = 10
"""Cost of an expensive operation, in cheap operations."""
_LEAST = 12
"""Smallest number of operations saved for which a branch is made."""


def branch_rarely_taken(function: Function) -> None:
    """Move rarely needed values into branches, in place."""
    moving = _Moving(function)
    function.body = moving.block(function.body)


class _Moving:
    def __init__(self, function: Function) -> None:
        assigned = (s for s in statements(function.body) if isinstance(s, Assign))
        self._assigned: dict[Operand, Assign] = {s.target: s for s in assigned}
        self._uses, self._results = uses(function), set(function.results)

    def block(self, block: Block) -> Block:
        """Block with rarely taken branches inserted."""
        for statement in block:
            if isinstance(statement, Loop):
                statement.body = self.block(statement.body)
            elif isinstance(statement, Branch):
                statement.blocks = [self.block(inner) for inner in statement.blocks]
        # from last to first: the operands of a select may contain other selects
        for selects in reversed(self._groups(block)):
            block = self._without(block, selects)
        return block

    def _groups(self, block: Block) -> list[dict[Name, Assign]]:
        """Selects with a rarely taken alternative, grouped by their array operation."""
        groups: dict[int, dict[Name, Assign]] = {}
        for statement in block:
            if (
                isinstance(statement, Assign)
                and statement.operation == "select"
                and self._is_rare(statement.operands[0])
            ):
                groups.setdefault(statement.target.group, {})[statement.target] = statement
        return list(groups.values())

    def _is_rare(self, test: Operand) -> bool:
        statement = self._assigned.get(test)
        if statement is None:
            return False
        if statement.operation == "and":
            return any(self._is_rare(part) for part in statement.operands)
        if statement.operation == "or":
            return all(self._is_rare(part) for part in statement.operands)
        return statement.operation == "eq" and statement.operands[0].kind == "real"

    def _without(self, block: Block, selects: Mapping[Name, Assign]) -> Block:
        """Block with the statements that only rarely taken alternatives need in a branch."""
        indices = {s.target: index for index, s in enumerate(block) if isinstance(s, Assign)}
        selects = {target: s for target, s in selects.items() if target in indices}
        if not selects:  # moved together with another group
            return block
        first = min(indices[target] for target in selects)
        sides = dict.fromkeys(s.operands[1] for s in selects.values())
        names: set[Name | Table] = set(selects)
        assignments: list[Assign] = []
        cost = 0
        for statement in reversed(block[:first]):
            if isinstance(statement, Assign) and self._is_local(statement, selects, sides, names):
                names.add(statement.target)
                assignments.append(statement)
                cost += 1 if statement.operation in _CHEAP else _DEAR
        if cost < _LEAST:
            return block
        assignments.reverse()
        inner = {statement.target for statement in assignments}
        outputs = [side for side in sides if side in inner]
        targets = [Name(side.kind, "", side.group, side.place) for side in outputs]
        tests: Block = []
        test = self._any(dict.fromkeys(s.operands[0] for s in selects.values()), tests)
        defaults: list[Operand] = [Number(target.kind, _NOTHING[target.kind]) for target in targets]
        for operand in (test, *outputs):
            self._uses[operand].update(targets)
        replacements: dict[Operand, Operand] = dict(zip(outputs, targets, strict=True))
        for select in selects.values():
            condition, yes, no = select.operands
            select.operands = (condition, replacements.get(yes, yes), no)
        before = [s for s in block[:first] if not isinstance(s, Assign) or s.target not in inner]
        branch = Branch(test, [[], [*assignments]], [defaults, list(outputs)], list(targets))
        return [*before, *tests, branch, *block[first:]]

    def _is_local(
        self,
        statement: Assign,
        selects: Mapping[Name, Assign],
        sides: Container[Operand],
        names: set[Name | Table],
    ) -> bool:
        """Whether a statement is used only by the rarely taken alternatives of selects."""
        target, table = statement.target, statement.table
        if table is not None and table.changes:
            return False
        users = self._uses.get(target, set())
        if not users or target in self._results or not users <= names:
            return False
        direct = [select for name, select in selects.items() if name in users]
        return not direct or (
            target in sides and not any(target in (s.operands[0], s.operands[2]) for s in direct)
        )

    def _any(self, tests: Iterable[Operand], block: Block) -> Operand:
        total, *remaining = tests
        for test in remaining:
            name = Name("logical")
            statement = Assign(name, "or", (total, test))
            self._assigned[name] = statement
            self._uses[name] = set()
            for operand in statement.operands:
                self._uses[operand].add(name)
            block.append(statement)
            total = name
        return total


_NOTHING = {"real": 0.0, "integer": 0, "bits": 0, "logical": False}
