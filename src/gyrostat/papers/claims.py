"""A statement of a paper beside the value computed here, and the rule that judges it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

Value = float | bool | None
Verdict = Literal["reproduced", "not-reproduced", "not-testable", "ours-only"]
NOT_COMPUTED = "Not computed: dispersed runs belong to the full reproduction."


@dataclass(frozen=True)
class Claim:
    """A statement and its verdict.

    Attributes:
        id: name of the statement, dotted, never changed once published.
        quantity: what is compared, in words.
        ours: the value computed here, in `unit`, or whether the statement holds; None where it
            cannot be tested.
        unit: SI unless the id names another; empty for counts, ratios and yes or no.
        why: reason for the verdict, one or two sentences.
        paper: the paper's value; None where it gives none.
        tolerance: largest difference from the paper, in `unit`, that counts as the same.
        source: place in the paper.

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
    source: str = ""

    def __post_init__(self) -> None:
        """Validate the values."""
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
        """Row of claims.json."""
        names = ("id", "quantity", "paper", "ours", "unit", "tolerance", "verdict", "why")
        return {name: getattr(self, name) for name in names}


@dataclass(frozen=True)
class Row:
    """A claim before its value is computed: a row of a paper's claims.toml.

    `quantity` and `why` may contain replacement fields such as `{seeds}`, filled from the facts
    that the computation returns beside its values.

    Attributes:
        id: as of a `Claim`.
        quantity: likewise.
        why: likewise.
        unit: likewise.
        paper: likewise.
        tolerance: likewise; 0 by default where the paper's value is yes or no.
        source: place in the paper; empty where the paper says nothing on it.
        at_most: largest value that our own requirement, set before the computation, allows.
        at_least: smallest such value.
        testable: False where the claim rests on data that the paper does not publish.
        full: True where only the full reproduction computes the value.
    """

    id: str
    quantity: str
    why: str
    unit: str = ""
    paper: float | bool | None = None
    tolerance: float | None = None
    source: str = ""
    at_most: float | None = None
    at_least: float | None = None
    testable: bool = True
    full: bool = False

    def requirement(self, value: Value) -> str:
        """State our own requirement and whether a value meets it; empty where there is none."""
        if self.at_most is None and self.at_least is None:
            return ""
        low = -math.inf if self.at_least is None else self.at_least
        high = math.inf if self.at_most is None else self.at_most
        limit = f"at least {low:g}" if self.at_most is None else f"at most {high:g}"
        met = value is not None and low <= value <= high
        unit = f" {self.unit}" if self.unit else ""
        return f" Required beforehand: {limit}{unit}; {'met' if met else 'not met'}."

    def claim(self, value: Value, facts: Mapping[str, Any], *, computed: bool = True) -> Claim:
        """Join the row with its value.

        Args:
            value: computed here; None where it cannot be tested.
            facts: values of the replacement fields.
            computed: False where a quick reproduction leaves the value out.
        """
        quantity, why = self.quantity, NOT_COMPUTED
        if computed:
            quantity = quantity.format_map(facts)
            why = self.why.format_map(facts) + self.requirement(value)
        tolerance = self.tolerance
        if tolerance is None and isinstance(self.paper, bool):
            tolerance = 0.0
        return Claim(self.id, quantity, value, self.unit, why, self.paper, tolerance, self.source)
