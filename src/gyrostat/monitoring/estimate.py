"""Parameters of one wheel in one window, with the noise marginalised and its mean predicted.

The noise (ratio, correlation time) is not known: the estimates are averaged over five points of its
posterior (`noise_search`). The mean of the
realised Coulomb torque is c plus the best linear prediction of the mean of n over the window, whose
error is less than that of the level c.
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.moments import (
    COULOMB,
    IDLE,
    LAG,
    MOTOR,
    VISCOUS,
    WARMING,
    Moments,
    Prior,
    Solution,
    Stack,
    coefficients,
    solve,
    stated,
    times,
)
from gyrostat.monitoring.noise import Noise, gram, window_covariance, window_variance
from gyrostat.monitoring.noise_search import find_noise, log_prior, nodes
from gyrostat.monitoring.regression import Estimate, Rows

APART = 4.0
"""Difference from what was known beforehand, in its sigma, above which that is not used."""
CONTRADICTED = 0.7
"""Variance of the noise without what is known beforehand over that with it, below which something
known is wrong. In healthy windows this ratio is above 0.97."""
LITTLE = 0.15
"""Rms of what a solution leaves over the Coulomb torque, above which it contradicts nothing."""


@dataclass(frozen=True, eq=False)
class _Points:
    """Estimates at K points of the noise.

    Attributes:
        log_density: Log posterior density of the noise, (K,).
        solution: Parameters at each.
        mean: Realised mean of the Coulomb torque, (K,), N·m.
        mean_slope: Its derivative by the parameters, (K, P).
        mean_left: Its variance for known parameters, (K,).
    """

    log_density: Vector
    solution: Solution
    mean: Vector
    mean_slope: Matrix
    mean_left: Vector


def estimate(
    rows: Rows, prior: Prior, start: Vector, noise: Noise, *, believe: bool = False
) -> Estimate:
    """Estimate the parameters of a window.

    Args:
        rows: Rows of the regression.
        prior: What is known of the wheel beforehand.
        start: Start values of the parameters, (P,).
        noise: Noise of the previous window, from which the search starts.
        believe: Whether to use what is known beforehand even if the data contradict it.
    """
    columns = all_columns(rows)
    products, _ = gram(columns, rows.time, rows.white, [noise])
    moments = moments_of(products[0], start.size)
    if believe:
        first = solve(moments, prior, start, rows.time.size)
    else:
        first, prior = _contradicted(moments, prior, start, rows)
    left = rows.response - rows.regressors @ first.beta
    speed = rows.regressors[:, [p for p in (VISCOUS, WARMING) if p < start.size]]
    speed = speed[:, speed.any(axis=0)]
    centre, curvature = find_noise(left, speed, rows.time, rows.white, noise)
    noises = nodes(centre, curvature)
    return _average(_points(rows, columns, prior, first.value, noises), noises, prior)


def quick_look(rows: Rows, prior: Prior, noise: Noise) -> Solution:
    """Estimate for a given noise, with what is known beforehand."""
    products, _ = gram(all_columns(rows), rows.time, rows.white, [noise])
    moments = moments_of(products[0], prior.mean.size)
    return solve(moments, prior, prior.mean.copy(), rows.time.size)


def all_columns(rows: Rows) -> Matrix:
    """Regressors, instruments, response and noise of the lag."""
    return np.column_stack([rows.regressors, rows.instruments, rows.response, rows.lag_noise])


def with_mean(rows: Rows, noise: Noise) -> Vector:
    """Covariance of the slow noise with its mean over the window, (N,)."""
    along = window_covariance(rows.time, rows.start, rows.end, float(np.exp(noise.log_time)))
    return np.exp(noise.log_ratio) * along


def moments_of(products: Stack, size: int) -> Moments:
    """Moments of regressors, instruments and response, from the products of all columns."""
    x, z, y = slice(0, size), slice(size, 2 * size), 2 * size
    mixed = products[..., z, x].copy()
    # a drive that changes by less than its stated steps has less noise than assumed
    least = mixed[..., LAG, LAG] - products[..., y + 1, y + 2]
    mixed[..., LAG, LAG] = np.maximum(least, 0.0)
    return Moments(
        products[..., x, x],
        mixed,
        products[..., z, z],
        products[..., x, y],
        products[..., z, y],
        products[..., y, y],
    )


def explains(rows: Rows, value: Vector, beta: Vector, prior: Prior) -> bool:
    """Whether a solution is that of a wheel: positive friction that leaves little noise.

    Torque bursts accelerate the wheel, and a free motor constant fits that, with a friction of the
    wrong sign or much that is left.

    Args:
        rows: Rows of the regression.
        value: Parameters, (P,).
        beta: Coefficients, (P,).
        prior: What is known of the wheel beforehand.
    """
    left = rows.response - rows.regressors @ beta
    positive = value[COULOMB] > 0.0 and (value[VISCOUS] > 0.0 or prior.mean[VISCOUS] <= 0.0)
    return bool(positive and np.sqrt(np.mean(left**2)) < LITTLE * beta[COULOMB])


def _contradicted(
    moments: Moments, prior: Prior, start: Vector, rows: Rows
) -> tuple[Solution, Prior]:
    """Estimate, and the prior without what the data clearly contradict.

    A wrong value that is known exactly turns into noise, in which it cannot be told to be wrong.
    """
    count = rows.time.size
    bound = solve(moments, prior, start, count)
    if start.size > IDLE:  # rows are chosen by the power, which biases what is free
        return bound, prior
    places = stated(start.size)
    free = solve(moments, prior.without(places), start, count)
    clear = free.scale < CONTRADICTED * bound.scale
    # in the noise that is to be doubted; 1 / K has a normal error where that of K has none
    spread = np.diagonal(free.slope @ free.covariance @ free.slope.T) * bound.scale / free.scale
    away = np.abs(free.beta - coefficients(prior.mean)[0])[places]
    clear = clear and np.any(away > APART * np.sqrt(spread[places]))
    if not (clear and explains(rows, free.value, free.beta, prior)):
        return bound, prior
    doubted = prior.doubted(places)
    if np.array_equal(doubted.precision, prior.precision):
        return free, prior.without(places)
    return solve(moments, doubted, free.value, count), doubted


def _points(
    rows: Rows, columns: Matrix, prior: Prior, start: Vector, noises: list[Noise]
) -> _Points:
    count, size = rows.time.size, rows.regressors.shape[1]
    own = np.array([with_mean(rows, noise) for noise in noises])
    products, log_det = gram(columns, rows.time, rows.white, noises, own)
    moments = moments_of(products, size)
    solution = solve(moments, prior, start, count)
    weighted = products[:, -1, :size]
    residual = products[:, -1, 2 * size] - np.sum(weighted * solution.beta, axis=1)
    motor = solution.value[:, MOTOR]
    slope = -motor[:, None] * times(solution.slope.swapaxes(1, 2), weighted)
    slope[:, COULOMB] += 1.0
    slope[:, MOTOR] += residual
    variance = [
        np.exp(each.log_ratio) * window_variance(rows.start, rows.end, np.exp(each.log_time))
        for each in noises
    ]
    left = np.maximum(np.array(variance) - products[:, -1, -1], 0.0)
    known = solution.scale[:, None, None] * _in_coefficients(prior, solution)
    log_regressors = np.linalg.slogdet(moments.regressors + known).logabsdet
    log_density = -0.5 * (log_det + log_regressors + (count - size) * np.log(solution.scale))
    log_density += [log_prior(noise) for noise in noises]
    return _Points(
        log_density,
        solution,
        solution.value[:, COULOMB] + motor * residual,
        slope,
        motor**2 * solution.scale * left,
    )


def _in_coefficients(prior: Prior, solution: Solution) -> Stack:
    """Precision of what is known beforehand, for the coefficients."""
    back = np.linalg.inv(solution.slope)
    return back.swapaxes(-1, -2) @ (prior.precision[:, None] * back)


def _weights(log_density: Vector) -> Vector:
    """Weights of the points: those of the rule, times density over the Gaussian."""
    log = log_density - log_density[0]
    log[1:] += 1.5
    weights = np.array([2.0, 1.0, 1.0, 1.0, 1.0]) * np.exp(np.clip(log, -50.0, 3.0))
    return weights / weights.sum()


def _average(points: _Points, noises: list[Noise], prior: Prior) -> Estimate:
    """Mean and covariance over the points of the noise."""
    weights, best = _weights(points.log_density), int(np.argmax(points.log_density))
    solution, slope = points.solution, points.mean_slope
    value, mean = weights @ solution.value, float(weights @ points.mean)
    away, off = solution.value - value, points.mean - mean
    between = (weights[:, None] * away).T @ away
    to_mean = times(solution.covariance, slope)
    apart = points.mean_left + off**2
    scale = solution.scale[best]
    return Estimate(
        value,
        np.tensordot(weights, solution.covariance, 1) + between,
        np.tensordot(weights, solution.scatter, 1) + between,
        mean,
        weights @ (to_mean + off[:, None] * away),
        float(weights @ (np.sum(slope * to_mean, axis=1) + apart)),
        float(weights @ (np.sum(slope * times(solution.scatter, slope), axis=1) + apart)),
        noises[best],
        float(abs(value[MOTOR]) * np.sqrt(scale * np.exp(noises[best].log_ratio))),
        float(np.sqrt(scale)),
        solution.beta[best],
        prior,
    )
