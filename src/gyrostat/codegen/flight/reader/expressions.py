"""Translation of expressions of emitted C to Python on arrays of lanes."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from gyrostat.codegen.flight.reader.arithmetic import PLAIN
from gyrostat.codegen.flight.reader.decisions import Decision, Tree, conditions, is_logic
from gyrostat.codegen.flight.reader.functions import INTRINSIC
from gyrostat.codegen.flight.reader.spelling import spelled
from gyrostat.codegen.flight.reader.syntax import (
    Address,
    Binary,
    Choice,
    Expression,
    Invocation,
    Literal,
    Place,
    Unary,
    inside,
)
from gyrostat.codegen.flight.reader.tokens import Position, UnreadableError

_TESTS = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge", "==": "eq", "!=": "ne"}
_CALLED = {"/": "quotient", "%": "rest", "<<": "left", ">>": "right"}
_CASTS = {
    **{"double": "real", "float": "single"},
    **{"int64_t": "whole", "int32_t": "whole", "uint64_t": "word"},
}


DEEPEST = 16
"""Largest number of choices between numbers, one inside the other, that margins follow."""


class ExpressionWriter:
    """Writes expressions as Python; what must be computed first goes to lines.

    Attributes:
        addressed: Variables whose address is taken; each is a list with its value.
        uniform: Counters of loops that all lanes pass equally; each is an integer.
        source: Line of Python that the statement comes from.
        compared: Operands of comparisons.
    """

    def __init__(
        self,
        function: str,
        names: Collection[str],
        constants: dict[str, Any],
        decisions: list[Decision],
        *,
        has_margins: bool,
    ) -> None:
        self.addressed: Collection[str] = ()
        self.uniform: set[str] = set()
        self.source = ""
        self._name = function
        self._functions = names
        self._constants = constants
        self._decisions = decisions
        self._has_margins = has_margins
        self._comparisons = 0
        self._chosen: dict[str, tuple[str, Expression, Expression]] = {}
        self.compared: list[tuple[Expression, Expression]] = []
        self._lines: list[str] = []
        self._depth = 1
        self._count = 0
        self._lanes, self._path = "m", "p"

    def line(self, text: str) -> None:
        """Add a line of Python."""
        self._lines.append("    " * self._depth + text)

    def taken(self) -> list[str]:
        """All lines."""
        return self._lines

    @contextmanager
    def indented(self) -> Iterator[None]:
        """Lines inside a block of Python."""
        self._depth += 1
        yield
        self._depth -= 1

    def free(self, prefix: str) -> str:
        """Unused name of a variable."""
        self._count += 1
        return f"{prefix}{self._count}"

    def constant(self, value: Any) -> str:
        """Name of an object that the text refers to."""
        name = f"c{len(self._constants)}"
        self._constants[name] = value
        return name

    def at(self, lanes: str, path: str, source: str) -> None:
        """Set the lanes, the path and the source of the following expressions."""
        self._lanes, self._path, self.source = lanes, path, source

    def text(self, expression: Expression) -> str:
        """Python of an expression."""
        if is_logic(expression):
            assert isinstance(expression, Binary | Unary)
            return self.decision(expression, "value", expression.at)
        match expression:
            case Literal():
                return self._literal(expression)
            case Place():
                return self._place(expression)
            case Address(place=place):
                return f"v_{place.name}"
            case Unary(operation=operation, operand=operand):
                text = self.text(operand)
                if operation in "-~":
                    return f"({operation}{text})"
                operation = {"!": "negated", **_CASTS}.get(operation, "")
                return f"{operation}({text})"
            case Binary(operation=operation, left=left, right=right):
                if operation in _TESTS:
                    return self._comparison(expression)
                first, second = self.text(left), self.text(right)
                name = _CALLED.get(operation)
                return f"{name}({first}, {second})" if name else f"({first} {operation} {second})"
            case Choice():
                return self._choice(expression)[0]
            case Invocation(function=function, arguments=arguments):
                texts = [self.text(argument) for argument in arguments]
                if function in self._functions:
                    texts = [self._lanes, self._path, *texts]
                    return f"f_{function}({', '.join(texts)})"
                name = function if function in INTRINSIC else f"c_{function}"
                if name not in PLAIN:
                    raise UnreadableError(
                        f"{self._name}: found a call of {function}, expected a function of the "
                        "file or of math.h"
                    )
                return f"{name}({', '.join(texts)})"

    def _comparison(self, binary: Binary, depth: int = 0) -> str:
        """Comparison; with margins, that of a chosen value leads to the test of the choice."""
        operation, left, right = binary.operation, binary.left, binary.right
        self.compared.append((left, right))
        first, second = self.text(left), self.text(right)
        if not self._has_margins:
            return f"({first} {operation} {second})"
        self._comparisons += 1
        text = f'{_TESTS[operation]}({first}, {second}, "{self._name}{self._comparisons}")'
        for side, is_left in ((left, True), (right, False)):
            choice = self._chosen.get(side.name) if isinstance(side, Place) else None
            if choice is None or depth > DEEPEST:
                continue
            test, *values = choice
            parts = [replace(binary, **{"left" if is_left else "right": value}) for value in values]
            texts = [self._comparison(part, depth + 1) for part in parts]
            return f"alternative({text}, {test}, {texts[0]}, {texts[1]})"
        return text

    def definition(self, name: str, value: Expression) -> str:
        """Python of the value of a constant; a choice with a number is noted for comparisons."""
        if not isinstance(value, Choice) or not self._has_margins:
            return self.text(value)
        text, test = self._choice(value)
        sides = (value.yes, value.no)
        if all(isinstance(side, Literal | Place) for side in sides) and any(
            isinstance(side, Literal) or (isinstance(side, Place) and side.name in self._chosen)
            for side in sides
        ):
            self._chosen[name] = (test, *sides)
        return text

    def _literal(self, literal: Literal) -> str:
        if literal.kind == "single":
            return self.constant(np.float32(literal.value))
        if literal.kind == "logical":
            return "yes" if literal.value else "no"
        return f"({literal.value!r})"

    def is_fixed(self, place: Place) -> bool:
        """Whether all indices of a place are the same in all lanes."""
        return all(map(self.is_uniform, place.indices))

    def is_uniform(self, expression: Expression) -> bool:
        """Whether an integer is the same in all lanes."""
        return all(
            isinstance(e, Literal | Binary | Unary)
            or (isinstance(e, Place) and e.name in self.uniform)
            for e in inside(expression)
        )

    def _place(self, place: Place) -> str:
        text = f"v_{place.name}"
        if place.path:
            text += f'["{place.path}"]'
        elif place.is_target or place.name in self.addressed:
            text += "[0]"
        if self.is_fixed(place):
            return text + "".join(f"[{self.text(index)}]" for index in place.indices)
        indices = ", ".join(self.text(index) for index in place.indices)
        return f"element({text}, ({indices},))"

    def _choice(self, choice: Choice) -> tuple[str, str]:
        """Conditional expression, and the variable with its test."""
        test = self.decision(choice.test, "?:", choice.at)
        sides = []
        for side, name in ((choice.yes, "and"), (choice.no, "and_not")):
            with self._within([side], name, test):
                sides.append(self.text(side))
        return f"choose({test}, {sides[0]}, {sides[1]})", test

    @contextmanager
    def _within(self, operands: Iterable[Expression], name: str, test: str) -> Iterator[None]:
        """Lanes for which operands are evaluated that depend on a test."""
        outer = self._lanes, self._path
        if any(map(self._has_decisions, operands)):
            self._lanes, self._path = self.narrowed(*outer, name, test)
        yield
        self._lanes, self._path = outer

    def narrowed(self, lanes: str, path: str, name: str, test: str) -> tuple[str, str]:
        """Variables with the lanes and the path of a side of a test: "and" or "and_not"."""
        inner = self.free("m"), self.free("p")
        self.line(f"{inner[0]} = lanes_{name}({lanes}, {test})")
        self.line(f"{inner[1]} = path_{name}({path}, {test})")
        return inner

    def _has_decisions(self, expression: Expression) -> bool:
        return any(
            isinstance(e, Choice)
            or is_logic(e)
            or (isinstance(e, Invocation) and e.function in self._functions)
            for e in inside(expression)
        )

    def decision(self, expression: Expression, kind: str, at: Position) -> str:
        """Record a decision; the variable with its outcome."""
        tree, leaves = conditions(expression, at)
        names = [self.free("t") for _ in leaves]
        outcome = self._conditions(tree, [leaf for leaf, _ in leaves], names)
        number = self.new_decision(leaves, tree, kind, at)
        self.line(
            f"if need[{number}]: "
            f"record({number}, {self._lanes}, {self._path}, ({', '.join(names)},))"
        )
        return outcome

    def _conditions(self, tree: Tree, leaves: Sequence[Expression], names: Sequence[str]) -> str:
        """Evaluate the conditions of a decision; the variable with its outcome."""
        if isinstance(tree, int):
            self.line(f"{names[tree]} = {self.text(leaves[tree])}")
            return names[tree]
        result = self.free("t")
        left = self._conditions(tree[1], leaves, names)
        if len(tree) == 2:
            self.line(f"{result} = negated({left})")
            return result
        is_and = tree[0] == "&&"
        right_tree = tree[2]
        operands = [leaves[k] for k in _leaves(right_tree)]
        with self._within(operands, "and" if is_and else "and_not", left):
            right = self._conditions(right_tree, leaves, names)
        self.line(f"{result} = {'both' if is_and else 'either'}({left}, {right})")
        return result

    def new_decision(
        self, leaves: Sequence[tuple[Expression, Position]], tree: Tree, kind: str, at: Position
    ) -> int:
        """Add a decision to the list; its number."""
        number = len(self._decisions)
        texts = tuple(spelled(leaf) for leaf, _ in leaves)
        positions = tuple(position for _, position in leaves)
        self._decisions.append(
            Decision(number, self._name, at, kind, self.source, texts, positions, tree)
        )
        return number


def _leaves(tree: Tree) -> Iterator[int]:
    if isinstance(tree, int):
        yield tree
    else:
        for part in tree[1:]:
            yield from _leaves(part)  # pyright: ignore[reportArgumentType]
