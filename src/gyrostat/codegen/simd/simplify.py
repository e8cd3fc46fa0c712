"""Remove redundant arithmetic from a program for SIMD lanes.

Common subexpressions are computed once. Products with constant zeros and ones are removed.
Divisions by constants and by loop invariants become products.

Results may change by rounding, which comparisons may reflect. A quotient that is then rounded to an
integer does not change, unless a loop carries it to the rounding. A product with a constant zero no
longer propagates NaN or infinity, the sign of a zero may change, and divisors beyond 2^1022 count
as infinite.
"""

from collections import Counter
from collections.abc import Sequence

from gyrostat.codegen.dependencies import dependencies, reached
from gyrostat.codegen.program import (
    ONE,
    Assign,
    Block,
    Branch,
    Carried,
    Fill,
    Function,
    Loop,
    Name,
    Number,
    Operand,
    Statement,
    Store,
    Table,
    statements,
)
from gyrostat.codegen.simd.algebra import key, simpler

_WHOLE = frozenset({"floor", "ceil", "round", "rint", "fmod", "to_integer", "to_bits"})
_ARITHMETIC = frozenset({"add", "sub", "mul", "div", "neg", "abs", "max", "min", "sqrt"})
_ARITHMETIC |= frozenset({"select", "element"})
_COMMUTATIVE = frozenset({"add", "mul", "and", "or", "xor"})


def simplify(function: Function) -> None:
    """Simplify a function without calls, in place; statements that become unused remain."""
    assigned = [s for s in statements(function.body) if isinstance(s, Assign)]
    divided_by = Counter(s.operands[1] for s in assigned if s.operation == "div")
    values = _Values(divided_by, _exact(function))
    function.body = values.block(function.body)
    function.results = values.known_as(function.results)


def _exact(function: Function) -> set[Name | Table]:
    """Values that are rounded to integers: the last bit of a quotient may change floor(t / s)."""
    steps, roots = dependencies([function]), []
    for statement in statements(function.body):
        match statement:
            case Assign(target, operation, operands) if operation not in _ARITHMETIC:
                del steps[target]
                roots += operands if operation in _WHOLE else ()
            case Loop(carried=carried):  # otherwise all values of a loop would be exact
                for each in carried:
                    del steps[each.name]
    return reached(roots, steps)


class _Scope:
    """Block in progress: its results so far, and whether it belongs to a loop."""

    def __init__(self, *, loops: bool = False) -> None:
        self.made: Block = []
        self.computed: dict[tuple[object, ...], Name] = {}
        self.loops = loops


