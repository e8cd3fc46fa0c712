"""Noise parameters of a gyro axis, and the units of data sheets."""

import math
from dataclasses import dataclass
from typing import Any

from gyrostat.core.pictured import Listed
from gyrostat.core.text import plain
from gyrostat.core.units import known_unit
from gyrostat.core.views import lines as text_view


@dataclass(frozen=True)
class ParameterKind:
    """Parameter of a gyro's noise.

    Attributes:
        title: Name in texts.
        letter: Letter in IEEE Std 952.
        unit: SI unit.
        sheet_unit: Unit of data sheets.
        factor: SI value of a data sheet unit.
        hidden: What hides the parameter where the record does not determine it.
    """

    title: str
    letter: str
    unit: str
    sheet_unit: str
    factor: float
    hidden: str


def _kind(
    title: str, letter: str, dimension: str, unit: str, sheet: str, hidden: str
) -> ParameterKind:
    known = known_unit(sheet, dimension)
    assert known is not None
    return ParameterKind(title, letter, unit, sheet, known.factor, hidden)


PARAMETERS: dict[str, ParameterKind] = {
    "quantisation": _kind(
        "quantisation", "Q", "angle", "rad", "arcsec", "the angle random walk hides it"
    ),
    "angle_walk": _kind(
        "angle random walk",
        "N",
        "angle_random_walk",
        "rad/√s",
        "deg/√h",
        "quantisation and bias instability explain the noise",
    ),
    "bias_instability": _kind(
        "bias instability",
        "B",
        "speed",
        "rad/s",
        "deg/h",
        "angle and rate random walk explain the lowest part of the curve",
    ),
    "bias_walk": _kind(
        "rate random walk",
        "K",
        "rate_random_walk",
        "rad/s/√s",
        "deg/h/√h",
        "the record is too short to tell it from the other noise",
    ),
    "rate_ramp": ParameterKind(
        "rate ramp",
        "R",
        "rad/s²",
        "deg/h/h",
        known_unit("deg/h", "speed").factor / 3600.0,  # pyright: ignore[reportOptionalMemberAccess]
        "no trend stands out from the noise of low frequency",
    ),
}
"""Name of a parameter -> its kind."""
QUANTILE = 1.959963984540054
"""Standard deviations on either side of the 95 % interval of a normal distribution."""


@dataclass(frozen=True)
class Estimate(Listed):
    """Estimate of one parameter, SI units.

    Attributes:
        name: Key of `PARAMETERS`.
        value: Value of the largest likelihood.
        low: Lower end of the 95 % interval.
        high: Upper end of the 95 % interval.
        observable: Whether the record determines the parameter: whether its interval is without 0.
    """

    name: str
    value: float
    low: float
    high: float

    @property
    def observable(self) -> bool:
        """Whether the interval does not hold 0."""
        return self.low > 0.0 or self.high < 0.0

    @property
    def kind(self) -> ParameterKind:
        """Kind of parameter."""
        return PARAMETERS[self.name]

    @property
    def sigma(self) -> float | None:
        """Half width of the interval over 1.96; None where the parameter is not observable."""
        return 0.5 * (self.high - self.low) / QUANTILE if self.observable else None

    @property
    def largest(self) -> float:
        """Largest size within the interval."""
        return max(abs(self.low), abs(self.high))

    @property
    def reason(self) -> str | None:
        """Why the record does not determine the parameter; None if it does."""
        return None if self.observable else self.kind.hidden

    def sheet(self, value: float) -> str:
        """Format a value in the unit of data sheets."""
        return f"{plain(value / self.kind.factor, 3)} {self.kind.sheet_unit}"

    def text(self) -> str:
        """Value with its interval, or why there is none, for a terminal."""
        if not self.observable:
            return (
                f"not observable, because {self.reason}; at most {self.sheet(self.largest)} (95 %)"
            )
        numbers = [each / self.kind.factor for each in (self.value, self.low, self.high)]
        # two digits of the half width
        digits = max(0, 1 - math.floor(math.log10(0.5 * (numbers[2] - numbers[1]))))
        value, low, high = (f"{each:.{digits}f}" for each in numbers)
        return f"{value} {self.kind.sheet_unit}, 95 %: {low} to {high}"

    def as_json(self) -> dict[str, Any]:
        """Entry of allan.json, SI units."""
        return {
            "value": self.value,
            "sigma": self.sigma,
            "low": self.low,
            "high": self.high,
            "unit": self.kind.unit,
            "observable": self.observable,
            "reason": self.reason,
        }


@text_view.register
def estimate_lines(estimate: Estimate) -> list[str]:
    """Name and value of an estimate, for a terminal."""
    return [f"{estimate.kind.letter} {estimate.kind.title}  {estimate.text()}"]
