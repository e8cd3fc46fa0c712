"""Momentum that wheels and body exchange: scale of each measured speed, and what is left over.

No torque between wheels and body, friction included, changes their total momentum. With L the
inertia of the body and of its rotors locked, W its rate, and J, a and w the inertia, axis and
measured speed of each wheel, the body receives

    -(L dW/dt + W x L W) = sum of (J a dw/dt + W x J a w) / s + external torque,

where s is the measured over the true change of a wheel's speed. Differences of neighbouring blocks
leave slow external torques out. Rounded speeds make s too large; what that is by expectation counts
as an error.

A wrong L would make s different from day to day, as slews are about different axes. L, a matrix of
nine elements, is therefore learnt from the first windows, with all s at 1. Its regressors have the
noise of the gyro; their instruments are the rates of change that the wheels' torques give.
"""

from dataclasses import dataclass, field

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
LEARNT = 5
"""Number of windows from which the inertia is learnt."""
RIDGE = 1e-3
"""Weight of the stated inertia, over the mean information of its elements: what no slew shows."""


@dataclass(frozen=True, eq=False)
class Exchange:
    """Exchange of momentum of a spacecraft, with its inertia as learnt.

    Attributes:
        windows: Number of windows that it was learnt from.
        product: Instruments times regressors of the inertia, (9, 9).
        score: Instruments times the torque of the wheels, (9,).
    """

    windows: int = 0
    product: Matrix = field(default_factory=lambda: np.zeros((9, 9)))
    score: Vector = field(default_factory=lambda: np.zeros(9))

    def window(
        self, blocks: Blocks, known: KnownWheels
    ) -> "tuple[list[dict[str, float]], Exchange]":
        """Columns of the window table for each wheel, and what the next window goes on from.

        Args:
            blocks: All blocks of a window.
            known: The wheels. Without axes or inertia there are no columns.
        """
        nothing: list[dict[str, float]] = [{} for _ in known.wheels]
        if known.axes is None or known.inertia is None:
            return nothing, self
        finite = np.all(np.isfinite(blocks.turn), axis=1)
        for values in (blocks.change, blocks.speed):
            finite &= np.all(np.isfinite(values), axis=1)
        blocks = blocks.part(finite)
        if len(blocks) <= FEWEST:
            return nothing, self
        rounding = known.speed_resolution**2 / 12.0 * np.mean(blocks.length**-2.0)
        rounding = rounding * known.rotor_inertia**2
        momentum = known.axes * known.rotor_inertia
        stated = known.inertia + momentum @ known.axes.T
        body, wheels = _body(blocks), _wheels(blocks, momentum)
        received = -body @ stated.ravel()
        learnt = self
        if self.windows < LEARNT and np.any(
            speed_scales(received, wheels, rounding)[1] <= LARGEST_SIGMA
        ):
            learnt = self._learn(body, wheels.sum(axis=2), blocks.rate, stated)
        received = -body @ learnt.inertia(stated).ravel()
        scale, sigma = speed_scales(received, wheels, rounding)
        left = np.sqrt(np.mean(((wheels.sum(axis=2) - received) @ known.axes) ** 2, axis=0))
        rows = [{"exchange_residual": float(each)} for each in left]
        for k in np.flatnonzero(sigma <= LARGEST_SIGMA):
            rows[k] |= {"speed_scale": float(scale[k]), "speed_scale_sigma": float(sigma[k])}
        return rows, learnt

    def inertia(self, stated: Matrix) -> Matrix:
        """Inertia of the body with its rotors locked, as learnt, (3, 3), kg·m².

        Args:
            stated: As known beforehand, symmetric, (3, 3).
        """
        ridge = RIDGE * np.trace(self.product) / 9.0
        if ridge <= 0.0:
            return stated
        missing = -self.score - self.product @ stated.ravel()
        away = np.linalg.solve(self.product + ridge * np.eye(9), missing)
        return stated + away.reshape(3, 3)

    def _learn(self, body: Matrix, torque: Matrix, rate: Matrix, stated: Matrix) -> "Exchange":
        gyroscopic = np.cross(rate, rate @ stated)
        turning = -np.linalg.solve(stated, (torque + gyroscopic).T).T
        instruments = np.eye(3)[None, :, :, None] * turning[:, None, None, :]
        z = np.diff(instruments.reshape(-1, 3, 9), axis=0)
        x, y = np.diff(body, axis=0), np.diff(torque, axis=0)
        return Exchange(
            self.windows + 1,
            self.product + _summed(z, x),
            self.score + _summed(z, y[:, :, None])[:, 0],
        )


def _body(blocks: Blocks) -> Matrix:
    """Torque L dW/dt + W x L W of each element of L, (B, 3, 9)."""
    # means of products of what changes linearly within a block
    across = np.eye(3)[None, :, :, None] * (blocks.turn / blocks.length[:, None])[:, None, None, :]
    for rate, weight in ((blocks.rate, 1.0), (blocks.turn, 1.0 / 12.0)):
        across = across + weight * _crossed(rate, np.eye(3))[..., None] * rate[:, None, None, :]
    return across.reshape(-1, 3, 9)


def _wheels(blocks: Blocks, momentum: Matrix) -> Matrix:
    """Torque J a dw/dt + W x J a w of each wheel, (B, 3, W)."""
    change = blocks.change[:, None, :]
    torque = change / blocks.length[:, None, None] * momentum
    torque += _crossed(blocks.rate, momentum) * blocks.speed[:, None, :]
    return torque + _crossed(blocks.turn, momentum) * change / 12.0


def _crossed(rate: Matrix, columns: Matrix) -> Matrix:
    """Cross products of rates with columns, (B, 3, N)."""
    return np.cross(rate[:, None, :], columns.T).transpose(0, 2, 1)


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