class _Values:
    def __init__(self, divided_by: Counter[Operand], exact: set[Name | Table]) -> None:
        self._divided_by, self._exact = divided_by, exact
        self._scopes: list[_Scope] = []
        self._same: dict[Name, Operand] = {}
        self._assigned: dict[Operand, Assign] = {}
        self._depth: dict[Operand, int] = {}
        self._filled: dict[Table, tuple[Operand, ...]] = {}

    def block(self, block: Block) -> Block:
        """Block that belongs to no loop."""
        return self._blocks([block], [], loops=False)[0]

    def _blocks(self, blocks: Sequence[Block], names: Sequence[Name], *, loops: bool):
        """Blocks in sequence; each may read the results of earlier ones; `names` are new."""
        scope = _Scope(loops=loops)
        self._scopes.append(scope)
        self._depth.update(dict.fromkeys(names, len(self._scopes)))
        results: list[Block] = []
        for block in blocks:
            scope.made = []
            for statement in block:
                self._statement(statement)
            results.append(scope.made)
        self._scopes.pop()
        return results

    def known_as(self, operands: Sequence[Operand]) -> list[Operand]:
        """Operands with each one replaced by an equal value computed earlier."""
        return [self._same.get(o, o) if isinstance(o, Name) else o for o in operands]

    def _resolve(self, operand: Operand) -> Operand:
        return self.known_as([operand])[0]

    def _add(self, statement: Statement, *names: Name) -> None:
        self._scopes[-1].made.append(statement)
        self._depth.update(dict.fromkeys(names, len(self._scopes)))

    def _statement(self, statement: Statement) -> None:
        match statement:
            case Assign():
                self._assign(statement)
            case Fill(table, values):
                statement.values = tuple(self.known_as(values))
                if values:
                    self._filled[table] = statement.values
                self._add(statement)
            case Store():
                statement.value = self._resolve(statement.value)
                statement.indices = tuple(self.known_as(statement.indices))
                self._add(statement)
            case Loop():
                self._loop(statement)
            case Branch():
                self._branch(statement)
            case _:
                raise TypeError(f"found {type(statement).__name__}, expected it lowered in place")

    def _loop(self, loop: Loop) -> None:
        loop.start = self._resolve(loop.start)
        carried: list[Carried] = []
        twins: dict[tuple[object, ...], Name] = {}
        for each in loop.carried:
            each.first = self._resolve(each.first)
            if each.next is each.name:
                self._same[each.name] = each.first
                continue
            twin = twins.setdefault((key(each.first), key(each.next)), each.name)
            if twin is each.name:
                carried.append(each)
            else:
                self._same[each.name] = twin
        loop.carried = carried
        names = [each.name for each in carried]
        blocks = (loop.test, loop.body)
        loop.test, loop.body = self._blocks(blocks, [*names, loop.counter], loops=True)
        for each in carried:
            each.next = self._resolve(each.next)
        if loop.goes_on is not None:
            loop.goes_on = self._resolve(loop.goes_on)
        self._add(loop, *names)

    def _branch(self, branch: Branch) -> None:
        branch.index = self._resolve(branch.index)
        branch.blocks = [self.block(block) for block in branch.blocks]
        branch.values = [self.known_as(values) for values in branch.values]
        for target, *values in zip(branch.targets, *branch.values, strict=True):
            # all blocks give the same value, computed outside the branch
            outside = self._depth.get(values[0], 1) <= len(self._scopes)
            if outside and len({key(value) for value in values}) == 1:
                self._same[target] = values[0]
        self._add(branch, *branch.targets)

    def _assign(self, assign: Assign) -> None:
        operands = self.known_as(assign.operands)
        if assign.table is None:
            self._same[assign.target] = self.value(assign, assign.operation, *operands)
            return
        values, index = self._filled.get(assign.table), operands[0]
        if isinstance(index, Number) and assign.table.values:
            self._same[assign.target] = assign.table.known(int(index.value))
            return
        if values is not None and isinstance(index, Number):
            self._same[assign.target] = values[int(index.value)]
            return
        if assign.table.memory:
            self._same[assign.target] = self._read(assign, assign.table, *operands)
            return
        assign.operands = (index,)
        self._add(assign, assign.target)

    def _read(self, of: Assign, table: Table, index: Operand, offset: Operand) -> Operand:
        """Element of a table in the memory of the inputs, which never changes."""
        if isinstance(index, Number) and isinstance(offset, Number):
            return table.parameter(int(index.value + offset.value))
        return self._compute(of, "element", (index, offset))

    def value(self, of: Assign, operation: str, *operands: Operand) -> Operand:
        """Result of an operation: a constant, a value computed earlier, or a new name."""
        replacement = simpler(self, of, operation, operands)
        return self._compute(of, operation, operands) if replacement is None else replacement

    def is_exact(self, of: Assign) -> bool:
        """See `Known.is_exact`."""
        return of.target in self._exact

    def made(self, operand: Operand) -> Assign | None:
        """See `Known.made`."""
        return self._assigned.get(operand)

    def reciprocal(self, of: Assign, divisor: Operand) -> Operand | None:
        """See `Known.reciprocal`: for a loop invariant, or a divisor of several divisions."""
        depth = self._depth.get(divisor, 1)
        if any(scope.loops for scope in self._scopes[depth:]):
            scope = self._scopes[depth - 1]
        elif self._divided_by[divisor] > 1:
            scope = self._scopes[-1]
        else:
            return None
        return self._compute(of, "div", (ONE, divisor), scope)

    def _compute(
        self, of: Assign, operation: str, operands: Sequence[Operand], scope: _Scope | None = None
    ) -> Name:
        """Name of an operation's result, computed here or already known."""
        keys = [key(operand) for operand in operands]
        if operation in _COMMUTATIVE:
            keys.sort()
            if isinstance(operands[1], Number):
                operands = operands[::-1]
        expression = (operation, of.target.kind, of.table, *keys)
        for each in self._scopes:
            if expression in each.computed:
                return each.computed[expression]
            if each is scope:
                break
        scope = scope or self._scopes[-1]
        # the first result keeps its name
        name = of.target
        if name in self._assigned or operation != of.operation:
            name = Name(of.target.kind, of.target.hint, of.target.group, of.target.place)
        statement = Assign(name, operation, tuple(operands), of.source, of.table)
        self._assigned[name] = statement
        self._depth[name] = self._scopes.index(scope) + 1
        scope.computed[expression] = name
        scope.made.append(statement)
        return name
