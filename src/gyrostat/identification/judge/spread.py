"""Statistics of several estimates of one parameter with correlated errors.

Estimates y = m + u + e: errors e with a known covariance, and a spread u between the wheels with an
unknown variance (random-effects model).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtrc, chdtri, ndtr, stdtr  # scipy.stats takes long to import

from gyrostat.core.types import Matrix, Vector


def two_sided(z: float) -> float:
    """Probability of a normal deviate of at least this size."""
    return float(2.0 * ndtr(-abs(z)))


def holm(chances: Sequence[float]) -> Vector:
    """P-values adjusted for the number of tests.

    With significance at an adjusted value of 5 %, the probability of any false alarm in all tests
    is at most 5 %, whatever their correlation (Holm 1979, Scandinavian Journal of Statistics 6).

    Args:
        chances: P-values of n tests.

    Returns:
        Adjusted p-values, (n,).
    """
    order = np.argsort(chances)
    scaled = np.asarray(chances, dtype=float)[order] * np.arange(len(order), 0, -1)
    adjusted = np.empty(len(order))
    adjusted[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return adjusted


@dataclass(frozen=True)
class Line:
    """Straight line through estimates over time, by generalised least squares.

    Attributes:
        start: Value at time zero, SI.
        slope: Change per unit of time, SI.
        covariance: Covariance of start and slope, (2, 2), enlarged if the estimates scatter about
            the line by more than their errors.
        chance: P-value of a slope of zero.
    """

    start: float
    slope: float
    covariance: Matrix
    chance: float


def line(time: Vector, values: Vector, covariance: Matrix) -> Line:
    """Fit a straight line to estimates with correlated errors.

    Scatter beyond the errors enlarges the covariance (Birge ratio), but not that of the error which
    all estimates share: it moves the whole line and does not scatter. The p-value is the larger of
    the normal one and that of Student's t with the scatter.

    Args:
        time: Times, (n,), at least two different ones.
        values: Estimates, (n,).
        covariance: Covariance of their errors, (n, n).
    """
    rows = np.column_stack([np.ones(len(time)), time])
    weight = np.linalg.inv(covariance)
    spread = np.linalg.inv(rows.T @ weight @ rows)
    theta = spread @ rows.T @ weight @ values
    residual, freedom = values - rows @ theta, len(time) - 2
    chance = two_sided(theta[1] / np.sqrt(spread[1, 1]))
    if freedom > 0:
        excess = float(residual @ weight @ residual) / freedom
        if excess > 1.0:
            common = max(0.0, float(covariance[~np.eye(len(time), dtype=bool)].min()))
            spread = excess * spread - (excess - 1.0) * np.diag([common, 0.0])
            t = abs(theta[1]) / np.sqrt(spread[1, 1])
            chance = max(chance, float(2.0 * stdtr(freedom, -t)))
    return Line(float(theta[0]), float(theta[1]), np.asarray(spread, dtype=np.float64), chance)


@dataclass(frozen=True)
class Spread:
    """Spread of a parameter between wheels.

    Attributes:
        mean: Mean of the batch, SI.
        mean_sigma: Standard deviation of the mean, SI, including the spread.
        spread: Standard deviation between wheels, SI, beyond the errors of the estimates.
        low: Lower end of its 95 % confidence interval, SI.
        high: Upper end, SI.
        chance: P-value of equal wheels.
    """

    mean: float
    mean_sigma: float
    spread: float
    low: float
    high: float
    chance: float


def _mean(values: Vector, covariance: Matrix, variance: float) -> tuple[float, float, float]:
    """Weighted mean, its variance, and the weighted sum of squares about it."""
    weight = np.linalg.inv(covariance + variance * np.eye(len(values)))
    total = float(weight.sum())
    mean = float(weight.sum(axis=0) @ values) / total
    residual = values - mean
    return mean, 1.0 / total, float(residual @ weight @ residual)


def between(values: Vector, covariance: Matrix) -> Spread:
    """Spread between wheels beyond the errors of their estimates.

    The estimate solves Q = n - 1 for the weighted sum of squares Q (Paule and Mandel 1982); the
    interval solves Q = quantiles of chi-square (Viechtbauer 2007, Statistics in Medicine 26).

    Args:
        values: Estimates of n >= 2 wheels, (n,).
        covariance: Covariance of their errors, (n, n).
    """
    freedom = len(values) - 1
    upper = float(np.var(values, ddof=1) + np.trace(covariance)) or 1.0

    def variance_at(level: float) -> float:
        """Variance between wheels at which Q has this value; zero if Q is never so large."""

        def excess(variance: float) -> float:
            return _mean(values, covariance, variance)[2] - level

        if excess(0.0) <= 0.0:
            return 0.0
        top = upper
        while excess(top) > 0.0:
            top *= 10.0
        root: Any = brentq(excess, 0.0, top, xtol=1e-14 * upper)
        return float(root)

    ends = [variance_at(float(chdtri(freedom, p))) for p in (0.025, 0.975)]
    variance = variance_at(float(freedom))
    mean, mean_variance, _ = _mean(values, covariance, variance)
    chance = float(chdtrc(freedom, _mean(values, covariance, 0.0)[2]))
    low, middle, high = np.sqrt([ends[0], variance, ends[1]]).tolist()
    return Spread(mean, float(np.sqrt(mean_variance)), middle, low, high, chance)


def from_others(values: Vector, covariance: Matrix, place: int) -> tuple[float, float, float]:
    """Difference of one estimate from the mean of the others.

    Args:
        values: Estimates of n >= 3 wheels, (n,).
        covariance: Covariance of their errors, (n, n).
        place: Index of the wheel.

    Returns:
        Difference, its standard deviation including the spread between the others, and the p-value
        of a wheel like the others (Student's t with n - 2 degrees of freedom).
    """
    others = np.delete(np.arange(len(values)), place)
    covariance_of_others = covariance[np.ix_(others, others)]
    spread = between(values[others], covariance_of_others).spread ** 2
    weight = np.linalg.inv(covariance_of_others + spread * np.eye(len(others))).sum(axis=0)
    contrast = np.zeros(len(values))
    contrast[others] = -weight / weight.sum()
    contrast[place] = 1.0
    total = covariance + spread * np.eye(len(values))
    difference, sigma = float(contrast @ values), float(np.sqrt(contrast @ total @ contrast))
    return difference, sigma, float(2.0 * stdtr(len(values) - 2, -abs(difference) / sigma))
