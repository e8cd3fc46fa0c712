"""Choice of few steps that show everything that was seen."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from gyrostat.codegen.flight.reader.decisions import Decision, Outcome, acts_alone
from gyrostat.exports.vectors.coverage import coded
from gyrostat.exports.vectors.machine import ALL_PASSES, Machine
from gyrostat.exports.vectors.rows import Candidate, Row, groups

Item = tuple[int, Outcome]
"""Number of a decision, and an evaluation of it."""


class _Log:
    """Recorder of all evaluations of each lane."""

    def __init__(self, decisions: Sequence[Decision], lanes: int) -> None:
        self.items: list[set[Item]] = [set() for _ in range(lanes)]
        self._decisions = decisions

    def record(self, number: int, lanes: Any, path: Any, values: tuple[Any, ...]) -> None:
        """See `Recorder`."""
        code = coded(lanes, values)
        codes = dict.fromkeys(code[lanes].tolist())
        outcomes = {each: (number, self._decisions[number].outcome(each)) for each in codes}
        for lane, each in zip(np.flatnonzero(lanes).tolist(), code[lanes].tolist(), strict=True):
            self.items[lane].add(outcomes[each])


def items_of(machine: Machine, candidates: Sequence[Candidate]) -> list[set[Item]]:
    """All evaluations in the step of each candidate."""
    items: list[set[Item]] = [set() for _ in candidates]
    for begins, group in groups(candidates):
        log = _Log(machine.decisions, len(group))
        machine.need[:] = [True] * len(machine.decisions)
        values = np.stack([candidates[k].values for k in group], axis=1)
        with machine.up_to(ALL_PASSES):
            machine.run(values, log.record, begins=begins)
        for k, found in zip(group, log.items, strict=True):
            items[k] = found
    return items


@dataclass(frozen=True)
class Replay:
    """Run of rows as the C code computes.

    Attributes:
        values: Values of all fields after each row, (rows, fields).
        items: Evaluations in each row.
    """

    values: np.ndarray
    items: tuple[set[Item], ...]


def replay(machine: Machine, tuned: np.ndarray, rows: Sequence[Row]) -> Replay:
    """Run rows; the sequences in them, each of which begins anew, run side by side."""
    starts = [k for k, row in enumerate(rows) if row.begins]
    sequences = [range(*ends) for ends in pairwise([*starts, len(rows)])]
    history = np.zeros((len(rows), len(tuned)))
    items: list[set[Item]] = [set() for _ in rows]
    machine.need[:] = [True] * len(machine.decisions)
    for step in range(max(map(len, sequences))):
        numbers = [sequence[step] for sequence in sequences if len(sequence) > step]
        columns = [history[k - 1].copy() if step else tuned.copy() for k in numbers]
        for column, k in zip(columns, numbers, strict=True):
            column[[*rows[k].changes]] = [*rows[k].changes.values()]
        log = _Log(machine.decisions, len(numbers))
        with machine.up_to(ALL_PASSES):
            history[numbers] = machine.run(np.array(columns).T, log.record, begins=step == 0).T
        for lane, k in enumerate(numbers):
            items[k] = log.items[lane]
    return Replay(history, tuple(items))


def wanted_items(decisions: Sequence[Decision], reachable: set[Item]) -> set[Item]:
    """Evaluations that show every condition that can be shown, one pair for each.

    Args:
        decisions: Decisions of the C code.
        reachable: Evaluations that steps give.
    """
    seen: dict[int, list[Outcome]] = {}
    for number, outcome in sorted(reachable):
        seen.setdefault(number, []).append(outcome)
    wanted: set[Item] = set()
    for decision in decisions:
        number = decision.number
        for condition in range(decision.size):
            pairs = [
                pair
                for pair in combinations(seen.get(number, ()), 2)
                if acts_alone(condition, *pair)
            ]
            if pairs:
                known = [sum((number, outcome) in wanted for outcome in pair) for pair in pairs]
                pair = pairs[int(np.argmax(known))]
                wanted |= {(number, outcome) for outcome in pair}
            else:
                wanted |= {(number, outcome) for outcome in seen.get(number, ())}
    return wanted


def choose(
    candidates: Sequence[Candidate], items: Sequence[set[Item]], wanted: set[Item]
) -> list[int]:
    """Candidates that show what is wanted, by the most new evaluations for each row."""
    missing = set(wanted)
    costs = [len(c.situation.rows) + 1 + 0.1 * len(c.changed) for c in candidates]
    chosen: list[int] = []
    while missing:
        gains = [len(i & missing) / cost for i, cost in zip(items, costs, strict=True)]
        best = int(np.argmax(gains))
        if gains[best] == 0.0:
            break
        missing -= items[best]
        chosen.append(best)
    return chosen
