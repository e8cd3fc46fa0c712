"""Overlapping Allan deviation and its uncertainty."""

from collections.abc import Callable

import numpy as np
from scipy.stats import chi2

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.gyro.noise import ANGLE_KERNELS, PULSE

PER_DECADE = 10
"""Averaging times per decade."""
FEWEST = 3
"""Smallest number of averaging times that a record must hold."""
_STEPS, _REACH = 16, 64
"""Lags per averaging time, and largest lag in averaging times, of the sum over covariances."""


def cluster_sizes(count: int) -> Vector:
    """Numbers of samples to average over, increasing, for a record of `count` samples."""
    largest = count // FEWEST
    steps = int(np.ceil(PER_DECADE * np.log10(largest))) + 1
    return np.unique(np.round(np.geomspace(1.0, largest, steps))).astype(int)


def allan_deviations(rate: Vector, sizes: Vector) -> Vector:
    """Overlapping Allan deviation, (sizes,), rad/s (IEEE Std 952-1997, annex C.1).

    Args:
        rate: Mean rates over equal intervals, (N,), rad/s.
        sizes: Numbers of samples to average over, whole numbers of at most N / 2, (sizes,).
    """
    # without its mean, the sum keeps its digits
    angle = np.concatenate([[0.0], np.cumsum(rate - np.mean(rate))])
    deviations = []
    for size in sizes:
        second = angle[2 * size :] - 2.0 * angle[size:-size] + angle[: -2 * size]
        deviations.append(np.sqrt(second @ second / (2.0 * second.size)) / size)
    return np.array(deviations)


def degrees_of_freedom(variances: Vector, count: int, interval: float, sizes: Vector) -> Vector:
    """Equivalent degrees of freedom of overlapping Allan variances, (sizes,).

    Twice the squared mean over the variance of the estimate, from the covariances of the second
    differences of the angle for Gaussian noise.

    Args:
        variances: Squares of the noise parameters in the order of `noise.NAMES`, (4,), SI units.
        count: Number of samples of the record.
        interval: Interval, s.
        sizes: Numbers of samples to average over, (sizes,).
    """
    found = []
    for size in sizes:
        terms = count - 2 * size + 1
        step = max(1, size // _STEPS)
        lag = np.arange(0, min(terms, _REACH * size), step)
        pulse_lag = size * np.arange(3)
        smooth, at_pulses, pulses = np.zeros(lag.size), np.zeros(3), np.zeros(3)
        for variance, (name, kernel) in zip(variances, ANGLE_KERNELS.items(), strict=True):
            part = variance * _second_difference(kernel, pulse_lag, size, interval)
            if name == PULSE:
                pulses = part
            else:
                at_pulses += part
                smooth += variance * _second_difference(kernel, lag, size, interval)
        # the trapezoidal rule on both sides of lag 0, and the pulses at their own lags
        weight = np.where(lag == 0, step, 2.0 * step) * (terms - lag)
        pulse_weight = np.array([1.0, 2.0, 2.0]) * np.maximum(terms - pulse_lag, 0)
        total = at_pulses + pulses
        spread = np.sum(weight * smooth**2) + np.sum(pulse_weight * (total**2 - at_pulses**2))
        found.append((terms * total[0]) ** 2 / spread)
    return np.maximum(np.array(found), 1.0)


def _second_difference(
    kernel: Callable[[Vector], Vector], lag: Vector, size: int, interval: float
) -> Vector:
    """Covariance of second differences of the angle over `size` samples at lags in samples."""
    weights = ((-2, 1.0), (-1, -4.0), (0, 6.0), (1, -4.0), (2, 1.0))
    shifted = [kernel(np.abs(lag + k * size) * interval) * weight for k, weight in weights]
    return np.sum(shifted, axis=0)


def confidence_limits(deviation: Vector, freedom: Vector, level: float) -> Matrix:
    """Limits of the true Allan deviation, (2, sizes), by the chi-square distribution.

    Args:
        deviation: Estimated Allan deviation, (sizes,).
        freedom: Equivalent degrees of freedom, (sizes,).
        level: Confidence level, such as 0.95.
    """
    tail = 0.5 * (1.0 - level)
    quantiles = np.array([chi2.ppf(1.0 - tail, freedom), chi2.ppf(tail, freedom)])
    return deviation * np.sqrt(freedom / quantiles)
