"""Parameters of a wheel from moments of its blocks with instruments, given the noise.

The axial balance of a rotor, averaged over a block, times the sign s of its speed and over the
motor constant K, with the measured current on the left:

    s i = (s x + c + |w| b + s o + s i' d + s i'_s d_s + |w| (T - T0) b_T + g (p + i² r) + n) / K
        + e,
    x = J (dw + a . dW) / dt

The fifth term, with the rate i' of the current, is a lag of the current's samples behind those of
the speed, such as that of a command held between two samples: d / K is the lag. Left out, it passes
for viscous friction in slews, whose speeds are like sines. Blocks in which the current steps
between two samples have a lag of their own, d_s, as steps may come at one phase of the telemetry;
i' is 0 there, and i'_s elsewhere. The last, only where i comes from the
electrical power, are errors p of the idle power and r of the resistance R, with
g about K / (K |w| + 2 R |i|) (`gyrostat.monitoring.power`, `rows`).

The friction noise n must not be correlated with what it is regressed on. The attitude loop answers
n by the current, hence the current stands on the left. What n does to the speeds nevertheless is
kept out by instruments Z, one for each column X: with V the covariance of n / K + e, the estimate
makes Z' V⁻¹ (y - X β) least in the metric of its own covariance Z' V⁻¹ Z, added to what was known
before (two-stage generalised least squares; Hausman and Taylor, Handbook of Econometrics, ch. 12).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.monitoring.wheel_data import USUAL_SIGMA

Stack = NDArray[np.float64]
"""Array with a first axis for several noises, or without it for one."""
MOTOR, COULOMB, VISCOUS, OFFSET, LAG, STEP, WARMING, IDLE, RESISTANCE = range(9)
"""Places of the parameters: K, c, b, o, d, d_s, b_T, p and r."""
UNKNOWN = 1e-6
"""Factor of the precision of what is known beforehand that takes it away."""
ROUNDING = 1e-14
"""Sum of squares of a residual over that of the response, below which it is rounding."""
SMALL = 1e-3
"""Last step over the standard deviations, and last relative change of the scale."""


@dataclass(frozen=True, eq=False)
class Prior:
    """What is known of a wheel beforehand.

    Attributes:
        mean: Parameters, (P,), SI.
        precision: Inverse variances, (P,); 0 where nothing is known.
    """

    mean: Vector
    precision: Vector

    def doubted(self, places: Sequence[int]) -> "Prior":
        """With usual standard deviations of some parameters, where smaller ones are stated.

        Where motor constant and viscous friction explain a window alike, the latter, which varies
        more from wheel to wheel and with temperature, is thus the more likely one to be wrong.
        """
        sigma = np.zeros_like(self.mean)
        for place, name in {MOTOR: "motor_constant", VISCOUS: "viscous"}.items():
            sigma[place] = USUAL_SIGMA[name] * np.abs(self.mean[place])
        precision, places = self.precision.copy(), list(places)
        most = 1.0 / np.maximum(sigma[places] ** 2, 1e-300)
        precision[places] = np.minimum(precision[places], most)
        return Prior(self.mean, precision)

    def held(self, places: Sequence[int]) -> "Prior":
        """With some parameters known a thousand times better."""
        precision = self.precision.copy()
        precision[list(places)] /= UNKNOWN
        return Prior(self.mean, precision)

    def without(self, places: Sequence[int]) -> "Prior":
        """Without what is known of some parameters."""
        precision, places = self.precision.copy(), list(places)
        # what is stated exactly has a sigma of its value then
        most = 1.0 / np.maximum(self.mean[places] ** 2, 1e-300)
        precision[places] = np.minimum(UNKNOWN * precision[places], most)
        return Prior(self.mean, precision)


def stated(size: int) -> list[int]:
    """Places of the parameters whose values are stated for each wheel, of P parameters."""
    return [MOTOR, VISCOUS, *range(IDLE, size)]


@dataclass(frozen=True, eq=False)
class Moments:
    """Products of the columns with the inverse covariance, for the scale 1 of the noise.

    Attributes:
        regressors: Xᵀ V⁻¹ X, (..., P, P).
        mixed: Zᵀ V⁻¹ X, (..., P, P), without the noise that is the same in an instrument and its
            regressor.
        instruments: Zᵀ V⁻¹ Z, (..., P, P).
        regressors_response: Xᵀ V⁻¹ y, (..., P).
        instruments_response: Zᵀ V⁻¹ y, (..., P).
        response: yᵀ V⁻¹ y, (...).
    """

    regressors: Stack
    mixed: Stack
    instruments: Stack
    regressors_response: Stack
    instruments_response: Stack
    response: Stack

    @cached_property
    def projection(self) -> Stack:
        """From products of instruments with a column to those of regressors, (..., P, P)."""
        size = _sizes(self.instruments)[..., None]
        across = size.swapaxes(-1, -2)
        metric = np.linalg.pinv(self.instruments / (size * across), 1e-9, hermitian=True)
        return (self.mixed / size).swapaxes(-1, -2) @ metric / across

    @cached_property
    def projected(self) -> tuple[Stack, Stack]:
        """Regressors and response projected on the instruments, (..., P, P) and (..., P)."""
        projection = self.projection
        return projection @ self.mixed, times(projection, self.instruments_response)

    def squares(self, beta: Stack) -> Stack:
        """Sums of squares of the whitened residual for coefficients β, (...)."""
        away = times(self.regressors, beta) - 2.0 * self.regressors_response
        return self.response + np.sum(beta * away, axis=-1)


@dataclass(frozen=True, eq=False)
class Solution:
    """Estimate for a given noise, or for several.

    Attributes:
        value: Parameters, (..., P).
        covariance: (..., P, P).
        scatter: Part of the covariance that differs from window to window, (..., P, P).
        beta: Coefficients β, (..., P).
        slope: dβ / dparameters, (..., P, P).
        scale: Variance of the noise over that of V, (...).
    """

    value: Stack
    covariance: Stack
    scatter: Stack
    beta: Stack
    slope: Stack
    scale: Stack


def times(matrix: Stack, vector: Stack) -> Stack:
    """Products of matrices (..., P, P) and vectors (..., P)."""
    return (matrix @ vector[..., None])[..., 0]


def coefficients(value: Stack) -> tuple[Stack, Stack]:
    """Coefficients β of the columns and their derivatives by the parameters.

    Args:
        value: Parameters, (..., P).
    """
    over = 1.0 / value[..., MOTOR, None]
    beta = value * over
    slope = over[..., None] * np.eye(value.shape[-1])
    beta[..., MOTOR] = over[..., 0]
    slope[..., MOTOR] = -over * beta
    return beta, slope


def solve(moments: Moments, prior: Prior, start: Vector, blocks: int) -> Solution:
    """Estimate the parameters from moments and what was known before.

    Args:
        moments: Moments of the window, for one noise or for several.
        prior: Knowledge beforehand.
        start: Start values, (P,).
        blocks: Number of blocks.
    """
    gain, aim = moments.projected
    value = np.broadcast_to(start, aim.shape)
    beta, slope = coefficients(value)
    # too small a scale would lead away from what is known beforehand, and not back
    scale = _scale(moments, beta, blocks)
    known = np.diag(prior.precision)
    for _ in range(6):
        left = times(slope.swapaxes(-1, -2), aim - times(gain, beta)) / scale[..., None]
        covariance = _inverse(_information(gain, slope, scale) + known)
        step = times(covariance, left + prior.precision * (prior.mean - value))
        # a motor constant that the data leave free must not change sign on the way
        limit = 0.5 * np.abs(value[..., MOTOR])
        shorter = limit / np.maximum(np.abs(step[..., MOTOR]), limit)
        step = step * shorter[..., None]
        value = value + step
        beta, slope = coefficients(value)
        before, scale = scale, _scale(moments, beta, blocks)
        in_sigma = np.sum(step**2 / np.diagonal(covariance, axis1=-2, axis2=-1), axis=-1)
        if np.all((in_sigma < SMALL**2) & (np.abs(scale / before - 1.0) < SMALL)):
            break
    inform = _information(gain, slope, scale)
    covariance = _inverse(inform + known)
    return Solution(value, covariance, covariance @ inform @ covariance, beta, slope, scale)


def _information(gain: Stack, slope: Stack, scale: Stack) -> Stack:
    """Information of the data on the parameters, (..., P, P)."""
    return slope.swapaxes(-1, -2) @ gain @ slope / scale[..., None, None]


def _scale(moments: Moments, beta: Stack, blocks: int) -> Stack:
    least = np.maximum(ROUNDING * moments.response, 1e-300)
    return np.maximum(moments.squares(beta), least) / max(blocks - beta.shape[-1], 1)


def _sizes(matrix: Stack) -> Stack:
    """Roots of the diagonal; 1 for a column that is 0."""
    size = np.sqrt(np.diagonal(matrix, axis1=-2, axis2=-1))
    return np.where(size > 0.0, size, 1.0)


def _inverse(matrix: Stack) -> Stack:
    """Inverse of a symmetric matrix; directions without information get a large variance."""
    size = _sizes(matrix)
    both = size[..., None] * size[..., None, :]
    return np.linalg.inv(matrix / both + 1e-12 * np.eye(matrix.shape[-1])) / both
