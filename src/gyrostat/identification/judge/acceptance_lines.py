"""Lines of an acceptance test and their verdicts.

A line passes if the true value lies within the limits with a probability of at least 95 %, and
fails if it lies outside with at least 95 % (conformance probability, JCGM 106:2012, "The role of
measurement uncertainty in conformity assessment", section 7).
"""

from collections import Counter
from dataclasses import dataclass

from scipy.special import ndtr

from gyrostat.core.pictured import Described, Listed
from gyrostat.core.text import or_none, plain
from gyrostat.core.units import RPM, si_unit
from gyrostat.wheel.sheet_limits import QUANTITIES, Limit

CONFIDENCE = 0.95
"""Probability with which a value must lie inside its limits to pass, or outside them to fail."""
PASS, FAIL, UNDECIDED = "pass", "fail", "undecided"
NOT_JUDGED, NO_LIMIT = "cannot be judged", "no limit"
SENSES = {0: "", 1: "positive sense", -1: "negative sense"}


@dataclass(frozen=True)
class Line(Described):
    """One line of an acceptance test.

    Attributes:
        limit: Quantity and limits of the data sheet.
        sense: Sense of rotation, +1 or -1; 0 if the line holds for both.
        measured: Measured value, SI; None without one.
        sigma: Standard deviation of the measured value, SI; None without a value.
        verdict: "pass", "fail", "undecided", "cannot be judged" or "no limit".
        why: Reason why the quantity cannot be judged; empty otherwise.
    """

    limit: Limit
    sense: int
    measured: float | None
    sigma: float | None
    verdict: str
    why: str = ""

    @property
    def title(self) -> str:
        """Quantity with its conditions and sense of rotation."""
        at = {"speed": (RPM, "rpm"), "current": (1.0, "A")}
        words = [f"{plain(v / at[n][0])} {at[n][1]}" for n, v in self.limit.conditions.items()]
        title = QUANTITIES[self.limit.quantity].title
        title += f" at {' and '.join(words)}" if words else ""
        return f"{title}, {SENSES[self.sense]}" if self.sense else title

    @property
    def margin(self) -> float | None:
        """Distance to the nearer limit, SI; negative outside; None without value or limit."""
        if self.measured is None or not self.limit.limited:
            return None
        return min(self.measured - self.limit.minimum, self.limit.maximum - self.measured)

    def to_dict(self) -> dict[str, object]:
        """Row of the acceptance test in validation.json."""
        limit, margin = self.limit, self.margin
        return {
            "quantity": limit.quantity,
            "title": self.title,
            "sense": self.sense,
            "conditions": dict(limit.conditions),
            "unit": si_unit(QUANTITIES[limit.quantity].dimension),
            "value": limit.value,
            "minimum": or_none(limit.minimum),
            "maximum": or_none(limit.maximum),
            "source": limit.source,
            "measured": self.measured,
            "sigma": self.sigma,
            "margin": margin,
            "margin_in_sigma": margin / self.sigma if margin is not None and self.sigma else None,
            "conformance_probability": None
            if self.measured is None or self.sigma is None or not limit.limited
            else conformance(limit, self.measured, self.sigma),
            "verdict": self.verdict,
            "why": self.why,
        }


@dataclass(frozen=True)
class Acceptance(Listed):
    """Judgement of a wheel against its data sheet.

    Attributes:
        sheet: Name of the wheel in the data sheet.
        lines: Lines in the order of the sheet.
        notes: Remarks that concern all lines.
    """

    sheet: str
    lines: tuple[Line, ...]
    notes: tuple[str, ...] = ()

    @property
    def failed(self) -> bool:
        """Whether a line fails."""
        return any(line.verdict == FAIL for line in self.lines)

    @property
    def verdict(self) -> str:
        """Result of the test in one line."""
        count = Counter(line.verdict for line in self.lines if line.verdict != NO_LIMIT)
        text = ", ".join(f"{n} {verdict}" for verdict, n in count.items()) or "no line has a limit"
        complete = set(count) == {PASS}
        result = "REJECTED" if self.failed else "accepted" if complete else "NOT YET ACCEPTED"
        return f"{self.sheet}: {result} ({text})"

    def to_dict(self) -> dict[str, object]:
        """Part `acceptance` of validation.json."""
        return {
            "sheet": self.sheet,
            "failed": self.failed,
            "verdict": self.verdict,
            "confidence": CONFIDENCE,
            "notes": list(self.notes),
            "lines": [line.to_dict() for line in self.lines],
        }


def conformance(limit: Limit, value: float, sigma: float) -> float:
    """Probability that the true value lies within its limits.

    Args:
        limit: Limits.
        value: Measured value, SI.
        sigma: Standard deviation of the measured value, SI; may be zero.
    """
    if sigma == 0.0:
        return float(limit.minimum <= value <= limit.maximum)
    return float(ndtr((limit.maximum - value) / sigma) - ndtr((limit.minimum - value) / sigma))


def judged(limit: Limit, value: float, sigma: float) -> str:
    """Verdict on a value that can be judged."""
    if not limit.limited:
        return NO_LIMIT
    chance = conformance(limit, value, sigma)
    return PASS if chance >= CONFIDENCE else FAIL if chance <= 1.0 - CONFIDENCE else UNDECIDED
