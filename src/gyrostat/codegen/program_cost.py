"""Size of a program, and the work of a call."""

from collections.abc import Iterable
from typing import NamedTuple

from gyrostat.codegen.program import Assign, Block, Branch, Call, Fill, Function, Loop, Store


class Cost(NamedTuple):
    """Cost of functions.

    Attributes:
        size: Number of statements, and of elements of tables that are listed.
        work: Number of statements that a call executes at most, moves included.
    """

    size: int
    work: int

    def __add__(self, other: "Cost") -> "Cost":  # pyright: ignore[reportIncompatibleMethodOverride]
        return Cost(self.size + other.size, self.work + other.work)


def cost(functions: Iterable[Function]) -> Cost:
    """Cost of functions, each called once by itself; calls between them count as one statement."""
    total = Cost(0, 0)
    for function in functions:
        total += cost_of(function.body)
    return total


def cost_of(block: Block) -> Cost:
    """Cost of a block of statements."""
    total = Cost(0, 0)
    for statement in block:
        match statement:
            case Assign() | Store() | Call():
                total += Cost(1, 1)
            case Fill(values=values):
                total += Cost(len(values), len(values))
            case Loop(count=count, test=test, body=body, carried=carried):
                inner = cost_of(test) + cost_of(body) + Cost(len(carried) + 1, len(carried) + 1)
                total += Cost(inner.size + 1, inner.work * count + 1)
            case Branch(blocks=blocks, targets=targets):
                parts = [cost_of(inner) for inner in blocks]
                size = sum(part.size for part in parts) + len(targets) * len(blocks)
                total += Cost(size + 1, max(part.work for part in parts) + len(targets) + 1)
    return total
