"""Correlation of the predicted parameters of a further record."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.pool.posterior import Posterior, mean_rows

RECORDS_OF_PRIOR = 10.0
"""Number of records whose weight the prior of no correlation has."""


def predicted_correlation(
    posteriors: Sequence[Posterior],
    covariances: Sequence[Matrix],
    shared: Matrix,
    temperature: float,
    date: float,
) -> Matrix:
    """Correlation of the predicted parameters, (p, p).

    The errors of a record are correlated, and so are the means over records therefore. The
    correlation of the scatter between records is that of the residuals, without the errors of the
    fits, shrunk towards zero as few records do not show it. All at the most likely point of each
    posterior.

    Args:
        posteriors: Posterior of each parameter.
        covariances: Covariance of the errors of each record, relative to the sizes, (p, p).
        shared: Errors of the predictions that all records share, (p, tolerances), relative to the
            sizes.
        temperature: Temperature of the prediction, °C.
        date: Date of the prediction, years.
    """
    points = [_at_typical_point(each, temperature, date) for each in posteriors]
    influence, scatter, ahead, residual = (np.array(part) for part in zip(*points, strict=True))
    errors = np.array(covariances)
    scatters = np.einsum("ik,jk->kij", scatter, scatter)
    excess = np.einsum("ik,jk->kij", residual, residual) - errors
    moments = np.mean(excess / scatters, axis=0)
    count = residual.shape[1]
    mutual = np.clip(moments, -1.0, 1.0) * count / (count + RECORDS_OF_PRIOR)
    np.fill_diagonal(mutual, 1.0)
    mutual = nearest_correlation(mutual)
    means = np.einsum("ik,jk,kij->ij", influence, influence, errors + mutual * scatters)
    total = means + mutual * np.outer(ahead, ahead) + shared @ shared.T
    variances = [each.prediction(temperature, date).sigma ** 2 for each in posteriors]
    sigma = np.sqrt(np.maximum(np.diag(total), variances + np.sum(shared**2, axis=1)))
    correlation = total / np.outer(sigma, sigma)
    np.fill_diagonal(correlation, 1.0)
    return nearest_correlation(correlation)


def _at_typical_point(
    posterior: Posterior, temperature: float, date: float
) -> tuple[Vector, Vector, float, Vector]:
    """Influence, scatters and residuals at the most likely point of the grid.

    Returns:
        Influence of each estimate on the predicted mean, (n,); scatter of each record, (n,), and of
        the prediction; residuals, (n,).
    """
    estimates = posterior.estimates
    branch = max(posterior.branches, key=lambda each: each.log_weight.max())
    place = int(np.argmax(branch.log_weight))
    rows, factor = mean_rows(
        branch.law,
        branch.shape[[place]],
        np.append(estimates.temperature, temperature),
        np.append(estimates.date, date),
        has_trend=estimates.trend is not None,
    )
    scatter = branch.scatter[place] * factor[0]
    weight = 1.0 / (estimates.errors**2 + scatter[:-1] ** 2)
    influence = rows[0, -1] @ branch.covariance[place] @ (rows[0, :-1] * weight[:, None]).T
    residual = estimates.values - rows[0, :-1] @ branch.beta[place]
    return influence, scatter[:-1], float(scatter[-1]), residual


def nearest_correlation(matrix: Matrix) -> Matrix:
    """Correlation with eigenvalues above zero, near a matrix that may have others."""
    values, axes = np.linalg.eigh(0.5 * (matrix + matrix.T))
    positive = axes @ (np.maximum(values, 1e-6)[:, None] * axes.T)
    sigma = np.sqrt(np.diag(positive))
    result = positive / np.outer(sigma, sigma)
    np.fill_diagonal(result, 1.0)
    return result
