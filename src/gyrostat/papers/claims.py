"""One statement of a paper beside what came out here, and the rule that judges it."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

Value = float | bool | None
Verdict = Literal["reproduced", "not-reproduced", "not-testable", "ours-only"]


@dataclass(frozen=True)
class Claim:
    """A statement and its verdict.

    Attributes:
        id: name of the statement, dotted, never changed once published.
        quantity: what is compared, in words.
        ours: what came out here, in `unit`, or whether the statement holds; None where it cannot
            be tested.
        unit: SI unless the id names another; empty for counts, ratios and yes or no.
        why: what the verdict rests on, one sentence.
        paper: what the paper says; None where it gives nothing.
        tolerance: largest difference from the paper, in `unit`, that counts as the same.

    Raises:
        ValueError: a value that is not finite, a number against a yes or no, or a paper's value
            without a tolerance.
    """

    id: str
    quantity: str
    ours: Value
    unit: str
    why: str
    paper: Value = None
    tolerance: float | None = None

    def __post_init__(self) -> None:
        """Refuse what no rule could judge."""
        present = [v for v in (self.ours, self.paper, self.tolerance) if v is not None]
        if not all(math.isfinite(v) for v in present):
            raise ValueError(f"{self.id}: found {present}, expected finite values")
        if self.ours is None or self.paper is None:
            return
        if isinstance(self.ours, bool) != isinstance(self.paper, bool):
            raise ValueError(f"{self.id}: found {self.ours} against {self.paper}, expected alike")
        if self.tolerance is None or self.tolerance < 0.0:
            raise ValueError(f"{self.id}: found tolerance {self.tolerance}, expected 0 or more")

    @property
    def verdict(self) -> Verdict:
        """The one rule: within the tolerance or not, where there are two values to compare."""
        if self.ours is None:
            return "not-testable"
        if self.paper is None or self.tolerance is None:
            return "ours-only"
        same = abs(float(self.ours) - float(self.paper)) <= self.tolerance
        return "reproduced" if same else "not-reproduced"

    def to_dict(self) -> dict[str, object]:
        """A row of claims.json."""
        return {
            "id": self.id,
            "quantity": self.quantity,
            "paper": self.paper,
            "ours": self.ours,
            "unit": self.unit,
            "tolerance": self.tolerance,
            "verdict": self.verdict,
            "why": self.why,
        }


def statement(name: str, quantity: str, holds: bool | np.bool_, why: str) -> Claim:
    """A sentence of the paper, which takes it to be true.

    Args:
        name: id of the claim.
        quantity: the sentence.
        holds: whether it does here.
        why: what that rests on.
    """
    return Claim(name, quantity, bool(holds), "", why, paper=True, tolerance=0.0)
