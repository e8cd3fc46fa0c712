"""Uniform distribution."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from gyrostat.core.orthonormal import LEGENDRE, Family
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import VALUE, Distribution, Parameter


@dataclass(frozen=True, eq=False)
class Uniform(Distribution):
    """All values from `low` to `high` are equally likely."""

    name = "uniform"
    low: Annotated[Vector, Parameter(VALUE, "Smallest value.")]
    high: Annotated[Vector, Parameter(VALUE, "Largest value.")]

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        return self.low + share * (self.high - self.low)

    def families(self) -> list[Family]:
        """See `Distribution.families`."""
        return [LEGENDRE] * len(self.nominal)

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        if not np.all(self.low < self.high):
            yield "high", "more than low"

    def bounds(self) -> tuple[Vector, Vector]:
        """See `Distribution.bounds`."""
        return self.low, self.high
