"""What estimates of the wheels tell about the lot: draws of its location, scale and shape.

Normal lots: confidence distribution by pivotal quantities. The weighted sum of squares Q(tau) about
the weighted mean is chi-square with n - 1 degrees of freedom at the true spread tau between the
wheels (W. Viechtbauer, 2007, Statistics in Medicine 26), and the weighted mean is normal. Without
errors of the estimates, the tolerance limits from these draws are the classical ones, which are
exact.

Log-normal lots and lots of unknown shape: Bayesian posterior, by importance sampling. The prior is
flat in the location (log-normal: its logarithm), in the logarithm of the scale where it is larger
than the errors, and falls with the square of the scale where it is smaller. An unknown shape is
standard normal, cut at `LARGEST_SHAPE`; the deviation of a logarithm has the same limit. For this
prior the confidence of the limits was measured (`benchmarks/lot.py`).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import chdtri, ndtri

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.lot.likelihood import log_likelihood

SHAPES = ("unknown", "normal", "log-normal")
LARGEST_SHAPE = 1.2
"""Shape of a log-normal lot whose standard deviation is 1.8 times its mean."""
DRAWS = 4096
FREEDOM = 5
"""Degrees of freedom of the t distribution that proposes draws."""
WIDER = 1.2
"""Scale of the proposals over that of the posterior at its maximum."""
STEP = 0.05
"""Step of second differences."""
GRID = 600
"""Number of spreads at which Q is computed."""


@dataclass(frozen=True)
class LotDraws:
    """Weighted draws of a lot, (k,) each; see `gyrostat.core.skewed_normal`.

    Attributes:
        location: Median of the lot, SI.
        scale: Scale, SI.
        shape: Shape.
        weight: Weights, whose sum is 1.
    """

    location: Vector
    scale: Vector
    shape: Vector
    weight: Vector

    @property
    def lots(self) -> Matrix:
        """Location, scale and shape, (k, 3)."""
        return np.column_stack([self.location, self.scale, self.shape])

    @property
    def effective(self) -> float:
        """Number of equally weighted draws that would be as good."""
        return float(1.0 / np.sum(self.weight**2))

    def quantiles(self, values: Vector) -> Callable[[float], float]:
        """Quantile function of a function of the draws, of which `values`, (k,), are the values."""
        order = np.argsort(values, kind="stable")
        weight, ordered = self.weight[order], values[order]
        level = np.cumsum(weight) - 0.5 * weight
        return lambda share: float(np.interp(share, level, ordered))

    def quantile(self, values: Vector, share: float) -> float:
        """Quantile of a function of the draws; see `quantiles`."""
        return self.quantiles(values)(share)

    def typical(self) -> tuple[float, float, float]:
        """Medians of location, scale and shape."""
        location, scale, shape = (self.quantile(column, 0.5) for column in self.lots.T)
        return location, scale, shape


def even_points(count: int, dimension: int) -> Matrix:
    """Evenly distributed points of the unit cube, (count, dimension).

    Multiples of powers of the generalised golden ratio, modulo 1 (a Kronecker sequence).
    """
    ratio = 2.0
    for _ in range(60):
        ratio = (1.0 + ratio) ** (1.0 / (dimension + 1))
    steps = ratio ** -np.arange(1.0, dimension + 1.0)
    return np.modf(0.5 + np.outer(np.arange(1, count + 1), steps))[0]


def lot_draws(values: Vector, errors: Vector, shape: str, count: int = DRAWS) -> LotDraws:
    """Draws of a lot.

    Args:
        values: Estimates of n wheels, (n,); the median is not 0 if the lot is log-normal.
        errors: Standard deviations of their errors, (n,), above 0.
        shape: One of `SHAPES`.
        count: Number of draws.
    """
    draw = {"unknown": _skewed, "normal": _normal, "log-normal": _log_normal}[shape]
    return draw(values, errors, count)


def _normal(values: Vector, errors: Vector, count: int) -> LotDraws:
    """Draws of a normal lot."""
    variances = float(np.var(values, ddof=1)) * np.geomspace(1e-9, 1e4, GRID)
    weight = 1.0 / (variances[:, None] + errors**2)
    total = weight.sum(axis=1)
    means = (weight @ values) / total
    squares = np.sum(weight * (values - means[:, None]) ** 2, axis=1)
    first, second = even_points(count, 2).T
    level, variable = np.log(chdtri(len(values) - 1, first)), np.log(variances)
    # where Q is too small at every spread, the draw is a lot of equal wheels
    variance = np.interp(level, np.log(squares[::-1]), variable[::-1])
    sigma = np.exp(-0.5 * np.interp(variance, variable, np.log(total)))
    location = np.interp(variance, variable, means) + sigma * ndtri(second)
    return LotDraws(location, np.exp(0.5 * variance), np.zeros(count), np.full(count, 1.0 / count))


def _skewed(values: Vector, errors: Vector, count: int) -> LotDraws:
    """Draws of a lot of unknown shape, from location, logarithm of the scale, and shape."""
    middle, unit = float(np.median(values)), float(np.std(values, ddof=1))
    scaled = errors / unit
    likelihood = log_likelihood((values - middle) / unit, scaled)
    error = _typical(scaled)

    def log_posterior(points: Matrix) -> Vector:
        location, scale, shape = points[:, 0], np.exp(points[:, 1]), points[:, 2]
        inside = np.abs(shape) < LARGEST_SHAPE
        lots = np.column_stack([location, scale, np.where(inside, shape, 0.0)])
        density = likelihood(lots).sum(axis=1) + _scale_prior(scale, error) - 0.5 * shape**2
        return np.where(inside, density, -np.inf)

    start = np.array([0.0, _log_spread(scaled), 0.0])
    points, weight = _sample(log_posterior, start, count)
    location, scale = middle + unit * points[:, 0], unit * np.exp(points[:, 1])
    return LotDraws(location, scale, points[:, 2], weight)


def _log_normal(values: Vector, errors: Vector, count: int) -> LotDraws:
    """Draws of a log-normal lot, from mean and logarithm of the deviation of its logarithm."""
    unit = float(np.median(values))
    scaled, relative = values / unit, errors / abs(unit)
    likelihood = log_likelihood(scaled, relative)
    error, spread = _typical(relative), float(np.std(scaled, ddof=1))

    def log_posterior(points: Matrix) -> Vector:
        location, shape = np.exp(spread * points[:, 0]), np.exp(points[:, 1])
        inside = shape < LARGEST_SHAPE
        shape = np.where(inside, shape, LARGEST_SHAPE)
        density = likelihood(np.column_stack([location, location * shape, shape])).sum(axis=1)
        return np.where(inside, density + _scale_prior(shape, error), -np.inf)

    start = np.array([0.0, np.log(min(spread, 1.0)) + _log_spread(relative / spread)])
    points, weight = _sample(log_posterior, start, count)
    location, shape = unit * np.exp(spread * points[:, 0]), np.exp(points[:, 1])
    return LotDraws(location, np.abs(location) * shape, np.sign(unit) * shape, weight)


def _typical(errors: Vector) -> float:
    return float(np.exp(np.mean(np.log(errors))))


def _log_spread(errors: Vector) -> float:
    """Logarithm of the spread of wheels whose estimates have a spread of 1."""
    return float(0.5 * np.log(max(1.0 - float(np.mean(errors**2)), 0.05)))


def _scale_prior(scale: Vector, error: float) -> Vector:
    """Logarithm of the prior density of the logarithm of the scale."""
    return -np.log1p((error / scale) ** 2)


def _sample(
    log_posterior: Callable[[Matrix], Vector], start: Vector, count: int
) -> tuple[Matrix, Vector]:
    """Importance sampling with Student's t distribution about the maximum of the density.

    Args:
        log_posterior: Logarithm of the density at k points, (k, d) -> (k,).
        start: Point near the maximum, (d,); a quarter is a short way from it.
        count: Number of draws.

    Returns:
        Draws, (count, d), and their weights, whose sum is 1.
    """
    size = len(start)
    corners = start + np.vstack([np.zeros(size), 0.25 * np.eye(size)])
    mode = minimize(
        lambda point: -float(log_posterior(point[None])[0]),
        start,
        method="Nelder-Mead",
        options={"initial_simplex": corners, "xatol": 1e-3, "fatol": 1e-3},
    ).x
    points = even_points(count, size + 1)
    # normal numbers over the root of a mean square are Student's
    ratio = np.sqrt(FREEDOM / chdtri(FREEDOM, points[:, size]))
    steps = ndtri(points[:, :size]) * ratio[:, None]
    draws = mode + WIDER * steps @ _root_at(log_posterior, mode).T
    square = np.sum(steps**2, axis=1)
    excess = log_posterior(draws) + 0.5 * (FREEDOM + size) * np.log1p(square / FREEDOM)
    weight = np.exp(excess - excess.max())
    return draws, weight / weight.sum()


def _root_at(function: Callable[[Matrix], Vector], mode: Vector) -> Matrix:
    """Matrix from standard normal numbers to deviations, (d, d), by second differences."""
    size = len(mode)
    steps = STEP * np.eye(size)
    corners = [
        mode + first * steps[i] + second * steps[j]
        for i in range(size)
        for j in range(size)
        for first, second in ((1, 1), (1, -1), (-1, 1), (-1, -1))
    ]
    heights = function(np.array(corners))
    # beyond the largest shape the density is zero
    heights = np.maximum(heights, heights.max() - 10.0).reshape(size, size, 4)
    curvature, axes = np.linalg.eigh(-(heights @ [1.0, -1.0, -1.0, 1.0]) / (4.0 * STEP**2))
    # at most a deviation of 1 in a direction that the estimates do not determine
    return axes / np.sqrt(np.maximum(curvature, 1.0))
