"""Uncertainty of an estimate: formal, with robust loss, with correlated residuals."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.least_squares import Prior, Solution
from gyrostat.identification.loss import Loss, Quadratic
from gyrostat.identification.statistics import NORMAL_MAD, correlation_length, serial_meat

FEW = 30
"""Samples below which a record does not show a noise of its own."""


def residual_levels(parts: Sequence[Vector], parameters: int, loss: Loss) -> list[float]:
    """Level of the residuals of each record; under a robust loss that of all but the outliers.

    Args:
        parts: residuals of each record, all of one unit.
        parameters: estimated from them.
        loss: that the estimate made small.
    """
    total = sum(len(part) for part in parts)
    share = max(1.0 - parameters / total, 1.0 / total)

    def level(own: Vector) -> float:
        if isinstance(loss, Quadratic):
            return float(np.sqrt(np.mean(own**2) / share))
        return NORMAL_MAD * float(np.median(np.abs(own)))

    everything = level(np.concatenate(parts))
    return [level(part) if len(part) >= FEW else everything for part in parts]


def _bread(solution: Solution, loss: Loss, prior: Prior) -> Matrix:
    """Inverse curvature of the cost, (n, n)."""
    rows = solution.jacobian
    curvature = rows.T @ (loss.curvature(solution.residual)[:, None] * rows) + prior.information()
    # parameters of unlike size leave no digits otherwise
    size = np.sqrt(np.maximum(np.diag(solution.triangle.T @ solution.triangle), 1e-300))
    return np.linalg.inv(curvature / np.outer(size, size)) / np.outer(size, size)


def covariance(solution: Solution, loss: Loss, prior: Prior) -> Matrix:
    """Covariance of an estimate under its loss, (n, n): formal if quadratic, sandwich otherwise."""
    if isinstance(loss, Quadratic):
        return solution.covariance()
    rows, residual = solution.jacobian, solution.residual
    score = loss.weight(residual) * residual
    bread = _bread(solution, loss, prior)
    return bread @ (rows.T @ (score[:, None] ** 2 * rows) + prior.information()) @ bread


def square_root(covariance: Matrix) -> Matrix:
    """A matrix, (n, n), whose product with its own transpose is a covariance, singular or not."""
    size = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    power, directions = np.linalg.eigh(covariance / np.outer(size, size))
    return size[:, None] * directions * np.sqrt(np.maximum(power, 0.0))


def widened(covariance: Matrix, sigma: Vector) -> Matrix:
    """Covariance with no standard deviation below a given one, its correlations kept, (n, n).

    Args:
        covariance: (n, n).
        sigma: (n,) smallest standard deviations.
    """
    own = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    factor = np.maximum(1.0, sigma / own)
    return covariance * np.outer(factor, factor)


def serial_sigma(
    solution: Solution, loss: Loss, prior: Prior, counts: Sequence[int], sigma: Vector
) -> Vector:
    """Standard deviations that allow for residuals correlated in time, (n,).

    Never below those for independent residuals: over a short series the correlation is itself a
    guess, and a parameter that few samples show would seem all but known.

    Args:
        solution: of the least-squares problem.
        loss: of its residuals.
        prior: of its parameters.
        counts: numbers of residuals in each stretch of time, in order.
        sigma: (n,) standard deviations for independent residuals.
    """
    rows, residual = solution.jacobian, solution.residual
    bread = _bread(solution, loss, prior)
    scores = (loss.weight(residual) * residual)[:, None] * rows
    meat = prior.information()
    for first, last in pairwise(np.cumsum([0, *counts]).tolist()):
        meat = meat + serial_meat(scores[first:last], correlation_length(residual[first:last]))
    return np.maximum(sigma, np.sqrt(np.maximum(np.diag(bread @ meat @ bread), 0.0)))
