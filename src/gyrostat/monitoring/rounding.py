"""Errors of a rounded motor current, and what they do to the estimate of a window.

The error of rounding a current y to steps q is a sawtooth of y, the sum over h of
q / (π h) sin(2 π h y / q + phase). Noise of standard deviation d before rounding leaves
exp(-2 π² h² d² / q²) of each term: none to speak of for d above q / 2 (Widrow and Kollár,
Quantization Noise, 2008, ch. 4). Where little noise is there, blocks with the same current have the
same error. It is then no noise: slews between two speeds turn it into viscous friction. The phase
is that of a current which is less well known than a step, hence uniform. Slow friction noise makes
the current wander through the steps, which also leaves less of a term; that part of the error
is in the noise that the estimate finds.
"""

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.estimate import all_columns, moments_of, with_mean
from gyrostat.monitoring.moments import COULOMB, MOTOR, VISCOUS, Prior, coefficients
from gyrostat.monitoring.noise import gram, window_variance
from gyrostat.monitoring.regression import Estimate, Rows

HARMONICS = 8
"""Terms of the sawtooth: they contain 93 % of its variance."""
NOTHING = 1e-3
"""Sum of squares of an error over the variance of the noise of a block, below which it is left out:
it moves no parameter by more than 0.03 sigma."""


def rounding_errors(
    blocks: Blocks, wheel: int, rows: Rows, prior: Prior, value: Estimate, *, step: float
) -> Matrix:
    """Independent errors of the response by its rounding, of variance 1 each, (N, M), A.

    Args:
        blocks: Blocks of the window.
        wheel: Place of the wheel.
        rows: Their rows.
        prior: What is known of the wheel beforehand.
        value: Estimate of the window.
        step: Resolution of the current, A; 0 if it shows none.
    """
    none = np.zeros((rows.time.size, 0))
    if step <= 0.0:
        return none
    dither = np.maximum(blocks.scatter[:, wheel] ** 2 - step**2 / 12.0, 0.0)
    order = np.arange(1.0, HARMONICS + 1.0)

    def left(variance: Vector) -> Matrix:
        decay = np.exp(-4.0 * np.pi**2 * order**2 * variance[:, None] / step**2)
        return step**2 / (2.0 * np.pi**2 * order**2) * decay

    # the noise that was found contains what rounding adds, of a few levels up to a quarter step²
    varies = 1.0 - window_variance(rows.start, rows.end, np.exp(value.noise.log_time))
    wander = varies * (value.noise_sigma / value.value[MOTOR]) ** 2
    wander = max(wander - 3.0 * float(np.mean(np.sum(left(dither), axis=1))), 0.0)
    size = np.sqrt(left(dither + wander))
    size = size[:, np.sum(size**2, axis=0) > NOTHING * value.white_sigma**2]
    if not size.shape[1]:
        return none
    levels = _levels(rows, prior, value, step)
    turns = 2.0 * np.pi / step * order[: size.shape[1], None] * levels[:, None, None, :]
    both = np.concatenate([np.cos(turns), np.sin(turns)]) / np.sqrt(len(levels))
    return (both * size.T).reshape(-1, rows.time.size).T


def _levels(rows: Rows, prior: Prior, value: Estimate, step: float) -> Matrix:
    """Currents of the blocks that are equally likely, (4, N), A.

    The coefficients found are themselves wrong by the rounding: where all currents round to one
    value, the viscous friction found is 0. Their means, weighted with what is known beforehand, and
    points of the rule of degree 3 (Stroud, Approximate Calculation of Multiple Integrals, 1971)
    about them for the errors of motor constant and viscous friction.
    """
    known, slope = coefficients(prior.mean)
    precision = prior.precision / np.diagonal(slope) ** 2
    found = 12.0 * np.ptp(rows.regressors, axis=0) ** 2 / step**2
    both = np.maximum(precision + found, 1e-300)
    level = rows.regressors @ (known + found / both * (value.beta - known))
    places = [MOTOR, VISCOUS]
    off = np.sqrt(2.0 / both[places])[:, None] * rows.regressors[:, places].T
    return np.concatenate([level + off, level - off])


def widened(rows: Rows, value: Estimate, errors: Matrix) -> Estimate:
    """Estimate whose covariances contain those that errors of the response cause.

    Args:
        rows: Rows of the window.
        value: Estimate from them.
        errors: Independent errors of variance 1 each, (N, M), A.
    """
    if not errors.shape[1]:
        return value
    size = value.value.size
    columns = np.column_stack([all_columns(rows), with_mean(rows, value.noise), errors])
    mean = columns.shape[1] - errors.shape[1] - 1
    products = gram(columns, rows.time, rows.white, [value.noise])[0][0]
    moments = moments_of(products, size)
    _, slope = coefficients(value.value)
    passed = products[size : 2 * size, mean + 1 :]
    scale = value.white_sigma**2
    moved = value.covariance @ slope.T @ moments.projection @ passed / scale
    # the mean follows the parameters, and what they leave of the response
    motor, weighted = value.value[MOTOR], products[mean, :size]
    mean_moved = motor * (products[mean, mean + 1 :] - weighted @ slope @ moved) + moved[COULOMB]
    mean_moved += (value.mean - value.value[COULOMB]) / motor * moved[MOTOR]
    return value.with_errors(moved, mean_moved)
