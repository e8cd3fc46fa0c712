"""Uncertainty of an estimate: formal, with robust loss, with correlated residuals."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.least_squares import Prior, Solution
from gyrostat.identification.fit.loss import Loss, Quadratic
from gyrostat.identification.read.statistics import correlation_length, serial_meat
from gyrostat.telemetry.signals import NORMAL_MAD

FEW = 30
"""Smallest number of samples from which the noise of a single record is estimated."""


def residual_levels(parts: Sequence[Vector], parameters: int, loss: Loss) -> list[float]:
    """Level of the residuals of each record; with a robust loss, without outliers.

    Args:
        parts: Residuals of each record, all in one unit.
        parameters: Number of parameters estimated from them.
        loss: Loss that the estimate minimises.
    """
    total = sum(len(part) for part in parts)
    share = max(1.0 - parameters / total, 1.0 / total)

    def level(residual: Vector) -> float:
        if isinstance(loss, Quadratic):
            return float(np.sqrt(np.mean(residual**2) / share))
        return NORMAL_MAD * float(np.median(np.abs(residual)))

    common_level = level(np.concatenate(parts))
    return [level(part) if len(part) >= FEW else common_level for part in parts]


def _bread(solution: Solution, loss: Loss, prior: Prior) -> Matrix:
    """Inverse curvature of the cost, (n, n)."""
    rows = solution.jacobian
    curvature = rows.T @ (loss.curvature(solution.residual)[:, None] * rows) + prior.information()
    # normalise: otherwise different sizes of the parameters cause rounding errors
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
    """Square root, (n, n), of a covariance: root times its transpose; may be singular."""
    size = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    power, directions = np.linalg.eigh(covariance / np.outer(size, size))
    return size[:, None] * directions * np.sqrt(np.maximum(power, 0.0))


def widened(covariance: Matrix, sigma: Vector) -> Matrix:
    """Covariance with a lower bound on the standard deviations and its correlations kept, (n, n).

    Args:
        covariance: Covariance, (n, n).
        sigma: Smallest standard deviations, (n,).
    """
    deviation = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    factor = np.maximum(1.0, sigma / deviation)
    return covariance * np.outer(factor, factor)


def serial_sigma(solution: Solution, counts: Sequence[int], sigma: Vector) -> Vector:
    """Standard deviations with residuals correlated in time, (n,), without a-priori knowledge.

    They are never below those for independent residuals. Over a short series the correlation itself
    is uncertain, and a parameter that few samples show would otherwise seem almost exact.

    Args:
        solution: Solution of the least-squares problem with quadratic loss.
        counts: Number of residuals in each segment of time, in order.
        sigma: Standard deviations for independent residuals, (n,).
    """
    rows, residual = solution.jacobian, solution.residual
    bread = _bread(solution, Quadratic(), Prior.unknown(len(sigma)))
    scores = residual[:, None] * rows
    meat = np.zeros_like(bread)
    for first, last in pairwise(np.cumsum([0, *counts]).tolist()):
        meat += serial_meat(scores[first:last], correlation_length(residual[first:last]))
    return np.maximum(sigma, np.sqrt(np.maximum(np.diag(bread @ meat @ bread), 0.0)))
