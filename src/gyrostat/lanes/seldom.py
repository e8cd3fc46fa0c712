"""What is seldom needed is computed only where some lane needs it.

A select computes both of its sides. Where its test asks whether two real numbers are equal, as a
wheel's speed and zero, few lanes take the one side: all that leads to it alone becomes a branch,
which is skipped where no lane takes it.
"""

from collections.abc import Container, Iterable, Mapping

from gyrostat.lowering.program import (
    Assign,
    Block,
    Branch,
    Fill,
    Function,
    Loop,
    Name,
    Number,
    Operand,
    Statement,
    Store,
    inner_blocks,
)

_CHEAP = frozenset({"add", "sub", "mul", "neg", "abs", "max", "min", "sign", "select", "finite"})
_CHEAP |= frozenset({"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "xor", "not"})
_DEAR = 10
"""What another operation costs, in cheap ones."""
_LEAST = 12
"""Operations that a branch must save to be worth its test."""


def seldom(function: Function) -> None:
    """Move into branches, in place, what is seldom needed."""
    moving = _Moving(function)
    function.body = moving.block(function.body)


class _Moving:
    def __init__(self, function: Function) -> None:
        self._assigned: dict[Operand, Assign] = {}
        self._users: dict[Operand, set[int]] = {}
        self._learn(function.body)
        self._use(function, function.results)

    def _use(self, user: object, operands: Iterable[Operand | None]) -> None:
        for operand in operands:
            if isinstance(operand, Name):
                self._users.setdefault(operand, set()).add(id(user))

    def _learn(self, block: Block) -> None:
        for statement in block:
            match statement:
                case Assign(target, _, operands):
                    self._assigned[target] = statement
                    self._use(statement, operands)
                case Fill(values=values):
                    self._use(statement, values)
                case Store(index=index, value=value):
                    self._use(statement, (index, value))
                case Loop(carried=carried, goes_on=goes_on):
                    self._use(statement, [goes_on])
                    self._use(statement, [x for each in carried for x in (each.first, each.next)])
                case Branch(index=index, values=values):
                    self._use(statement, [index])
                    self._use(statement, [x for made in values for x in made])
            for inner in inner_blocks(statement):
                self._learn(inner)

    def block(self, block: Block) -> Block:
        """A block with branches in it."""
        for statement in block:
            if isinstance(statement, Loop):
                statement.body = self.block(statement.body)
            elif isinstance(statement, Branch):
                statement.blocks = [self.block(inner) for inner in statement.blocks]
        # the last first: what leads to it may hold others
        for selects in reversed(self._groups(block)):
            block = self._without(block, selects)
        return block

    def _groups(self, block: Block) -> list[dict[int, Assign]]:
        """Selects with a seldom side that are of one operation on arrays, by their ids."""
        found: dict[int, dict[int, Assign]] = {}
        for statement in block:
            if (
                isinstance(statement, Assign)
                and statement.operation == "select"
                and self._is_seldom(statement.operands[0])
            ):
                found.setdefault(statement.target.group, {})[id(statement)] = statement
        return list(found.values())

    def _is_seldom(self, test: Operand) -> bool:
        made = self._assigned.get(test)
        if made is None:
            return False
        if made.operation == "and":
            return any(self._is_seldom(part) for part in made.operands)
        if made.operation == "or":
            return all(self._is_seldom(part) for part in made.operands)
        return made.operation == "eq" and made.operands[0].kind == "real"

    def _without(self, block: Block, selects: Mapping[int, Assign]) -> Block:
        """A block in which what only the seldom sides of selects need is a branch before them."""
        places = {id(statement): place for place, statement in enumerate(block)}
        selects = {number: s for number, s in selects.items() if number in places}
        if not selects:  # they have moved with another
            return block
        first = min(places[number] for number in selects)
        sides = dict.fromkeys(s.operands[1] for s in selects.values())
        taken = set(selects)
        moved: list[Statement] = []
        cost = 0
        for statement in reversed(block[:first]):
            if isinstance(statement, Assign) and self._is_own(statement, selects, sides, taken):
                taken.add(id(statement))
                moved.append(statement)
                cost += 1 if statement.operation in _CHEAP else _DEAR
        if cost < _LEAST:
            return block
        moved.reverse()
        inside = {s.target for s in moved if isinstance(s, Assign)}
        given = [side for side in sides if side in inside]
        targets = [Name(side.kind, "", side.group, side.place) for side in given]
        tests: Block = []
        test = self._any(dict.fromkeys(s.operands[0] for s in selects.values()), tests)
        nothing: list[Operand] = [Number(target.kind, _NOTHING[target.kind]) for target in targets]
        branch = Branch(test, [[], moved], [nothing, list(given)], list(targets))
        self._use(branch, [test, *given])
        named: dict[Operand, Operand] = dict(zip(given, targets, strict=True))
        for select in selects.values():
            one, yes, no = select.operands
            select.operands = (one, named.get(yes, yes), no)
        left = [s for s in block[:first] if id(s) not in taken]
        return [*left, *tests, branch, *block[first:]]

    def _is_own(
        self,
        statement: Assign,
        selects: Mapping[int, Assign],
        sides: Container[Operand],
        taken: set[int],
    ) -> bool:
        """Whether a statement's target leads to the seldom sides of selects and nowhere else."""
        users, target = self._users.get(statement.target, set()), statement.target
        if not users or not users <= taken:
            return False
        direct = [selects[user] for user in users if user in selects]
        return not direct or (
            target in sides and not any(target in (s.operands[0], s.operands[2]) for s in direct)
        )

    def _any(self, tests: Iterable[Operand], block: Block) -> Operand:
        total, *others = tests
        for other in others:
            name = Name("logical")
            joined = Assign(name, "or", (total, other))
            self._assigned[name] = joined
            self._use(joined, joined.operands)
            block.append(joined)
            total = name
        return total


_NOTHING = {"real": 0.0, "integer": 0, "bits": 0, "logical": False}
