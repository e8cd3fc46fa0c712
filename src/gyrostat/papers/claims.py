"""Claims of papers, the values computed here, and the rule for the verdict."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from gyrostat.core.pictured import Described

Value = float | bool | None
Verdict = Literal[
    "reproduced", "not-reproduced", "calibrated", "infeasible", "not-testable", "ours-only"
]
LEFT_OUT = "left out by --quick"
"""Shown verdict of a claim that a quick reproduction does not compute."""
NOT_COMPUTED = "Not computed: dispersed runs belong to the full reproduction."


@dataclass(frozen=True)
class Claim(Described):
    """A claim and its verdict.

    Attributes:
        id: Dotted name of the claim, never changed once published.
        quantity: Description of the compared quantity.
        ours: Value computed here, in `unit`, or whether the statement holds; None if it cannot be
            tested.
        unit: SI unit unless the id names another; empty for counts, ratios and yes or no.
        why: Reason for the verdict, one or two sentences.
        paper: Value in the paper; None if the paper gives none.
        tolerance: Largest difference from the paper, in `unit`, that counts as equal.
        source: Place in the paper.
        calibrated: Whether a free setting was chosen by the paper's value, so that agreement shows
            nothing.
        infeasible: Whether a missing value means that the quantity was shown not to exist.

    Raises:
        ValueError: A value is not finite, a number is compared with a yes or no, or the paper's
            value has no tolerance.
    """

    id: str
    quantity: str
    ours: Value
    unit: str
    why: str
    paper: Value = None
    tolerance: float | None = None
    source: str = ""
    calibrated: bool = False
    infeasible: bool = False

    def __post_init__(self) -> None:
        """Validate the values."""
        present = [v for v in (self.ours, self.paper, self.tolerance) if v is not None]
        if not all(math.isfinite(v) for v in present):
            raise ValueError(f"{self.id}: found {present}, expected finite values")
        if self.ours is None or self.paper is None:
            return
        if isinstance(self.ours, bool) != isinstance(self.paper, bool):
            raise ValueError(
                f"{self.id}: found {self.ours} against {self.paper}, expected the same kind"
            )
        if self.tolerance is None or self.tolerance < 0.0:
            raise ValueError(f"{self.id}: found tolerance {self.tolerance}, expected 0 or more")

    @property
    def verdict(self) -> Verdict:
        """Verdict by a single rule: whether both values exist and agree within the tolerance."""
        if self.ours is None:
            return "infeasible" if self.infeasible else "not-testable"
        if self.paper is None or self.tolerance is None:
            return "ours-only"
        agrees = abs(float(self.ours) - float(self.paper)) <= self.tolerance
        if not agrees:
            return "not-reproduced"
        return "calibrated" if self.calibrated else "reproduced"

    @property
    def shown_verdict(self) -> str:
        """Verdict for people; claims.json has no verdict of its own for what was left out."""
        return LEFT_OUT if self.why == NOT_COMPUTED else self.verdict

    def to_dict(self) -> dict[str, object]:
        """Convert to a row of claims.json."""
        names = ("id", "quantity", "paper", "ours", "unit", "tolerance", "verdict", "why")
        return {name: getattr(self, name) for name in names}


@dataclass(frozen=True)
class Row:
    """A claim before its value is computed: a row of a paper's claims.toml.

    `quantity` and `why` may contain replacement fields such as `{seeds}`. They are filled with the
    facts that the computation returns in addition to its values.

    Attributes:
        id: As in `Claim`.
        quantity: As in `Claim`.
        why: As in `Claim`.
        unit: As in `Claim`.
        paper: As in `Claim`.
        tolerance: As in `Claim`; 0 by default if the paper's value is yes or no.
        source: Place in the paper; empty if the claim is ours.
        at_most: Largest value that meets our own requirement, which was set before the computation.
        at_least: Smallest value that meets our own requirement.
        testable: False if the claim needs data that the paper does not publish.
        calibrated: As in `Claim`; `why` names the setting.
        infeasible: As in `Claim`; `why` says what shows it.
        full: True if only the full reproduction computes the value.
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
    calibrated: bool = False
    infeasible: bool = False
    full: bool = False

    def requirement(self, value: Value) -> str:
        """State our own requirement and whether a value meets it; empty without a requirement."""
        if self.at_most is None and self.at_least is None:
            return ""
        low = -math.inf if self.at_least is None else self.at_least
        high = math.inf if self.at_most is None else self.at_most
        limit = f"at least {low:g}" if self.at_most is None else f"at most {high:g}"
        met = value is not None and low <= value <= high
        unit = f" {self.unit}" if self.unit else ""
        return f" Required beforehand: {limit}{unit}; {'met' if met else 'not met'}."

    def claim(self, value: Value, facts: Mapping[str, Any], *, computed: bool = True) -> Claim:
        """Combine the row with its value.

        Args:
            value: Value computed here; None if it cannot be tested.
            facts: Values of the replacement fields.
            computed: False if a quick reproduction omits the value.
        """
        quantity, why = self.quantity, NOT_COMPUTED
        if computed:
            quantity = quantity.format_map(facts)
            why = self.why.format_map(facts) + self.requirement(value)
        tolerance = self.tolerance
        if tolerance is None and isinstance(self.paper, bool):
            tolerance = 0.0
        return Claim(
            self.id,
            quantity,
            value,
            self.unit,
            why,
            self.paper,
            tolerance,
            self.source,
            calibrated=self.calibrated,
            infeasible=self.infeasible and computed,
        )
