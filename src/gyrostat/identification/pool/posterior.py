"""Posterior of one parameter over the records of a wheel, by quadrature.

Estimate k of a parameter is y_k = x_k beta + f_k u_k + e_k: the mean of a law over temperature and
date (`gyrostat.identification.pool.laws`), a scatter u_k ~ N(0, tau²) between records, and the
error of the fit e_k ~ N(0, s_k²), whose standard deviation is known. For given tau and shape of
the law, the coefficients beta are normal, with closed forms. Both others are integrated on a grid.

The prior is flat in the level. That of tau is 1 / (tau + s) with the geometric mean s of the
errors, and falls beyond the largest usual scatter. Without errors, law over temperature and trend,
the prediction of a further record is thus Student's t with n - 1 degrees of freedom. Jeffreys'
prior, tau / (tau² + s²), has no mass at 0: its intervals of 95 % held 98 to 99 % where the errors
are larger than the scatter.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.pool.laws import Law
from gyrostat.identification.pool.mixture import NEGLIGIBLE, Mixture, weighted_quantile

SCATTERS = 48
"""Number of scatters of the grid."""
SHAPES = 25
"""Number of shapes of the grid."""
SMALL, LARGE = 0.02, 10.0
"""Range of the scatters: share of the smallest error, and multiple of the largest usual scatter."""
FAR = 16.0
"""Logarithm of the density ratio beyond which shapes are left out."""


@dataclass(frozen=True)
class Estimates:
    """Estimates of one parameter from the records of a wheel, relative to its size.

    Attributes:
        values: Estimates, (n,).
        errors: Standard deviations of their errors, (n,).
        temperature: Temperatures, (n,), °C.
        date: Dates, (n,), years since a reference.
        laws: Equally likely laws over temperature.
        trend: Prior standard deviation of the trend, 1/year; None without one.
        usual: Largest usual scatter between records.
    """

    values: Vector
    errors: Vector
    temperature: Vector
    date: Vector
    laws: Sequence[Law]
    trend: float | None
    usual: float

    def without(self, k: int) -> "Estimates":
        """All but one estimate."""
        rest = [np.delete(v, k) for v in (self.values, self.errors, self.temperature, self.date)]
        return Estimates(*rest, laws=self.laws, trend=self.trend, usual=self.usual)


@dataclass(frozen=True)
class Branch:
    """Grid of one law.

    Attributes:
        law: Law.
        shape: Shape at each point, (g,).
        scatter: Scatter tau at each point, (g,).
        log_weight: Logarithm of the weight of each point, (g,).
        beta: Coefficients, (g, q): level, trend if there is one, columns of the law.
        covariance: Their covariances, (g, q, q).
    """

    law: Law
    shape: Vector
    scatter: Vector
    log_weight: Vector
    beta: Matrix
    covariance: Matrix


@dataclass(frozen=True)
class Posterior:
    """Posterior of one parameter.

    Attributes:
        estimates: Estimates.
        branches: Grid of each law.
    """

    estimates: Estimates
    branches: Sequence[Branch]

    @cached_property
    def weight(self) -> Vector:
        """Weights of all points, whose sum is 1, (all,)."""
        logs = np.concatenate([branch.log_weight for branch in self.branches])
        weight = np.exp(logs - logs.max())
        return weight / weight.sum()

    def scatter_quantile(self, share: float) -> float:
        """Quantile of the scatter between records."""
        scatter = np.concatenate([branch.scatter for branch in self.branches])
        levels, places = np.unique(scatter, return_inverse=True)
        return weighted_quantile(levels, np.bincount(places, self.weight).astype(float), share)

    def shape_quantile(self, share: float) -> float:
        """Quantile of the shape, for laws whose shapes have the same meaning."""
        shape = np.concatenate([branch.shape for branch in self.branches])
        levels, places = np.unique(shape, return_inverse=True)
        return weighted_quantile(levels, np.bincount(places, self.weight).astype(float), share)

    def coefficient(self, place: int) -> Mixture:
        """Distribution of a coefficient that all laws have."""
        means = [branch.beta[:, place] for branch in self.branches]
        variances = [branch.covariance[:, place, place] for branch in self.branches]
        return self._mixture(np.concatenate(means), np.concatenate(variances))

    def mean(self, temperature: float, date: float) -> Mixture:
        """Distribution of the mean over records."""
        return self._combination(self._rows_at(temperature, date))

    def prediction(self, temperature: float, date: float, error: float = 0.0) -> Mixture:
        """Distribution of the parameter in a further record.

        Args:
            temperature: Temperature, °C.
            date: Date, years.
            error: Standard deviation of the error of the estimate; 0 for the parameter itself.
        """
        means, variances, scatter = self._mean(temperature, date)
        return self._mixture(means, variances + scatter**2 + error**2)

    def of_record(self, k: int) -> Mixture:
        """Distribution of the parameter in record k, from its own estimate and all others."""
        given = self.estimates
        means, variances, scatter = self._mean(given.temperature[k], given.date[k])
        share = scatter**2 / (scatter**2 + given.errors[k] ** 2)
        pooled = means + share * (given.values[k] - means)
        return self._mixture(pooled, (1.0 - share) ** 2 * variances + share * given.errors[k] ** 2)

    def factor(self, temperature: float) -> float:
        """Mean of the law's factor at a temperature."""
        parts = [
            np.exp(branch.law.log_factor(branch.shape, np.array([temperature]))[:, 0])
            for branch in self.branches
        ]
        return float(self.weight @ np.concatenate(parts))

    def trend(self, temperature: float) -> Mixture:
        """Distribution of the change per year at a temperature."""
        later, now = (self._rows_at(temperature, date) for date in (1.0, 0.0))
        return self._combination([a - b for a, b in zip(later, now, strict=True)])

    def slope(self, temperature: float, date: float, step: float = 0.01) -> Mixture:
        """Distribution of the derivative of the mean with respect to temperature, 1/°C."""
        above, below = (self._rows_at(temperature + h, date) for h in (step, -step))
        return self._combination(
            [(a - b) / (2.0 * step) for a, b in zip(above, below, strict=True)]
        )

    @property
    def _has_trend(self) -> bool:
        return self.estimates.trend is not None

    def _rows_at(self, temperature: float, date: float) -> list[Matrix]:
        """Rows of the mean at a temperature and date, (g, q) of each law."""
        place = np.array([temperature]), np.array([date])
        return [
            mean_rows(branch.law, branch.shape, *place, has_trend=self._has_trend)[0][:, 0]
            for branch in self.branches
        ]

    def _combination(self, rows: Sequence[Matrix]) -> Mixture:
        """Distribution of a linear combination of the coefficients."""
        return self._mixture(*self._moments(rows))

    def _moments(self, rows: Sequence[Matrix]) -> tuple[Vector, Vector]:
        """Mean and variance of a combination of the coefficients at each point, (all,)."""
        pairs = list(zip(rows, self.branches, strict=True))
        means = [np.sum(row * branch.beta, axis=1) for row, branch in pairs]
        variances = [
            np.einsum("gq,gqr,gr->g", row, branch.covariance, row) for row, branch in pairs
        ]
        return np.concatenate(means), np.concatenate(variances)

    def _mean(self, temperature: float, date: float) -> tuple[Vector, Vector, Vector]:
        """Mean of the law, its variance, and the scatter at each point, (all,)."""
        scatter = [
            branch.scatter
            * np.exp(branch.law.log_factor(branch.shape, np.array([temperature]))[:, 0])
            for branch in self.branches
        ]
        return *self._moments(self._rows_at(temperature, date)), np.concatenate(scatter)

    def _mixture(self, means: Vector, variances: Vector) -> Mixture:
        used = self.weight > NEGLIGIBLE * self.weight.max()
        weight = self.weight[used] / self.weight[used].sum()
        return Mixture(weight, means[used], np.sqrt(np.maximum(variances[used], 1e-300)))


