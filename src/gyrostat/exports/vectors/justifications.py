"""Recorded reasons why a condition cannot have a value, or cannot act alone."""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal

from gyrostat.codegen.flight.reader.decisions import Decision
from gyrostat.codegen.flight.reader.tokens import Position
from gyrostat.exports.vectors.coverage import DecisionCoverage

Want = Literal["true", "false", "alone"]
"""What is to be shown of a condition: each value, and that it decides the outcome alone."""


@dataclass(frozen=True)
class Justification:
    """Reason why something cannot be shown.

    Attributes:
        file: Python file that the decision comes from; see `Decision.origin`.
        text: Text of the line, or the beginning of it.
        condition: Index of the condition in its decision, from 0; None for each of them.
        wants: What cannot be shown.
        modules: Flight modules that this holds for; () for all.
        reason: The reason.
        is_sure: Whether it holds in every such module. Otherwise a reviewer confirms it for the
            conditions that are not shown.
    """

    file: str
    text: str
    condition: int | None
    wants: tuple[Want, ...]
    modules: tuple[str, ...]
    reason: str
    is_sure: bool = True

    def names(self, decision: Decision) -> bool:
        """Whether its line is that of a decision."""
        file, _, rest = decision.origin.partition(":")
        return file == self.file and rest.partition(": ")[2].startswith(self.text)

    def holds_for(self, module: str, decision: Decision) -> bool:
        """Whether it is about a decision of a module."""
        return self.names(decision) and (not self.modules or module in self.modules)


@dataclass(frozen=True)
class Gap:
    """Something that is to be shown of a condition.

    Attributes:
        decision: Number of the decision.
        condition: Index of the condition.
        at: Where the condition starts.
        want: What is to be shown.
    """

    decision: int
    condition: int
    at: Position
    want: Want


@cache
def justifications() -> tuple[Justification, ...]:
    """Recorded reasons for the decisions of gyrostat."""
    text = files("gyrostat.exports.vectors").joinpath("justified.toml").read_text(encoding="utf-8")
    return tuple(map(justification, tomllib.loads(text).get("justified", ())))


def justification(entry: Mapping[str, Any]) -> Justification:
    """Reason of an entry [[justified]] of a file."""
    return Justification(
        entry["file"],
        entry["text"],
        entry.get("condition"),
        tuple(entry["cannot_be"]),
        tuple(entry.get("modules", ())),
        " ".join(entry["reason"].split()),
        not entry.get("confirm", False),
    )


def gaps(coverage: DecisionCoverage) -> Iterator[Gap]:
    """What was not shown of a decision."""
    decision = coverage.decision
    missing = coverage.missing()
    for condition, at in enumerate(decision.positions):
        states = {outcome[0][condition] for outcome in coverage.seen}
        if "T" not in states:
            yield Gap(decision.number, condition, at, "true")
        if "F" not in states:
            yield Gap(decision.number, condition, at, "false")
        if decision.size > 1 and condition in missing:
            yield Gap(decision.number, condition, at, "alone")


def justified(
    module: str,
    decisions: Sequence[Decision],
    own: Sequence[Justification] = (),
    *,
    is_sure: bool = True,
) -> dict[Gap, str]:
    """Everything that cannot be shown in a module -> the reason.

    Args:
        module: Name of the module.
        decisions: Decisions of its C code.
        own: Reasons of the user.
        is_sure: Whether the reasons hold in every module that they are recorded for, or may hold.
    """
    return {
        Gap(decision.number, condition, decision.positions[condition], want): each.reason
        for each in (*justifications(), *own)
        if each.is_sure == is_sure
        for decision in decisions
        if each.holds_for(module, decision)
        for condition in range(decision.size)
        if each.condition in (None, condition)
        for want in each.wants
        if want != "alone" or decision.size > 1
    }
