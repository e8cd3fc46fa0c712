"""Most likely slow noise of a residual: Newton steps on the restricted likelihood."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.noise import Noise, gram

USUAL = Noise(float(np.log(30.0)), float(np.log(1200.0)))
"""Noise that the search of a first window starts from, and the mean of its prior."""
LEAST = np.array([-5.0, np.log(60.0)])
"""Least log ratio and log time."""
MOST = np.array([16.0, np.log(20000.0)])
"""Largest log ratio and log time."""
_SPREAD = np.array([3.0, 1.0])
"""Standard deviations of what is known of log ratio and log time beforehand."""
_STEP = np.array([0.5, 0.4])
"""Steps of the difference quotients."""
_FLATTEST = 0.1
"""Least curvature of the log density that is believed."""


def log_prior(noise: Noise) -> float:
    """Log density of the noise beforehand, without its constant."""
    away = (_place(noise) - _place(USUAL)) / _SPREAD
    return float(-0.5 * away @ away)


def find_noise(
    residual: Vector, speed: Matrix, time: Vector, white: Vector, noise: Noise
) -> tuple[Vector, Matrix]:
    """Find the most likely noise of a residual.

    Args:
        residual: Residual of the balance, (N,).
        speed: Columns of the friction that depends on the speed, (N, K). Together with a constant
            they are taken out of the residual, so that what they have already explained of the
            noise does not make it too small.
        time: Times of the blocks, (N,), s.
        white: Variances of the white noise over the scale, (N,).
        noise: Start of the search.

    Returns:
        Log ratio and log time, (2,), and minus the second derivatives of the log density, (2, 2).
    """
    columns = np.column_stack([np.ones(residual.size), speed, residual])
    curvature = np.diag(1.0 / _SPREAD**2)
    around = _STEP * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1]])
    place = _place(noise)
    for _ in range(6):
        place = np.clip(place, LEAST + _STEP, MOST - _STEP)
        trials = [Noise(float(a), float(b)) for a, b in place + around]
        density = _log_densities(columns, time, white, trials)
        middle, up, down, right, left, corner = density + [log_prior(each) for each in trials]
        gradient = 0.5 * np.array([up - down, right - left]) / _STEP
        cross = (corner - up - right + middle) / _STEP.prod()
        first = (up - 2.0 * middle + down) / _STEP[0] ** 2
        second = (right - 2.0 * middle + left) / _STEP[1] ** 2
        values, vectors = np.linalg.eigh(-np.array([[first, cross], [cross, second]]))
        values = np.maximum(values, _FLATTEST)
        curvature = (vectors * values) @ vectors.T
        step = np.clip((vectors / values) @ (vectors.T @ gradient), -1.5, 1.5)
        place = place + step
        if np.all(np.abs(step) < _STEP):
            break
    return np.clip(place, LEAST, MOST), curvature


def nodes(centre: Vector, curvature: Matrix) -> list[Noise]:
    """Centre and four points of the rule of degree 3 for a Gaussian in the plane.

    Args:
        centre: Log ratio and log time, (2,).
        curvature: Inverse covariance, (2, 2).
    """
    values, vectors = np.linalg.eigh(curvature)
    arms = vectors * np.sqrt(3.0 / values)
    away = [np.zeros(2), arms[:, 0], -arms[:, 0], arms[:, 1], -arms[:, 1]]
    places = np.clip(centre + away, LEAST, MOST)
    return [Noise(float(ratio), float(time)) for ratio, time in places]


def _place(noise: Noise) -> Vector:
    return np.array([noise.log_ratio, noise.log_time])


def _log_densities(columns: Matrix, time: Vector, white: Vector, noises: Sequence[Noise]) -> Vector:
    """Restricted log likelihoods with the scale profiled out; the residual is the last column."""
    products, log_det = gram(columns, time, white, noises)
    count = columns.shape[1] - 1
    size = np.sqrt(np.diagonal(products, axis1=-2, axis2=-1)[:, :-1])
    taken = products[:, :-1, :-1] / (size[:, :, None] * size[:, None]) + 1e-9 * np.eye(count)
    mixed = (products[:, :-1, -1] / size)[:, :, None]
    explained = np.sum(mixed * np.linalg.solve(taken, mixed), axis=(1, 2))
    squares = np.maximum(products[:, -1, -1] - explained, 1e-300)
    log_taken = np.linalg.slogdet(taken).logabsdet + 2.0 * np.sum(np.log(size), axis=1)
    freedom = time.size - count
    return -0.5 * (log_det + log_taken + freedom * np.log(squares))
