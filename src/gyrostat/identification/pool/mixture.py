"""Mixture of normal distributions."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri  # scipy.stats takes long to import

from gyrostat.core.types import Vector

NEGLIGIBLE = 1e-10
"""Weights below this share of the largest one are left out."""


@dataclass(frozen=True)
class Mixture:
    """Mixture of normal distributions.

    Attributes:
        weight: Weights, whose sum is 1, (g,).
        means: Means, (g,).
        sigmas: Standard deviations, (g,).
    """

    weight: Vector
    means: Vector
    sigmas: Vector

    @property
    def mean(self) -> float:
        """Mean."""
        return float(self.weight @ self.means)

    @property
    def sigma(self) -> float:
        """Half of the width of the central 68.27 %: the standard deviation may be infinite."""
        low, high = (self.quantile(float(ndtr(z))) for z in (-1.0, 1.0))
        return 0.5 * (high - low)

    def share_below(self, value: float) -> float:
        """Distribution function."""
        return float(self.weight @ ndtr((value - self.means) / self.sigmas))

    def score(self, value: float) -> float:
        """Standard normal number with the same share below."""
        below = self.share_below(value)
        if below > 0.5:
            above = float(self.weight @ ndtr((self.means - value) / self.sigmas))
            return float(-ndtri(above))
        return float(ndtri(below))

    def log_density(self, value: float) -> float:
        """Logarithm of the density."""
        score = (value - self.means) / self.sigmas
        logs = -0.5 * score**2 - np.log(self.sigmas * np.sqrt(2.0 * np.pi))
        top = float(logs.max())
        return top + float(np.log(self.weight @ np.exp(logs - top)))

    def quantile(self, share: float) -> float:
        """Quantile, by bisection."""
        ends = self.means + self.sigmas * float(ndtri(share))
        low, high = float(ends.min()), float(ends.max())
        for _ in range(200):
            middle = 0.5 * (low + high)
            if not low < middle < high or high - low < 1e-12 * max(abs(low), abs(high)):
                break
            low, high = (middle, high) if self.share_below(middle) < share else (low, middle)
        return 0.5 * (low + high)


def weighted_quantile(values: Vector, weight: Vector, share: float) -> float:
    """Quantile of weighted points of a smooth distribution."""
    order = np.argsort(values, kind="stable")
    level = np.cumsum(weight[order]) - 0.5 * weight[order]
    return float(np.interp(share, level, values[order]))
