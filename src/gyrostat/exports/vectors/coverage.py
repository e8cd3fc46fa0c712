"""Which evaluations of decisions were seen, and which are still wanted."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from gyrostat.codegen.flight.reader.decisions import Decision, Outcome, acts_alone
from gyrostat.codegen.flight.reader.margins import value_of

GOALS = 4
"""Largest number of evaluations that are sought at once for a condition."""


def coded(lanes: np.ndarray, values: Sequence[Any]) -> np.ndarray:
    """Values of all conditions in each lane, bit k that of condition k."""
    code = np.zeros(lanes.shape, np.int64)
    for k, value in enumerate(values):
        code |= np.asarray(value_of(value)).astype(np.int64) << k
    return code


@dataclass(frozen=True)
class Goal:
    """Evaluation of a decision that is sought.

    Attributes:
        decision: Number of the decision.
        outcome: Evaluation.
    """

    decision: int
    outcome: Outcome


class DecisionCoverage:
    """Evaluations of one decision.

    Attributes:
        decision: Decision.
        seen: Evaluation -> the first inputs that give it.
        is_complete: Whether every condition was true and false, and acts alone.
    """

    def __init__(self, decision: Decision, unreachable: Collection[int] = ()) -> None:
        """Begin without evaluations.

        Args:
            decision: Decision.
            unreachable: Conditions that are not sought.
        """
        self.decision = decision
        self._unreachable = frozenset(unreachable)
        self.seen: dict[Outcome, Any] = {}
        self.is_complete = False
        self._outcomes: dict[int, Outcome] = {}
        self._pairs = [
            [pair for pair in combinations(decision.outcomes(), 2) if acts_alone(condition, *pair)]
            for condition in range(decision.size)
        ]

    def outcome(self, code: int) -> Outcome:
        """Evaluation for given values of all conditions, bit k that of condition k."""
        if code not in self._outcomes:
            self._outcomes[code] = self.decision.outcome(code)
        return self._outcomes[code]

    def add(self, outcome: Outcome, inputs: Any) -> bool:
        """Add an evaluation; whether it is new."""
        if outcome in self.seen:
            return False
        self.seen[outcome] = inputs
        self.is_complete = not self.missing()
        return True

    def remove(self, inputs: Collection[int]) -> None:
        """Remove the evaluations by inputs of given identities."""
        self.seen = {o: each for o, each in self.seen.items() if id(each) not in inputs}
        self.is_complete = not self.missing()

    def missing(self) -> list[int]:
        """Conditions that do not act alone in the evaluations so far."""
        return [
            condition
            for condition, pairs in enumerate(self._pairs)
            if not any(one in self.seen and other in self.seen for one, other in pairs)
        ]

    def sought(self) -> list[int]:
        """Conditions that are missing and can be shown."""
        return [condition for condition in self.missing() if condition not in self._unreachable]

    def goals(self) -> list[Goal]:
        """Evaluations that are sought: those that complete a pair first."""
        wanted: dict[Outcome, None] = {}
        for condition in self.sought():
            pairs = self._pairs[condition]
            halves = [
                other if one in self.seen else one
                for one, other in pairs
                if (one in self.seen) != (other in self.seen)
            ]
            every = halves or [outcome for pair in pairs for outcome in pair]
            wanted.update(dict.fromkeys(list(dict.fromkeys(every))[:GOALS]))
        return [Goal(self.decision.number, outcome) for outcome in wanted]


class Coverage:
    """Evaluations of all decisions; a recorder for `Machine.run`.

    Attributes:
        decisions: Coverage of each decision.
        hits: Evaluations of the current batch that are new: decision, evaluation, lane.
        margins: Goal -> whether the decision is reached, and the margin, in each lane of the
            current batch, (2, lanes); of a run with margins.
    """

    def __init__(
        self, decisions: Sequence[Decision], unreachable: Collection[tuple[int, int]] = ()
    ) -> None:
        """Begin without evaluations.

        Args:
            decisions: Decisions.
            unreachable: Number of a decision and index of a condition that is not sought.
        """
        conditions: dict[int, set[int]] = {}
        for number, condition in unreachable:
            conditions.setdefault(number, set()).add(condition)
        self.decisions = [
            DecisionCoverage(decision, conditions.get(decision.number, ()))
            for decision in decisions
        ]
        self.hits: list[tuple[int, Outcome, int]] = []
        self.margins: dict[Goal, np.ndarray] = {}
        self._goals: dict[int, list[Goal]] = {}

    def begin(self, need: list[bool]) -> None:
        """Prepare for a batch; `need` becomes the decisions of which something is sought."""
        self.hits, self.margins = [], {}
        need[:] = [not each.is_complete and bool(each.sought()) for each in self.decisions]
        self._goals = {
            each.decision.number: each.goals()
            for each in self.decisions
            if need[each.decision.number]
        }

    @property
    def goals(self) -> list[Goal]:
        """All evaluations that are sought."""
        return [goal for goals in self._goals.values() for goal in goals]

    def record(self, number: int, lanes: Any, path: Any, values: tuple[Any, ...]) -> None:
        """Record a decision; see `Recorder`."""
        margins = [getattr(value, "margin", None) for value in values]
        coverage = self.decisions[number]
        code = coded(lanes, values)
        codes, places = np.unique(code[lanes], return_index=True)
        if len(codes):
            reached = np.flatnonzero(lanes)
            for each, place in zip(codes.tolist(), places.tolist(), strict=True):
                outcome = coverage.outcome(each)
                if outcome not in coverage.seen:
                    self.hits.append((number, outcome, int(reached[place])))
        if margins[0] is not None:
            self._note_margins(number, lanes, path, margins)

    def _note_margins(self, number: int, lanes: Any, path: Any, margins: Sequence[Any]) -> None:
        for goal in self._goals.get(number, ()):
            least = np.full(lanes.shape, np.inf) if path is None else path
            for state, margin in zip(goal.outcome[0], margins, strict=True):
                if state != "-":
                    least = np.minimum(least, margin if state == "T" else np.negative(margin))
            least = np.fmax(np.broadcast_to(least, lanes.shape), -np.inf)
            now = np.stack([lanes.astype(float), least])
            # of several calls, one that reaches the decision counts first
            before = self.margins.get(goal, np.full_like(now, -np.inf))
            is_larger = (now[0] > before[0]) | ((now[0] == before[0]) & (now[1] > before[1]))
            self.margins[goal] = np.where(is_larger, now, before)
