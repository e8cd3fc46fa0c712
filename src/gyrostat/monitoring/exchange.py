"""Momentum that wheels and body exchange: scale of each measured speed, and what is left over.

No torque between wheels and body, friction included, changes their total momentum. With L the
inertia of the body and of its rotors locked, W its rate, and J, a and w the inertia, axis and
measured speed of each wheel, the body receives

    -(L dW/dt + W x L W) = sum of s (J a dw/dt + W x J a w) + external torque,

where s is the true over the measured change of a wheel's speed. Differences of neighbouring blocks
leave slow external torques out. Rounded speeds make s too small; what that is by expectation counts
as an error.

A wrong L would make s different from day to day, as slews are about different axes. L, a matrix of
nine elements, is therefore learnt, with all s at 1, from windows for which it is not known well
enough; the error that is left counts in s. The regressors have the noise of the gyro; their
instruments are the rates of change that the wheels' torques give.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.telemetry.signals import NORMAL_MAD

FEWEST = 30
"""Smallest number of differences of blocks."""
LARGEST_SIGMA = 0.01
"""Standard deviation above which a window does not determine a scale. In quiet pointing, most of
the exchange is what the attitude loop makes of gyro noise, which would bias it."""
LAGS = 2
"""Differences of changes of a rate with white noise are correlated so far. Correlations have
Bartlett's weights, so that no variance is negative (Newey and West, Econometrica 55, 1987)."""
UNKNOWN = 0.05
"""Standard deviation of each element of the stated inertia, over its mean principal moment."""
ENOUGH = 0.7
"""Error by the inertia, over the other errors of a scale, below which it is known well enough."""
CONTRADICTED = 0.2
"""Relative difference from the stated inertia, or of the scales of all wheels from 1, above which
something else is wrong."""

FASTEST, COMMON = 2.0, 0.5
"""Momentum gained by the body over that lost by the wheels above which a unit is probably wrong,
and their correlation above which this counts."""


@dataclass(frozen=True, eq=False)
class Exchange:
    """Exchange of momentum of a spacecraft, with its inertia as learnt.

    Attributes:
        product: Instruments times regressors of the inertia, (9, 9).
        score: Instruments times the torque of the wheels, (9,).
        difference: Relative difference from the stated inertia of the learnt one, or of the one
            with which a window that contradicts it would agree.
    """

    product: Matrix = field(default_factory=lambda: np.zeros((9, 9)))
    score: Vector = field(default_factory=lambda: np.zeros(9))
    difference: float = 0.0

    @property
    def contradicted(self) -> bool:
        """Whether rates, speeds and stated inertia contradict each other."""
        return bool(self.difference > CONTRADICTED)

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
        finite = np.ones(len(blocks), dtype=bool)
        for values in (blocks.rate, blocks.turn, blocks.change, blocks.speed):
            finite &= np.all(np.isfinite(values), axis=1)
        blocks = blocks.part(finite)
        if len(blocks) <= FEWEST:
            return nothing, self
        rounding = known.speed_resolution**2 / 12.0 * np.mean(blocks.length**-2.0)
        momentum = known.axes * known.rotor_inertia
        stated = known.inertia + momentum @ known.axes.T
        body, wheels = _body(blocks), _wheels(blocks, momentum)
        torque = wheels.sum(axis=2)
        times = _turned(blocks, momentum, stated)
        if times > FASTEST:
            return nothing, replace(self, difference=times - 1.0)
        left = np.diff(body @ stated.ravel() + torque, axis=0)
        noise = (NORMAL_MAD * float(np.median(np.abs(left)))) ** 2
        regression = Regression.of(wheels, rounding * known.rotor_inertia**2)
        learnt = self
        inertia, covariance = self.inertia(stated, noise)
        scale, sigma, unsure = regression.scales(body, inertia, covariance)
        shown = sigma <= LARGEST_SIGMA
        if np.any(shown) and np.min(np.abs(scale[shown] - 1.0)) > CONTRADICTED:
            return nothing, replace(self, difference=float(np.min(np.abs(scale[shown] - 1.0))))
        if np.any(shown & (unsure > ENOUGH * sigma)):
            learnt = self._learn(body, torque, blocks.rate, stated)
            inertia, covariance = learnt.inertia(stated, noise)
            scale, sigma, unsure = regression.scales(body, inertia, covariance)
        away = float(np.linalg.norm(inertia - stated) / np.linalg.norm(stated))
        learnt = replace(learnt, difference=away)
        sigma = np.hypot(sigma, unsure)
        left = (body @ inertia.ravel() + torque) @ known.axes
        rows = [{"exchange_residual": float(each)} for each in np.sqrt(np.mean(left**2, axis=0))]
        if not learnt.contradicted:
            for k in np.flatnonzero(sigma <= LARGEST_SIGMA):
                rows[k] |= {"speed_scale": float(scale[k]), "speed_scale_sigma": float(sigma[k])}
        return rows, learnt

    def inertia(self, stated: Matrix, noise: float) -> tuple[Matrix, Matrix]:
        """Inertia of the body with its rotors locked, as learnt, and its covariance.

        Args:
            stated: As known beforehand, symmetric, (3, 3), kg·m².
            noise: Variance of a difference of torques, (N·m)².

        Returns:
            Inertia, (3, 3), kg·m², and the covariance of its elements, (9, 9).
        """
        variance = (UNKNOWN * np.trace(stated) / 3.0) ** 2
        ridge = max(noise / variance, 1e-9 * float(np.trace(self.product)), 1e-300)
        both = self.product + ridge * np.eye(9)
        missing = -self.score - self.product @ stated.ravel()
        away = np.linalg.solve(both, missing)
        covariance = variance * ridge * np.linalg.inv(0.5 * (both + both.T))
        return stated + away.reshape(3, 3), covariance

    def _learn(self, body: Matrix, torque: Matrix, rate: Matrix, stated: Matrix) -> "Exchange":
        gyroscopic = np.cross(rate, rate @ stated)
        turning = -np.linalg.solve(stated, (torque + gyroscopic).T).T
        instruments = np.eye(3)[None, :, :, None] * turning[:, None, None, :]
        z = np.diff(instruments.reshape(-1, 3, 9), axis=0)
        x, y = np.diff(body, axis=0), np.diff(torque, axis=0)
        return Exchange(self.product + _summed(z, x), self.score + _summed(z, y[:, :, None])[:, 0])


