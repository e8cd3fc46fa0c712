"""Distribution of the wheels of a lot, whose parameters depend on each other."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

from gyrostat.core.skewed_normal import value_at
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import Correlated


@dataclass(frozen=True, eq=False)
class WheelLot(Correlated):
    """A wheel drawn from a lot, whatever the nominal values are.

    Attributes:
        location: Median of each parameter, (keys,), SI.
        scale: Scale of each parameter, (keys,), SI.
        shape: Shape of each parameter, (keys,).
        root: Matrix from independent standard normal numbers to correlated ones, (keys, keys).
    """

    name = "lot"
    location: Vector
    scale: Vector
    shape: Vector
    root: Matrix

    @classmethod
    def of(cls, nominal: Vector, rows: Matrix) -> Self:
        """See `Distribution.of`; a row has location, scale, shape and its part of the root."""
        location, scale, shape = rows[:, :3].T
        return cls(nominal, location, scale, shape, rows[:, 3:])

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        return value_at(self.normal(share), self.location, self.scale, self.shape)

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        if self.root.shape != (len(self.nominal),) * 2:
            yield "correlation", "a square matrix with a row for each key"

    def deviation(self) -> Vector:
        """See `Distribution.deviation`; for small ones."""
        return self.scale

    def extremes(self, sigmas: float) -> tuple[Vector, Vector]:
        """See `Distribution.extremes`."""
        low, high = (
            value_at(sign * sigmas, self.location, self.scale, self.shape) for sign in (-1.0, 1.0)
        )
        return low, high
