"""Sums whose finiteness is tested, written for speed and so that static analysis follows the test.

If a sum is finite, each of its terms is. Frama-C's EVA, which follows intervals of values, does not
know that. Such a sum is therefore computed by the function `plus` of helpers.h, whose annotations
separate infinite and NaN terms from finite ones for the analysis, and the states are kept apart up
to the test. Annotations are comments for a compiler.

A sum that is only tested may have its terms in any order, and each of them once. The terms that are
known first are added first, and a long sum is tested in parts, because each addition waits for the
one before. The number of states stays small: only the conjunction of the tests so far keeps states
apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.codegen.dependencies import uses
from gyrostat.codegen.program import (
    ZERO,
    Assign,
    Block,
    Branch,
    Call,
    Function,
    Kind,
    Loop,
    Name,
    Number,
    Operand,
    Statement,
    Table,
    inner_blocks,
)

TESTED_ADD, TESTED_FINITE, TESTED_AND = "tested_add", "tested_finite", "tested_and"
"""Operations: addition in a tested sum, its test, and the conjunction of such tests."""
MOST = 8
"""Largest number of terms of a part."""
NEGLIGIBLE = 1e30
"""Constants up to this size are left out: they make no sum infinite."""
_MANY, _FEW = "slevel 100000", "slevel default"
_Users = Mapping[Operand | Table, set[Name | Table]]


class TestedSums:
    """Annotations around tested sums, for the writer of a function."""

    def __init__(self) -> None:
        self._is_open = False
        self._results: dict[Operand, str] = {}

    def before(self, statement: Statement) -> list[str]:
        """Lines before a statement: from the first addition on, states are kept apart."""
        if self._is_open or not _adds(statement):
            return []
        self._is_open = True
        return [_annotation(_MANY)]

    def after(self, statement: Assign, name: str) -> list[str]:
        """Lines after a statement: only states with different results of the tests are kept apart.

        Args:
            statement: The statement.
            name: Its target in C.
        """
        if statement.operation not in (TESTED_FINITE, TESTED_AND):
            return []
        parts = [self._results[each] for each in statement.operands if each in self._results]
        self._results[statement.target] = name
        few = [_FEW] if self._is_open else []
        self._is_open = False
        return [_annotation(f"split {name}", *(f"merge {part}" for part in parts), *few)]


def _annotation(*texts: str) -> str:
    """Annotations for Frama-C at a place between statements."""
    return f"/*@ ghost {' '.join(f'/@ {text}; @/' for text in texts)} ; */"


def _adds(statement: Statement) -> bool:
    if isinstance(statement, Loop):
        return any(_adds(each) for each in statement.body)
    return isinstance(statement, Assign) and statement.operation == TESTED_ADD


def rewrite_tested_sums(function: Function) -> None:
    """Rewrite, in place, the sums of a function that are tested to be finite.

    Additions that are replaced stay; `prune` removes them.
    """
    _rewrite(function.body, uses(function))


def _rewrite(block: Block, users: _Users) -> None:
    definitions: dict[Operand, tuple[int, Statement]] = {}
    new: Block = []
    for position, statement in enumerate(block):
        for inner in inner_blocks(statement):
            _rewrite(inner, users)
        definitions |= dict.fromkeys(_targets(statement), (position, statement))
        if isinstance(statement, Assign) and statement.operation == "finite":
            new += _tested(statement, definitions, users)
        else:
            new.append(statement)
    block[:] = new
    _join(block)


def _join(block: Block) -> None:
    """Mark the conjunctions of tests: after one, only its result keeps states apart."""
    tested: set[Operand] = set()
    for statement in block:
        if isinstance(statement, Assign):
            if statement.operation == "and" and tested.issuperset(statement.operands):
                statement.operation = TESTED_AND
            if statement.operation in (TESTED_FINITE, TESTED_AND):
                tested.add(statement.target)


def _targets(statement: Statement) -> list[Name]:
    match statement:
        case Assign(target=target):
            return [target]
        case Branch(targets=targets) | Call(targets=targets):
            return targets
        case Loop(carried=carried):
            return [each.name for each in carried]
        case _:
            return []


def _tested(
    test: Assign, definitions: Mapping[Operand, tuple[int, Statement]], users: _Users
) -> list[Assign]:
    """Assignments that replace a test."""
    total = test.operands[0]
    _, last = definitions.get(total, (-1, None))
    if isinstance(last, Loop):
        return [_of_loop(test, last)]
    terms: list[Operand] = []
    inside: set[Name | Table] = {test.target}
    group = last.target.group if isinstance(last, Assign) else None
    # the additions of one sum have the same group
    while isinstance(last, Assign) and (last.operation, last.target.group) == ("add", group):
        if users.get(last.target, set()) - inside:
            return [test]
        inside.add(last.target)
        total, term = last.operands
        terms.insert(0, term)
        _, last = definitions.get(total, (-1, None))
    if not terms:
        return [test]
    terms = [
        term
        for term in dict.fromkeys([total, *terms])
        if not (isinstance(term, Number) and abs(term.value) <= NEGLIGIBLE)
    ]
    terms.sort(key=lambda term: definitions.get(term, (-1,))[0])
    return _in_parts(test, terms)


def _of_loop(test: Assign, loop: Loop) -> Assign:
    """Test of a sum that a loop computes."""
    carried = next(each for each in loop.carried if each.name is test.operands[0])
    assignments = (each for each in loop.body if isinstance(each, Assign))
    last = next((each for each in assignments if each.target is carried.next), None)
    if last is None or last.operation != "add" or last.operands[0] is not carried.name:
        return test
    last.operation = TESTED_ADD
    return replace(test, operation=TESTED_FINITE)


def _in_parts(test: Assign, terms: Sequence[Operand]) -> list[Assign]:
    """Sums of some of the terms each, their tests, and the conjunction of these."""
    if len(terms) < 2:  # one addition at least, which has the annotations
        terms = [*terms, ZERO, ZERO][:2]
    assignments: list[Assign] = []

    def assign(kind: Kind, operation: str, *operands: Operand) -> Operand:
        target = Name(kind, test.target.hint, test.target.group)
        assignments.append(replace(test, target=target, operation=operation, operands=operands))
        return target

    result: Operand | None = None
    for part in np.array_split(np.arange(len(terms)), -(-len(terms) // MOST)):
        total = terms[part[0]]
        for k in part[1:]:
            total = assign("real", TESTED_ADD, total, terms[k])
        is_finite = assign("logical", TESTED_FINITE, total)
        result = is_finite if result is None else assign("logical", "and", result, is_finite)
    assignments[-1].target = test.target
    return assignments
