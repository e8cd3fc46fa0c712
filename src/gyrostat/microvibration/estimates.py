"""Estimates with their standard deviations and intervals of 95 %."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.text import or_none

QUANTILE = 1.959963984540054
"""Standard deviations on either side of the 95 % interval of a normal distribution."""


@dataclass(frozen=True)
class Estimate(Described):
    """Estimate of one parameter, SI units.

    Attributes:
        value: Estimate.
        sigma: Standard deviation.
        low: Lower end of the 95 % interval.
        high: Upper end of the 95 % interval.
        unit: Unit.
    """

    value: float
    sigma: float
    low: float
    high: float
    unit: str

    @property
    def observable(self) -> bool:
        """Whether the interval is finite and does not hold 0."""
        return bool(np.isfinite(self.high) and self.low > 0.0)

    @classmethod
    def normal(cls, value: float, sigma: float, unit: str) -> "Estimate":
        """Estimate with normal errors."""
        return cls(value, sigma, value - QUANTILE * sigma, value + QUANTILE * sigma, unit)

    @classmethod
    def of_logarithm(cls, value: float, sigma: float, unit: str) -> "Estimate":
        """Estimate from that of its natural logarithm."""
        half = min(QUANTILE * sigma, 500.0)
        ends = np.exp(value + half * np.array([-1.0, 1.0]))
        middle = float(np.exp(value))
        return cls(middle, middle * sigma, float(ends[0]), float(ends[1]), unit)

    @classmethod
    def of_square(cls, value: float, sigma: float, unit: str) -> "Estimate":
        """Estimate of a size of 0 or more from that of its square."""
        ends = np.sqrt(np.maximum(value + QUANTILE * sigma * np.array([-1.0, 1.0]), 0.0))
        middle = float(np.sqrt(max(value, 0.0)))
        spread = sigma / (2.0 * middle) if middle > 0.0 else float(np.sqrt(sigma))
        return cls(middle, spread, float(ends[0]), float(ends[1]), unit)

    def as_json(self) -> dict[str, Any]:
        """Content of disturbance.json."""
        numbers = (self.value, self.sigma, self.low, self.high)
        names = ("value", "sigma", "low", "high")
        content: dict[str, Any] = {
            name: or_none(number) for name, number in zip(names, numbers, strict=True)
        }
        return {**content, "unit": self.unit, "observable": self.observable}
