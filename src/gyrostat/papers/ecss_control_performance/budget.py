"""Budget of a pointing error index."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from gyrostat.core.types import Vector
from gyrostat.papers.ecss_control_performance.setup import LEVEL

Index = Float[np.ndarray, "values 3"]


class Budget(NamedTuple):
    """Budget of an index; all arrays about the axes x, y and z.

    Attributes:
        means: Source -> mean over time and members, (3,), arcsec.
        sigmas: Source -> standard deviation over time and members, (3,), arcsec.
        whole: Index of the sum of all errors, over time and members, arcsec.
    """

    means: dict[str, Vector]
    sigmas: dict[str, Vector]
    whole: Index

    @property
    def sigma(self) -> Vector:
        """Standard deviation of the whole, (3,), arcsec."""
        return np.std(self.whole, axis=0)

    @property
    def size(self) -> Vector:
        """Size that the whole does not exceed in `LEVEL` of time and members, (3,), arcsec."""
        return np.quantile(np.abs(self.whole), LEVEL, axis=0)
