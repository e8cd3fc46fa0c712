"""Assignments of an entry's results to the caller's variables."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from gyrostat.codegen.dependencies import used
from gyrostat.codegen.flight.expressions import Text
from gyrostat.codegen.program import Assign, Block, Branch, Name, Operand, Table, statements

_MAY_BE_SET = re.compile(r"->|\[|\(\*")
"""Part of an expression that reads a member, an element or the target of a pointer."""

Move = tuple[str, str, str]
"""C variable, expression of its new value, and its C type."""


def moves(wanted: Iterable[Move], free: Callable[[str], str]) -> list[str]:
    """Assignments equivalent to one simultaneous assignment.

    Args:
        wanted: Destinations and their values.
        free: Function that gives an unused C name.

    Returns:
        Lines of C: copies of values that would be overwritten before they are read, then the
        assignments. A destination that keeps its value gets none.
    """
    changes = [move for move in wanted if move[0] != move[1]]
    destinations = {destination for destination, _, _ in changes}
    copies, assignments, names = [], [], {}
    for destination, value, kind in changes:
        if value in destinations:
            if value not in names:
                names[value] = free("kept")
                copies.append(f"const {kind} {names[value]} = {value};")
            value = names[value]
        assignments.append(f"{destination} = {value};")
    return [*copies, *assignments]


@dataclass(frozen=True)
class LastBranch:
    """Final branch of an entry, the blocks of which assign the entry's results directly.

    This saves a local variable for each result. All targets of the branch are results.

    Attributes:
        branch: Last branch of the entry's body.
        places: Target -> its destinations.
        read: Operands that are read after the branch.
    """

    branch: Branch
    places: Mapping[Name, list[str]]
    read: tuple[Operand, ...]

    def safe(self, texts: Mapping[Name | Table, Text]) -> bool:
        """Whether no operand that is read later has an expression that reads an argument."""
        return not any(
            isinstance(o, Name) and (o.fixed or (o in texts and _MAY_BE_SET.search(texts[o].text)))
            for o in self.read
        )


def last_branch(
    body: Block,
    results: Sequence[Operand],
    places: Sequence[str],
) -> LastBranch | None:
    """Last branch of an entry, if its blocks may assign the results; None otherwise.

    Args:
        body: Body of the entry.
        results: Results of the entry.
        places: Destination of each result.
    """
    number = max((k for k, each in enumerate(body) if isinstance(each, Branch)), default=None)
    if number is None:
        return None
    branch, after = body[number], body[number + 1 :]
    assert isinstance(branch, Branch)
    read = [operand for each in statements(after) for operand in used(each)]
    outputs: dict[Name, list[str]] = {target: [] for target in branch.targets}
    for result, destination in zip(results, places, strict=True):
        if isinstance(result, Name) and result in outputs:
            outputs[result].append(destination)
        elif isinstance(result, Name) and result.hint != destination:
            read.append(result)
    simple = all(isinstance(each, Assign) for each in after)
    if not simple or not all(outputs.values()) or any(operand in outputs for operand in read):
        return None
    return LastBranch(branch, outputs, tuple(read))
