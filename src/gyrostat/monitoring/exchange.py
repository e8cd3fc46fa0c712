"""Momentum that wheels and body exchange: scale of each measured speed, and what is left over.

No torque between wheels and body, friction included, changes their total momentum. With L the
inertia of the body and of its rotors locked, W its rate, and J, a and w the inertia, axis and
measured speed of each wheel, the body receives

    -(L dW/dt + W x L W) = sum of (J a dw/dt + W x J a w) / s + external torque,

where s is the measured over the true change of a wheel's speed: 1 but for errors of the inertias
and the gyro. Differences of neighbouring blocks leave slow external torques out. Rounded speeds
make s too large; what that is by expectation counts as an error.
"""

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.wheel_data import KnownWheels

FEWEST = 30
"""Smallest number of differences of blocks."""
LARGEST_SIGMA = 0.01
"""Standard deviation above which a window does not determine a scale. In quiet pointing, most of
the exchange is what the attitude loop makes of gyro noise, which would bias it."""
LAGS = 2
"""Differences of changes of a rate with white noise are correlated so far. Correlations have
Bartlett's weights, so that no variance is negative (Newey and West, Econometrica 55, 1987)."""


def exchange_columns(blocks: Blocks, known: KnownWheels) -> list[dict[str, float]]:
    """Columns of the window table that the exchange of momentum gives, for each wheel.

    Args:
        blocks: All blocks of a window.
        known: The wheels. Without axes or inertia there are no columns.
    """
    if known.axes is None or known.inertia is None:
        return [{} for _ in known.wheels]
    finite = np.all(np.isfinite(blocks.turn), axis=1)
    for values in (blocks.change, blocks.speed):
        finite &= np.all(np.isfinite(values), axis=1)
    blocks = blocks.part(finite)
    if not len(blocks):
        return [{} for _ in known.wheels]
    body, wheels = _torques(blocks, known)
    along = (body + wheels.sum(axis=2)) @ known.axes
    rounding = known.speed_resolution**2 / 12.0 * np.mean(blocks.length**-2.0)
    scale, sigma = speed_scales(-body, wheels, rounding * known.rotor_inertia**2)
    rows = []
    for k, left in enumerate(np.sqrt(np.mean(along**2, axis=0))):
        row = {"exchange_residual": float(left)}
        if sigma[k] <= LARGEST_SIGMA:
            row |= {"speed_scale": float(scale[k]), "speed_scale_sigma": float(sigma[k])}
        rows.append(row)
    return rows


def _torques(blocks: Blocks, known: KnownWheels) -> tuple[Matrix, Matrix]:
    """Torque L dW/dt + W x L W, (B, 3), and J a dw/dt + W x J a w of each wheel, (B, 3, W)."""
    assert known.axes is not None
    assert known.inertia is not None
    momentum = known.axes * known.rotor_inertia
    locked = known.inertia + momentum @ known.axes.T
    length = blocks.length[:, None]
    # means of products of what changes linearly within a block
    body = (blocks.turn @ locked) / length + np.cross(blocks.rate, blocks.rate @ locked)
    body += np.cross(blocks.turn, blocks.turn @ locked) / 12.0
    across, turning = (
        np.cross(rate[:, None, :], momentum.T).transpose(0, 2, 1)
        for rate in (blocks.rate, blocks.turn)
    )
    change = blocks.change[:, None, :]
    wheels = change / length[:, :, None] * momentum
    wheels += across * blocks.speed[:, None, :] + turning * change / 12.0
    return body, wheels


def speed_scales(received: Matrix, wheels: Matrix, rounding: Vector) -> tuple[Vector, Vector]:
    """Measured over true speed of each wheel, and standard deviations.

    Args:
        received: Torque on the body, (B, 3), N·m.
        wheels: Torque of each wheel by its measured speed, (B, 3, W), N·m.
        rounding: Variance of the torque by the rounding of one sample, (W,), (N·m)².

    Returns:
        Scales and standard deviations, each (W,); infinite standard deviations where a wheel
        does not show.
    """
    count = wheels.shape[2]
    scale, sigma = np.ones(count), np.full(count, np.inf)
    y, x = np.diff(received, axis=0), np.diff(wheels, axis=0)
    product = _summed(x, x)
    moving = np.diagonal(product) > 0.0
    if len(y) < FEWEST or not np.any(moving):
        return scale, sigma
    x, product = x[:, :, moving], product[np.ix_(moving, moving)]
    size = np.sqrt(np.diagonal(product))
    # directions that do not show get a large variance
    inverse = np.linalg.inv(product / np.outer(size, size) + 1e-9 * np.eye(size.size))
    inverse /= np.outer(size, size)
    share = inverse @ _summed(x, y[:, :, None])[:, 0]
    residual = y - x @ share
    middle = np.zeros_like(product)
    for lag in range(LAGS + 1):
        first, second = slice(0, len(y) - lag), slice(lag, None)
        common = np.sum(residual[first] * residual[second], axis=0) / len(y)
        common *= 1.0 - lag / (LAGS + 1.0)
        term = _summed(x[first] * common[:, None], x[second])
        middle += term if lag == 0 else term + term.T
    # a difference of changes has one sample twice and two once: 6 of their variances
    bias = inverse @ (6.0 * len(y) * rounding[moving] * share)
    variance = np.diagonal(inverse @ middle @ inverse.T) + bias**2
    shown = (share > 0.0) & (variance > 0.0)
    places = np.flatnonzero(moving)[shown]
    scale[places] = 1.0 / share[shown]
    sigma[places] = np.sqrt(variance[shown]) * scale[places] ** 2
    return scale, sigma


def _summed(first: Matrix, second: Matrix) -> Matrix:
    """Products of columns, summed over blocks and axes."""
    return first.reshape(-1, first.shape[2]).T @ second.reshape(-1, second.shape[2])
