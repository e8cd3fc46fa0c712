"""Steps of test vectors."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Row:
    """Step of a test vector.

    Attributes:
        begins: Whether parameters and constants are set to their tuned values, and the state by the
            functions that are called once, before the step.
        changes: Field -> value that is assigned before the step; parameters and constants before
            the functions that are called once. All inputs are assigned.
    """

    begins: bool
    changes: Mapping[int, float]


Rows = tuple[Row, ...]


@dataclass(frozen=True)
class Situation:
    """Point between two steps from which steps are tried.

    Attributes:
        rows: Steps that lead to it.
        history: Values of all fields before the first of them and after each one, (fields,).
    """

    rows: Rows
    history: tuple[np.ndarray, ...]

    @property
    def values(self) -> np.ndarray:
        """Values of all fields, (fields,)."""
        return self.history[-1]

    @property
    def begins(self) -> bool:
        """Whether the next step begins anew."""
        return not self.rows


@dataclass(frozen=True)
class Candidate:
    """Step from a situation.

    Attributes:
        situation: Where it starts.
        values: Values of all fields before the step, (fields,).
        changed: Fields other than inputs whose values the step sets.
    """

    situation: Situation
    values: np.ndarray
    changed: tuple[int, ...]

    def rows(self, inputs: tuple[int, ...]) -> Rows:
        """All steps, with this one as the last."""
        changes = {k: float(self.values[k]) for k in (*self.changed, *inputs)}
        return (*self.situation.rows, Row(self.situation.begins, changes))

    def moved_to(self, situation: Situation, inputs: tuple[int, ...]) -> "Candidate":
        """Step with the same inputs and changes from another situation."""
        values = situation.values.copy()
        taken = [*self.changed, *inputs]
        values[taken] = self.values[taken]
        return Candidate(situation, values, self.changed)


def groups(candidates: Sequence[Candidate]) -> Iterator[tuple[bool, list[int]]]:
    """Whether they begin anew -> indices of the candidates; only groups that are not empty."""
    for begins in (True, False):
        group = [k for k, c in enumerate(candidates) if c.situation.begins == begins]
        if group:
            yield begins, group
