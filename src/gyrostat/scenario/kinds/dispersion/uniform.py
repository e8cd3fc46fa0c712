"""Uniform distribution."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.orthonormal import LEGENDRE
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import VALUE, Limited, Parameter


@dataclass(frozen=True, eq=False)
class Uniform(Limited):
    """All values from `low` to `high` are equally likely."""

    name = "uniform"
    family = LEGENDRE
    low: Annotated[Vector, Parameter(VALUE, "Smallest value.")]
    high: Annotated[Vector, Parameter(VALUE, "Largest value.")]

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        return self.low + share * (self.high - self.low)
