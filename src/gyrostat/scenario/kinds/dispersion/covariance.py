"""Normal distribution of values that depend on each other."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import Correlated


@dataclass(frozen=True, eq=False)
class Covariance(Correlated):
    """Normal about the nominal values, with the covariance of an identification.

    Attributes:
        root: Matrix from standard normal numbers to deviations, (keys, keys), SI; its product with
            its transpose is the covariance.
    """

    name = "covariance"
    root: Matrix

    @classmethod
    def of(cls, nominal: Vector, rows: Matrix) -> Self:
        """See `Distribution.of`."""
        return cls(nominal, rows)

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        return self.nominal + self.normal(share)

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        if self.root.shape != (len(self.nominal),) * 2:
            yield "covariance", "a square matrix with a row for each key"

    def deviation(self) -> Vector:
        """See `Distribution.deviation`."""
        return np.linalg.norm(self.root, axis=1)

    def extremes(self, sigmas: float) -> tuple[Vector, Vector]:
        """See `Distribution.extremes`."""
        deviation = sigmas * self.deviation()
        return self.nominal - deviation, self.nominal + deviation
