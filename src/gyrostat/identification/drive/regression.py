"""Linear regression with instruments, and its covariance with correlated errors."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.read.statistics import correlation_length

FEWEST_LAGS, LENGTHS = 60, 5
"""Lags of the covariance: at least so many, and so many correlation lengths of the errors."""


def regress(instruments: Matrix, regressors: Matrix, target: Vector) -> Vector:
    """Solution x of Z' (y - X x) = 0, (n,); with Z = X that of least squares.

    Args:
        instruments: Instruments Z, (m, n).
        regressors: Regressors X, (m, n).
        target: Left-hand side y, (m,).
    """
    scale = np.linalg.norm(regressors, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    basis = np.linalg.qr(instruments)[0]
    return np.linalg.lstsq(basis.T @ (regressors / scale), basis.T @ target, rcond=1e-12)[0] / scale


def covariance(
    instruments: Matrix,
    regressors: Matrix,
    error: Vector,
    places: Sequence[NDArray[np.intp]],
) -> Matrix:
    """Covariance of `regress` with stationary errors independent of the instruments, (n, n).

    The autocovariance of the errors is estimated with the weights of Parzen, which keep it positive
    semi-definite. It has less variance than the covariance of the products of errors and
    instruments (Newey and West 1987), which few reversals of the motion determine.

    Args:
        instruments: Instruments, (m, n).
        regressors: Regressors, (m, n).
        error: Errors y - X x, (m,).
        places: Place of each row in the windows of its part, in time order, for each part.
    """
    basis = np.linalg.qr(instruments)[0]
    inverse = np.linalg.pinv(basis.T @ regressors)
    count, size = basis.shape
    ends = np.cumsum([len(place) for place in places])[:-1]
    parts = []
    for place, rows, values in zip(
        places, np.split(basis, ends), np.split(error, ends), strict=True
    ):
        # windows that are not used are zeros
        table = np.zeros((place[-1] - place[0] + 1 if len(place) else 0, size + 2))
        table[place - place[0] if len(place) else place] = np.column_stack(
            [rows, values, np.ones(len(place))]
        )
        parts.append(table)
    lags = min(max(FEWEST_LAGS, LENGTHS * correlation_length(error)), count // 4)
    meat = np.zeros((size, size))
    for lag in range(lags + 1):
        pairs = [(part[lag:], part[: len(part) - lag]) for part in parts if len(part) > lag]
        number = sum(float(a[:, -1] @ b[:, -1]) for a, b in pairs)
        together = sum(float(a[:, -2] @ b[:, -2]) for a, b in pairs) / max(number, 1.0)
        cross = sum((a[:, :size].T @ b[:, :size] for a, b in pairs), np.zeros((size, size)))
        meat += _parzen(lag / (lags + 1.0)) * together * (cross + cross.T if lag else cross)
    values, vectors = np.linalg.eigh(0.5 * (meat + meat.T))
    meat = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return inverse @ meat @ inverse.T * count / max(count - size, 1)


def _parzen(x: float) -> float:
    """Parzen window at 0 to 1."""
    return 1.0 - 6.0 * x**2 + 6.0 * x**3 if x <= 0.5 else 2.0 * (1.0 - x) ** 3


def weakest(instruments: Matrix, regressors: Matrix) -> float:
    """F statistic of the weakest combination of instruments (Cragg and Donald 1993)."""
    left, right = np.linalg.qr(instruments)[0], np.linalg.qr(regressors)[0]
    least = float(np.linalg.svd(left.T @ right, compute_uv=False).min())
    count, size = instruments.shape
    return (count - size) * least**2 / max(1.0 - least**2, 1e-12)
