"""Slow friction noise: an Ornstein-Uhlenbeck process seen through white noise.

Block k at time t_k has the noise n(t_k) + e_k, with covariance

    V = s² [ratio exp(-|t_j - t_k| / time) + diag(white)],

so ratio is the variance of the slow noise over that of the white noise of a block of weight 1. The
inverse of the first part is tridiagonal for any times, so that quadratic forms with V⁻¹ cost O(N):
V⁻¹ = W - W (P + W)⁻¹ W with W = diag(1 / white), P the tridiagonal inverse.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.types import Matrix, Vector


@dataclass(frozen=True)
class Noise:
    """Parameters of the noise, apart from its scale.

    Attributes:
        log_ratio: Logarithm of the variance of the slow noise over that of the white noise.
        log_time: Logarithm of the correlation time, s.
    """

    log_ratio: float
    log_time: float


def gram(columns: Matrix, time: Vector, white: Vector, noise: Noise) -> tuple[Matrix, float]:
    """Products Uᵀ V⁻¹ U of columns, and log det V, both for the scale s = 1.

    Args:
        columns: Columns U, (N, M), in the order of memory of Fortran or C.
        time: Times of the blocks, increasing, (N,), s.
        white: Variances of the white noise over the scale, (N,).
        noise: Parameters of the noise.
    """
    from scipy.linalg import lapack

    factor: Any = lapack.dpttrf  # pyright: ignore[reportAttributeAccessIssue]
    solve: Any = lapack.dpttrs  # pyright: ignore[reportAttributeAccessIssue]
    variance = np.exp(noise.log_ratio)
    decay = np.exp(-np.diff(time) / np.exp(noise.log_time))
    fresh = -np.expm1(2.0 * np.log(np.maximum(decay, 1e-300)))
    inverse = 1.0 / (variance * fresh)
    main = np.empty(time.size)
    main[0] = 1.0 / variance
    main[1:] = inverse
    main[:-1] += decay * decay * inverse
    weight = 1.0 / white
    diagonal, lower, _ = factor(main + weight, -decay * inverse)
    weighted = columns * weight[:, None]
    solved, _ = solve(diagonal, lower, weighted)
    log_det = float(
        np.sum(np.log(white))
        + np.log(variance)
        + np.sum(np.log(variance * fresh))
        + np.sum(np.log(diagonal))
    )
    return columns.T @ weighted - weighted.T @ solved, log_det


def window_covariance(time: Vector, start: float, end: float, correlation_time: float) -> Vector:
    """Covariance of the slow noise, of variance 1, with its mean over a window, (N,).

    Args:
        time: Times within the window, (N,), s.
        start: Start of the window, s.
        end: End of the window, s.
        correlation_time: Correlation time, s.
    """
    tau = correlation_time
    return tau / (end - start) * (2.0 - np.exp((start - time) / tau) - np.exp((time - end) / tau))


def window_variance(start: float, end: float, correlation_time: float) -> float:
    """Variance of the mean of the slow noise, of variance 1, over a window."""
    share = correlation_time / (end - start)
    return float(2.0 * share * (1.0 + share * np.expm1(-1.0 / share)))