def _turned(blocks: Blocks, momentum: Matrix, inertia: Matrix) -> float:
    """Momentum that the body gains over that of the wheels; 0 if they have little in common.

    Rates that are far too large, as degrees taken for radians are, have torques W x L W that hide
    the scales of the speeds. These are left out here: what is left is proportional to the rates.

    Args:
        blocks: Blocks of the window.
        momentum: Axes times inertia of the rotors, (3, W), kg·m².
        inertia: As stated, (3, 3), kg·m².
    """
    lost = -blocks.change @ momentum.T
    stored = np.cross(blocks.rate, blocks.speed @ momentum.T)
    gained = blocks.turn @ inertia + stored * blocks.length[:, None]
    common = float(np.sum(gained * lost))
    if not common > COMMON * np.sqrt(np.sum(gained**2) * np.sum(lost**2)):
        return 0.0
    return common / float(np.sum(lost**2))


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


@dataclass(frozen=True, eq=False)
class Regression:
    """Regression of the torque on the body on those of the wheels that move, in differences.

    Attributes:
        moving: Whether each wheel moves, (W,).
        wheels: Differences of the torques of moving wheels, (B - 1, 3, M).
        inverse: Inverse of their products, (M, M).
        rounding: Variance of a torque by the rounding of one sample, (M,), (N·m)².
    """

    moving: NDArray[np.bool_]
    wheels: Matrix
    inverse: Matrix
    rounding: Vector

    @staticmethod
    def of(wheels: Matrix, rounding: Vector) -> "Regression":
        """Regression for torques, (B, 3, W), N·m, with the variance by rounding, (W,), (N·m)²."""
        x = np.diff(wheels, axis=0)
        product = _summed(x, x)
        moving = np.diagonal(product) > 0.0
        product = product[np.ix_(moving, moving)]
        size = np.sqrt(np.diagonal(product))
        # directions that do not show get a large variance
        inverse = np.linalg.inv(product / np.outer(size, size) + 1e-9 * np.eye(size.size))
        return Regression(moving, x[:, :, moving], inverse / np.outer(size, size), rounding[moving])

    def scales(
        self, body: Matrix, inertia: Matrix, covariance: Matrix
    ) -> tuple[Vector, Vector, Vector]:
        """True over measured speed of each wheel.

        Args:
            body: Torque of each element of the inertia, (B, 3, 9).
            inertia: (3, 3), kg·m².
            covariance: That of the elements of the inertia, (9, 9).

        Returns:
            Scales, their standard deviations without and by the error of the inertia, each (W,);
            infinite where a wheel does not show.
        """
        x, b = self.wheels, np.diff(body, axis=0)
        received = -self.inverse @ _summed(x, b)
        share = received @ inertia.ravel()
        residual = -b @ inertia.ravel() - x @ share
        middle = np.zeros_like(self.inverse)
        for lag in range(LAGS + 1):
            first, second = slice(0, len(x) - lag), slice(lag, None)
            common = np.sum(residual[first] * residual[second], axis=0) / len(x)
            common *= 1.0 - lag / (LAGS + 1.0)
            term = _summed(x[first] * common[:, None], x[second])
            middle += term if lag == 0 else term + term.T
        # a difference of changes has one sample twice and two once: 6 of their variances; where
        # rounding is all there is, the scales are near 0, and their own share would say no bias
        bias = self.inverse @ (6.0 * len(x) * self.rounding * np.maximum(share, 1.0))
        # of data without noise, rounding can leave a negative variance
        variance = np.maximum(np.diagonal(self.inverse @ middle @ self.inverse.T), 0.0)
        own = np.sqrt(variance + bias**2)
        unsure = np.sqrt(np.sum((received @ covariance) * received, axis=1))
        shown = (share > 0.0) & (own > 0.0)
        values = []
        for value, blank in ((share, 1.0), (own, np.inf), (unsure, np.inf)):
            whole = np.full(self.moving.size, blank)
            whole[np.flatnonzero(self.moving)[shown]] = value[shown]
            values.append(whole)
        return values[0], values[1], values[2]


def _summed(first: Matrix, second: Matrix) -> Matrix:
    """Products of columns, summed over blocks and axes."""
    return first.reshape(-1, first.shape[2]).T @ second.reshape(-1, second.shape[2])