def posterior(estimates: Estimates) -> Posterior:
    """Posterior of one parameter."""
    return Posterior(estimates, [_branch(law, estimates) for law in estimates.laws])


def _branch(law: Law, estimates: Estimates) -> Branch:
    """Grid of one law, over the shapes and scatters that the estimates leave."""
    smallest = SMALL * float(estimates.errors.min())
    scatters = np.geomspace(smallest, LARGE * max(estimates.usual, smallest), SCATTERS)
    shapes = np.zeros(1) if law.bounds is None else np.linspace(*law.bounds, SHAPES)
    while True:
        branch = _on_grid(law, estimates, shapes, scatters)
        height = branch.log_weight.reshape(len(shapes), SCATTERS)
        near = height > height.max() - FAR
        closer = _closer(shapes, near.any(axis=1)), _closer(np.log(scatters), near.any(axis=0))
        if closer[0] is None and closer[1] is None:
            return branch
        shapes = shapes if closer[0] is None else closer[0]
        scatters = scatters if closer[1] is None else np.exp(closer[1])


def _closer(points: Vector, near: NDArray[np.bool_]) -> Vector | None:
    """Points over the range of the near ones only; None if these are half of them or more."""
    places = np.flatnonzero(near)
    first, last = max(places[0] - 1, 0), min(places[-1] + 1, len(points) - 1)
    if len(points) == 1 or last - first > len(points) // 2:
        return None
    return np.linspace(points[first], points[last], len(points))


