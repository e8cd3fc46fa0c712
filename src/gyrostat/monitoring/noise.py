"""Slow friction noise: an Ornstein-Uhlenbeck process seen through white noise.

Block k at time t_k has the noise n(t_k) + e_k, with covariance

    V = s² [ratio exp(-|t_j - t_k| / time) + diag(white)],

so ratio is the variance of the slow noise over that of the white noise of a block of weight 1. The
inverse of the first part is tridiagonal for any times, so that quadratic forms with V⁻¹ cost O(N):
V⁻¹ = W (1 - (P + W)⁻¹ W) with W = diag(1 / white), P the tridiagonal inverse.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

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


def gram(
    columns: Matrix,
    time: Vector,
    white: Vector,
    noises: Sequence[Noise],
    own: Matrix | None = None,
) -> tuple[NDArray[np.float64], Vector]:
    """Products Uᵀ V⁻¹ U of columns, and log det V, both for the scale s = 1, of K noises.

    Args:
        columns: Columns U, (N, M).
        time: Times of the blocks, increasing, (N,), s.
        white: Variances of the white noise over the scale, (N,).
        noises: Parameters of the noises, K of them.
        own: A further last column of each noise, (K, N).

    Returns:
        (K, M, M) or, with `own`, (K, M + 1, M + 1); and (K,).
    """
    from scipy.linalg import lapack

    factor: Any = lapack.dpttrf  # pyright: ignore[reportAttributeAccessIssue]
    solve: Any = lapack.dpttrs  # pyright: ignore[reportAttributeAccessIssue]
    places = np.array([[noise.log_ratio, noise.log_time] for noise in noises])
    variance, correlation_time = np.exp(places).T[:, :, None]
    fresh = -np.expm1(-2.0 * np.diff(time) / correlation_time)
    inverse = 1.0 / (variance * fresh)
    main = np.empty((len(noises), time.size))
    main[:, :1] = 1.0 / variance
    main[:, 1:] = inverse
    main[:, :-1] += (1.0 - fresh) * inverse
    # one tridiagonal matrix of all noises: 0 where that of the next one begins
    beside = np.zeros_like(main)
    beside[:, :-1] = -np.sqrt(1.0 - fresh) * inverse
    diagonal, lower, _ = factor((main + 1.0 / white).ravel(), beside.ravel()[:-1])
    both = np.empty((columns.shape[1] + (own is not None), *main.shape))
    both[: columns.shape[1]] = columns.T[:, None]
    if own is not None:
        both[-1] = own
    weighted = both / white
    solved, _ = solve(diagonal, lower, weighted.reshape(len(both), -1).T)
    both -= solved.T.reshape(both.shape)
    pivots = diagonal.reshape(main.shape) * white
    pivots[:, 1:] /= inverse
    log_det = np.log(variance[:, 0]) + np.sum(np.log(pivots), axis=1)
    return np.matmul(weighted.transpose(1, 0, 2), both.transpose(1, 2, 0)), log_det


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
