"""Log-normal distribution."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from gyrostat.core.orthonormal import HERMITE
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import RATIO, Distribution, Parameter


@dataclass(frozen=True, eq=False)
class LogNormal(Distribution):
    """The natural logarithm is normal, and the nominal value, not 0, is the median."""

    name = "log_normal"
    family = HERMITE
    sigma: Annotated[Vector, Parameter(RATIO, "Standard deviation of the natural logarithm.")]

    def quantile(self, share: Matrix) -> Matrix:
        """See `Distribution.quantile`."""
        from scipy.special import ndtri  # slow to import

        return self.nominal * np.exp(self.sigma * ndtri(share))

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        if not np.all((self.sigma > 0.0) & (self.sigma <= 10.0)):
            yield "sigma", "a sigma of the logarithm, above 0 to 10"
        if np.any(self.nominal == 0.0):
            yield "distribution", "another one, because the nominal value is 0"

    def deviation(self) -> Vector:
        """See `Distribution.deviation`; for small ones."""
        return self.sigma * np.abs(self.nominal)
