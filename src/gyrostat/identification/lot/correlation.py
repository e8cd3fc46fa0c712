"""Correlation between the parameters of a lot, with the errors of the fits taken out.

The covariance of the estimates is that of the wheels plus the mean covariance of the errors;
its difference is unbiased whatever the distributions are. Intervals by bootstrap over the wheels.
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix

BOOTSTRAPS = 1000
SEED = 20260101
LEAST_SHARE = 0.05
"""Least share of the variance of the estimates for which the spread of the wheels is taken as
known well enough for a correlation."""


@dataclass(frozen=True)
class Correlation(Described):
    """Correlation between the parameters of a lot, (p, p) each; NaN where it is not determined.

    Attributes:
        value: Correlation of the true parameters.
        low: Lower end of the 95 % interval.
        high: Upper end.
        estimates: Correlation of the estimates, errors included.
    """

    value: Matrix
    low: Matrix
    high: Matrix
    estimates: Matrix


def spread_covariance(values: Matrix, covariances: Matrix) -> Matrix:
    """Covariance of the true parameters, (p, p), SI.

    Args:
        values: Estimates, (n, p).
        covariances: Covariance of the errors of each wheel, (n, p, p).
    """
    return np.cov(values, rowvar=False).reshape(covariances.shape[1:]) - covariances.mean(axis=0)


def correlation(values: Matrix, covariances: Matrix) -> Correlation:
    """Correlation of the true parameters, with intervals; for the arguments see above."""
    unit = np.std(values, axis=0, ddof=1)
    scaled, errors = values / unit, covariances / np.outer(unit, unit)
    random = np.random.default_rng(SEED)
    count = len(values)
    draws = [
        _normalised(spread_covariance(scaled[chosen], errors[chosen]))
        for chosen in random.integers(0, count, (BOOTSTRAPS, count))
    ]
    value = _normalised(spread_covariance(scaled, errors))
    known = np.isfinite(value)
    with np.errstate(invalid="ignore"):
        low, high = np.percentile(np.where(np.isfinite(draws), draws, 0.0), [2.5, 97.5], axis=0)
    low, high = (np.where(known, end, np.nan) for end in (low, high))
    return Correlation(value, low, high, np.corrcoef(scaled, rowvar=False).reshape(value.shape))


def _normalised(covariance: Matrix) -> Matrix:
    """Correlation of a covariance in units of the spread of the estimates."""
    variance = np.where(np.diag(covariance) > LEAST_SHARE, np.diag(covariance), np.nan)
    matrix = np.clip(covariance / np.sqrt(np.outer(variance, variance)), -1.0, 1.0)
    np.fill_diagonal(matrix, np.where(np.isfinite(variance), 1.0, np.nan))
    return matrix


def possible(matrix: Matrix) -> Matrix:
    """Nearest correlation matrix by its eigenvalues; unknown correlations are zero."""
    known = np.where(np.isfinite(matrix), matrix, 0.0)
    np.fill_diagonal(known, 1.0)
    level, axes = np.linalg.eigh(known)
    positive = (axes * np.maximum(level, 1e-9)) @ axes.T
    deviation = np.sqrt(np.diag(positive))
    return positive / np.outer(deviation, deviation)
