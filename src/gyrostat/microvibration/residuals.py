"""Residuals of a fitted background between the lines."""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix
from gyrostat.microvibration.kind_model import KindModel

Background = tuple[Matrix, Matrix]
"""Result of `KindModel.background`."""


@dataclass(frozen=True)
class Residuals:
    """Statistics of the residuals between the lines.

    Attributes:
        spread: Relative variance of a bin of one spectrum.
        correlated: Sum of correlations of a bin with all others, 1 for independent bins.
        misfit: Correlation of residuals too far apart for the window: 0 for a model that fits.
    """

    spread: float
    correlated: float
    misfit: float

    @property
    def variance(self) -> float:
        """Relative variance of a bin times the number of bins that count as one."""
        return self.spread * self.correlated

    @classmethod
    def of(cls, model: KindModel, background: Background) -> "Residuals":
        """Statistics for a background of a model."""
        shown, shape = background
        scaled = model.used * (model.density / shown - 1.0) / np.sqrt(shape)
        total = max(float(model.used.sum()), 1.0)
        spread = float(np.sum(scaled**2)) / total
        lags = {lag: _lagged(scaled, model.used, lag) / spread for lag in (1, 2, 3, 6, 9, 12)}
        return cls(
            spread,
            1.0 + 2.0 * max(lags[1] + lags[2] + lags[3], 0.0),
            float(np.mean([lags[lag] for lag in (6, 9, 12)])),
        )


def _lagged(scaled: Matrix, used: Matrix, lag: int) -> float:
    pairs = float(np.sum(used[:, lag:] * used[:, :-lag]))
    return float(np.sum(scaled[:, lag:] * scaled[:, :-lag])) / max(pairs, 1.0)
