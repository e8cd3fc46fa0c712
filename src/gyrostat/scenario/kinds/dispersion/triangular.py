"""Triangular distribution."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import nan
from typing import Annotated

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import VALUE, Limited, Parameter


@dataclass(frozen=True, eq=False)
class Triangular(Limited):
    """The density rises in a straight line from `low` to `mode`, and falls from there to `high`."""

    name = "triangular"
    low: Annotated[Vector, Parameter(VALUE, "Smallest value.")]
    high: Annotated[Vector, Parameter(VALUE, "Largest value.")]
    mode: Annotated[Vector, Parameter(VALUE, "Most likely value.", nan)]

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        width, rise = self.high - self.low, self.mode - self.low
        below = self.low + np.sqrt(share * width * rise)
        above = self.high - np.sqrt((1.0 - share) * width * (width - rise))
        return np.where(share * width < rise, below, above)

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        yield from super().faults()
        if not np.all((self.low <= self.mode) & (self.mode <= self.high)):
            yield "mode", "low to high, by default the nominal value"
