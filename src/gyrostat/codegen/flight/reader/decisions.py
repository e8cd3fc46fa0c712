"""Decisions of emitted C, and modified condition/decision coverage (MC/DC) of them.

A decision is an expression of && and ||, or the test of an if, a loop or a ?: without them. Its
conditions are the operands of && and ||. As in DO-178C with short-circuit operators, and in clang,
a condition that is not evaluated agrees with any value: a condition is shown to act alone by two
evaluations of different outcome in which it is the only one that differs (masking MC/DC).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gyrostat.codegen.flight.reader.syntax import Binary, Expression, Unary
from gyrostat.codegen.flight.reader.tokens import Position

Outcome = tuple[str, bool]
"""Evaluation of a decision: the value of each condition, "T", "F" or "-" (not evaluated), and the
outcome."""
Tree = int | tuple[str, "Tree", "Tree"] | tuple[str, "Tree"]
"""Index of a condition, ("&&" or "||", tree, tree), or ("!", tree)."""


@dataclass(frozen=True)
class Decision:
    """Decision in a C file.

    Attributes:
        number: Index in the file.
        function: Function that contains it.
        at: Where it starts.
        kind: "if", "for", "?:" or "value".
        source: Line of Python that it comes from; "" for a helper function.
        conditions: Text of each condition.
        positions: Where each condition starts.
        tree: How the conditions are combined.
    """

    number: int
    function: str
    at: Position
    kind: str
    source: str
    conditions: tuple[str, ...]
    positions: tuple[Position, ...]
    tree: Tree

    @property
    def origin(self) -> str:
        """Line of Python; "C", function and conditions of a helper function, which has none."""
        return self.source or f"C:{self.at.line}: {self.function}: {' '.join(self.conditions)}"

    @property
    def size(self) -> int:
        """Number of conditions."""
        return len(self.conditions)

    def outcome(self, values: int) -> Outcome:
        """Evaluation for given values of all conditions, bit k that of condition k."""
        pattern = ["-"] * self.size

        def value(tree: Tree) -> bool:
            if isinstance(tree, int):
                pattern[tree] = "T" if values >> tree & 1 else "F"
                return bool(values >> tree & 1)
            if len(tree) == 2:
                return not value(tree[1])
            left = value(tree[1])
            return left if left == (tree[0] == "||") else value(tree[2])

        result = value(self.tree)
        return "".join(pattern), result

    def outcomes(self) -> tuple[Outcome, ...]:
        """All evaluations that differ in an evaluated condition."""

        def of(tree: Tree) -> Iterator[tuple[dict[int, str], bool]]:
            if isinstance(tree, int):
                yield {tree: "T"}, True
                yield {tree: "F"}, False
            elif len(tree) == 2:
                yield from ((values, not result) for values, result in of(tree[1]))
            else:
                for values, result in of(tree[1]):
                    if result == (tree[0] == "||"):
                        yield values, result
                    else:
                        yield from ((values | more, after) for more, after in of(tree[2]))

        return tuple(
            ("".join(values.get(k, "-") for k in range(self.size)), result)
            for values, result in of(self.tree)
        )


def acts_alone(condition: int, one: Outcome, other: Outcome) -> bool:
    """Whether two evaluations show that a condition decides the outcome alone."""
    if one[1] == other[1]:
        return False
    return all(
        {a, b} == {"T", "F"} if k == condition else (a == b or "-" in (a, b))
        for k, (a, b) in enumerate(zip(one[0], other[0], strict=True))
    )


def independent(decision: Decision, outcomes: Sequence[Outcome]) -> dict[int, tuple[int, int]]:
    """Condition -> indices of the first two evaluations that show that it acts alone."""
    pairs: dict[int, tuple[int, int]] = {}
    for later, other in enumerate(outcomes):
        for earlier, one in enumerate(outcomes[:later]):
            for condition in range(decision.size):
                if condition not in pairs and acts_alone(condition, one, other):
                    pairs[condition] = (earlier, later)
    return pairs


def is_logic(expression: Expression) -> bool:
    """Whether an expression is made of && and ||, or is the negation of one that is."""
    while isinstance(expression, Unary) and expression.operation == "!":
        expression = expression.operand
    return isinstance(expression, Binary) and expression.operation in ("&&", "||")


def conditions(
    expression: Expression, at: Position
) -> tuple[Tree, list[tuple[Expression, Position]]]:
    """Tree of a decision that starts at a position, and its conditions with their positions."""
    leaves: list[tuple[Expression, Position]] = []

    def tree(part: Expression, start: Position) -> Tree:
        if not is_logic(part):
            leaves.append((part, start))
            return len(leaves) - 1
        if isinstance(part, Binary):
            # brackets are not part of the tree: what is in them starts behind them
            left = tree(part.left, part.at)
            return part.operation, left, tree(part.right, part.right_at)
        assert isinstance(part, Unary)
        return "!", tree(part.operand, part.at)

    return tree(expression, at), leaves
