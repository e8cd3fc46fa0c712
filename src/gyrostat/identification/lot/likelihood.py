"""Probability of estimates of wheels whose lot is a skewed normal distribution.

An estimate is y = x + e with the true parameter x of `gyrostat.core.skewed_normal` and a normal
error e of known standard deviation.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr  # scipy.stats takes long to import

from gyrostat.core.skewed_normal import score_of, usable_shape
from gyrostat.core.types import Matrix, Vector

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(7)
LOG_WEIGHTS = np.log(WEIGHTS) + 0.5 * NODES**2
SCORES = np.linspace(-8.0, 8.0, 201)
"""Standard normal numbers of integrals over an error."""
SHARES = np.exp(-0.5 * SCORES**2) / np.exp(-0.5 * SCORES**2).sum()
NEWTON_STEPS = 4
AT_ONCE = 20_000
"""Pairs of parameters and estimates that are computed at once, which bounds the memory."""


def share_below(
    value: ArrayLike, error: ArrayLike, location: ArrayLike, scale: ArrayLike, shape: ArrayLike
) -> Matrix:
    """Probability of a smaller estimate; the arguments are broadcast.

    Args:
        value: Estimate.
        error: Standard deviation of its error; zero for the parameter itself.
        location: Location of the lot.
        scale: Scale of the lot.
        shape: Shape of the lot.
    """
    parts = (np.asarray(part, dtype=float)[..., None] for part in (location, scale, shape))
    errors = np.asarray(error, dtype=float)[..., None] * SCORES
    return ndtr(score_of(np.asarray(value)[..., None] - errors, *parts)) @ SHARES


def log_likelihood(values: Vector, errors: Vector) -> Callable[[Matrix], Matrix]:
    """Logarithm of the density of each estimate, as a function of the lot.

    The integral over the parameter is by Gauss-Hermite quadrature about the largest integrand
    (J. C. Pinheiro and D. M. Bates, 1995, J. Comput. Graph. Stat. 4).

    Args:
        values: Estimates, (n,).
        errors: Standard deviations of their errors, (n,), above 0.

    Returns:
        Function of location, scale and shape of k lots, (k, 3), with the result (k, n).
    """

    def of_lots(lots: Matrix) -> Matrix:
        step = max(1, AT_ONCE // len(values))
        parts = [
            _log_density(values, errors, lots[k : k + step]) for k in range(0, len(lots), step)
        ]
        return np.concatenate(parts)

    return of_lots


def _log_density(values: Vector, errors: Vector, lots: Matrix) -> Matrix:
    location, scale, shape = (column[:, None] for column in lots.T)
    g = usable_shape(shape)
    distance, error = (values - location) / scale, errors / scale
    # start from the parameter shrunk to the location, then Gauss-Newton steps
    score = np.log(np.maximum(1.0 + g * distance / (1.0 + error**2), 0.05)) / g
    for _ in range(NEWTON_STEPS):
        slope = np.exp(np.clip(g * score, -30.0, 30.0))
        step = (distance - (slope - 1.0) / g) * slope - error**2 * score
        score = np.clip(score + step / (error**2 + slope**2), -9.0, 9.0)
    width = error / np.sqrt(error**2 + np.exp(2.0 * g * score))
    exponents = np.empty((len(NODES), *score.shape))
    for k, (node, weight) in enumerate(zip(NODES, LOG_WEIGHTS, strict=True)):
        near = score + width * node
        residual = (distance - np.expm1(g * near) / g) / error
        exponents[k] = weight - 0.5 * (near**2 + residual**2)
    largest = exponents.max(axis=0)
    total = np.exp(exponents - largest).sum(axis=0)
    return largest + np.log(total * width / errors) - np.log(2.0 * np.pi)