def _on_grid(law: Law, estimates: Estimates, shapes: Vector, scatters: Vector) -> Branch:
    """Grid of one law at all pairs of shapes and scatters."""
    y, errors = estimates.values, estimates.errors
    has_trend = estimates.trend is not None
    rows, factor = mean_rows(
        law, shapes, estimates.temperature, estimates.date, has_trend=has_trend
    )
    variance = errors**2 + (scatters[:, None] * factor[:, None, :]) ** 2
    weight = 1.0 / variance
    sigmas = np.array([*((estimates.trend,) if has_trend else ()), *law.sigmas])
    precision = np.diag([0.0, *sigmas**-2.0])
    normal = np.einsum("snq,stn,snr->stqr", rows, weight, rows) + precision
    covariance = np.linalg.inv(normal)
    beta = np.einsum("stqr,snr,stn,n->stq", covariance, rows, weight, y, optimize=True)
    residual = y - np.einsum("snq,stq->stn", rows, beta)
    square = np.sum(weight * residual**2, axis=2) + np.sum(beta**2 * np.diag(precision), axis=2)
    height = -0.5 * (np.log(variance).sum(axis=2) + np.linalg.slogdet(normal)[1] + square)
    height -= np.log(sigmas).sum()
    typical = np.exp(np.mean(np.log(errors / factor), axis=1))
    height -= np.log1p(typical[:, None] / scatters)
    height -= np.log1p((scatters / estimates.usual) ** 2)
    height += law.log_prior(shapes)[:, None] + np.log(np.log(scatters[1] / scatters[0]))
    height += np.log(shapes[1] - shapes[0]) if len(shapes) > 1 else 0.0
    count = len(shapes) * len(scatters)
    return Branch(
        law,
        np.repeat(shapes, len(scatters)),
        np.tile(scatters, len(shapes)),
        height.reshape(count),
        beta.reshape(count, -1),
        covariance.reshape(count, *covariance.shape[2:]),
    )


def mean_rows(
    law: Law, shape: Vector, temperature: Vector, date: Vector, *, has_trend: bool
) -> tuple[Matrix, Matrix]:
    """Rows of the mean, (s, n, q), and factor of the law, (s, n)."""
    factor = np.exp(law.log_factor(shape, temperature))
    columns = np.broadcast_to(
        law.columns(temperature), (len(shape), len(temperature), len(law.sigmas))
    )
    level = [factor, factor * date] if has_trend else [factor]
    return np.concatenate([np.stack(level, axis=2), columns], axis=2), factor
