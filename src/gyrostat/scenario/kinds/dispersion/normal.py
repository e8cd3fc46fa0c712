"""Normal distribution."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from gyrostat.core.orthonormal import HERMITE
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import DEVIATION, Distribution, Parameter


@dataclass(frozen=True, eq=False)
class Normal(Distribution):
    """The nominal value is the mean."""

    name = "normal"
    family = HERMITE
    sigma: Annotated[Vector, Parameter(DEVIATION, "Standard deviation.")]

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        from scipy.special import ndtri  # slow to import

        return self.nominal + self.sigma * ndtri(share)

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        if not np.all(self.sigma > 0.0):
            yield "sigma", "a sigma above 0, not in % of 0"

    def deviation(self) -> Vector:
        """See `Distribution.deviation`."""
        return self.sigma
