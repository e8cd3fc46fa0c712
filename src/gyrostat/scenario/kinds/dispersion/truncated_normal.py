"""Truncated normal distribution."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import Annotated

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import DEVIATION, VALUE, Limited, Parameter


@dataclass(frozen=True, eq=False)
class TruncatedNormal(Limited):
    """Normal about the nominal value, without the values below `low` and above `high`."""

    name = "truncated_normal"
    sigma: Annotated[Vector, Parameter(DEVIATION, "Standard deviation of the whole distribution.")]
    low: Annotated[Vector, Parameter(VALUE, "Smallest value, at most the nominal one.", -inf)]
    high: Annotated[Vector, Parameter(VALUE, "Largest value, at least the nominal one.", inf)]

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        from scipy.special import ndtr, ndtri  # slow to import

        below, beyond = (
            ndtr(sign * (bound - self.nominal) / self.sigma)
            for sign, bound in ((1.0, self.low), (-1.0, self.high))
        )
        # each half from its own end: near 1 a share has few digits left
        lower = below + share * (1.0 - below - beyond)
        upper = beyond + (1.0 - share) * (1.0 - below - beyond)
        normal = np.where(lower < 0.5, ndtri(lower), -ndtri(upper))
        return np.clip(self.nominal + self.sigma * normal, self.low, self.high)

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        if not np.all(self.sigma > 0.0):
            yield "sigma", "a sigma above 0, not in % of 0"
        yield from super().faults()
        if not np.all(self.low <= self.nominal):
            yield "low", "at most the nominal value"
        if not np.all(self.nominal <= self.high):
            yield "high", "at least the nominal value"

    def deviation(self) -> Vector:
        """See `Distribution.deviation`; NaN where it has bounds."""
        return np.where(self.is_bounded(), np.nan, self.sigma)
