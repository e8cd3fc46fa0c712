"""Kinds of gyro noise: covariance, and variance of the cosine transform of a record.

The names and definitions are those of IEEE Std 952-1997, annex C. The integral of the rate is the
angle; f is a frequency and tau an averaging time.

    name                parameter  unit       spectrum of the rate (two-sided)   Allan variance
    quantisation        Q          rad        4 Q² sin²(pi f T) / T              3 Q² / tau²
    angle_walk          N          rad/√s     N²                                 N² / tau
    bias_instability    B          rad/s      B² / (2 pi f)                      B² 2 ln 2 / pi
    bias_walk           K          rad/s/√s   K² / (2 pi f)²                     K² tau / 3

A record has the mean rates over its intervals T. The type II cosine transform diagonalises the
covariance of white noise and of the random walk exactly, that of flicker noise to correlations of
at most 0.12 (neighbours of the lowest frequencies). Its coefficients beside the mean are therefore
treated as independent.
"""

from collections.abc import Callable

import numpy as np
from scipy.special import zeta

from gyrostat.core.types import Matrix, Vector

NAMES = ("quantisation", "angle_walk", "bias_instability", "bias_walk")
"""The kinds of noise; each parameter is a standard deviation, so that variances add."""
LOWEST = 64
"""Number of low frequencies that are treated one by one."""
_REFERENCE = 4096
"""Length of the record on which the end effects of flicker noise are computed."""


def _angle_kernels() -> dict[str, Callable[[Vector], Vector]]:
    """Generalised covariance g(t) of the angle for a parameter of 1; t >= 0, s."""

    def flicker(time: Vector) -> Vector:
        return time**2 * np.log(np.where(time > 0.0, time, 1.0)) / (2.0 * np.pi)

    return {
        "quantisation": lambda time: (time == 0.0).astype(float),
        "angle_walk": lambda time: -0.5 * time,
        "bias_instability": flicker,
        "bias_walk": lambda time: time**3 / 12.0,
    }


PULSE = "quantisation"
"""Kind of noise whose errors of the angle are independent from sample to sample."""
ANGLE_KERNELS = _angle_kernels()
"""Kind of noise -> generalised covariance of the angle, for a parameter of 1.

Differences of the angle whose weights annul constants and lines have the covariance that g gives;
the random walks themselves have none (G. Matheron, "The intrinsic random functions and their
applications", Advances in Applied Probability 5, 1973).
"""


def mean_rate_covariance(name: str, lag: Vector) -> Vector:
    """Generalised covariance of mean rates over intervals of 1 s, at lags in intervals.

    Args:
        name: Kind of noise.
        lag: Lags, whole numbers of 0 or more.
    """
    kernel = ANGLE_KERNELS[name]
    return 2.0 * kernel(lag) - kernel(lag + 1.0) - kernel(np.abs(lag - 1.0))


def allan_variances(time: Vector) -> Matrix:
    """Allan variance of each kind for a parameter of 1, (4, times), at averaging times, s."""
    return np.array(
        [
            (6.0 * g(np.zeros_like(time)) - 8.0 * g(time) + 2.0 * g(2.0 * time)) / (2.0 * time**2)
            for g in ANGLE_KERNELS.values()
        ]
    )


def coefficient_variances(count: int, interval: float) -> Matrix:
    """Variance of each coefficient of the cosine transform for parameters of 1, (4, count - 1).

    Args:
        count: Number of mean rates of the record.
        interval: Interval T, s.

    Returns:
        Variances of the orthonormal transform's coefficients 1, 2, ..., for the kinds in `NAMES`.
    """
    number = np.arange(1.0, count)
    turn = number / (2.0 * count)  # frequency times interval, 0 to 1/2
    difference = 4.0 * np.sin(np.pi * turn) ** 2
    # aliases of f^-3: the flicker spectrum times that of the mean
    aliases = (zeta(3.0, turn) + zeta(3.0, 1.0 - turn)) / (2.0 * np.pi) ** 3
    return np.array(
        [
            (difference * (count - 1.0) + 4.0) / count / interval**2,
            np.full(count - 1, 1.0 / interval),
            difference * aliases * _flicker_ends(count),
            (2.0 + np.cos(2.0 * np.pi * turn)) / 3.0 / difference * interval,
        ]
    )


def _flicker_ends(count: int) -> Vector:
    """Variance of flicker coefficients over that of the spectrum, (count - 1,), below 1.

    The excess below 1 is inversely proportional to the number of the coefficient.
    """
    low = np.arange(1.0, min(LOWEST, count - 1) + 1.0)[:, None]
    length = _REFERENCE
    lag = np.arange(1.0, length)
    covariance = mean_rate_covariance("bias_instability", lag)
    phase = np.pi * low * lag / length
    weights = (length - lag) * np.cos(phase) - np.sin(phase) / np.sin(np.pi * low / length)
    zero = mean_rate_covariance("bias_instability", np.zeros(1))[0]
    exact = zero + 2.0 * weights @ covariance / length
    turn = low[:, 0] / (2.0 * length)
    spectrum = 4.0 * np.sin(np.pi * turn) ** 2 * (zeta(3.0, turn) + zeta(3.0, 1.0 - turn))
    ratio = exact / (spectrum / (2.0 * np.pi) ** 3)
    high = np.arange(low.size + 1.0, count)
    return np.concatenate([ratio, 1.0 - (1.0 - ratio[-1]) * low.size / high])
