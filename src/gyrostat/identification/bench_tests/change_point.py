"""Time at which a wheel breaks away, from noisy speeds."""

from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.telemetry.signals import scatter

FINER = 10
"""Candidates of the breakaway time in each sample interval."""
CLEAR = 6.0
"""Speed at the end, in standard deviations of its noise, above which the wheel moved."""
LONGEST = 80
"""Largest number of samples after a clear motion that are fitted."""
BEFORE = 160
"""Largest number of samples before it."""


class Breakaway(NamedTuple):
    """Breakaway of a wheel from rest.

    Attributes:
        time: Time of the breakaway, s.
        sigma: Its standard deviation, s.
    """

    time: float
    sigma: float


def breakaway(time: Vector, speed: Vector, noise: float = 0.0) -> Breakaway | None:
    """Find when a wheel starts to move: mean of the posterior of the time of the change.

    Before it the speed is zero; after it w = a (t - t_b) + b (t - t_b)², with a, b >= 0: the
    friction falls to the Coulomb torque at once, and the current may rise.

    Args:
        time: Sample times, (N,), s.
        speed: Measured speeds in the sense of the current, (N,), rad/s.
        noise: Smallest standard deviation of a measured speed, rad/s.

    Returns:
        The breakaway; None if the wheel does not move clearly.
    """
    noise = max(noise, scatter(speed), 1e-9 * float(np.max(np.abs(speed))), 1e-300)
    smooth = np.convolve(speed, np.ones(3) / 3.0, mode="same")
    moving = np.flatnonzero(np.logical_and.accumulate((smooth > CLEAR * noise)[-2::-1])[::-1])
    if not len(moving):
        return None
    window = slice(max(0, int(moving[0]) - BEFORE), int(moving[0]) + LONGEST + 1)
    t, w = time[window], speed[window]
    candidates = np.linspace(t[0], t[-2], FINER * (len(t) - 2) + 1)
    after = np.maximum(t - candidates[:, None], 0.0)
    misfit = _misfit(after, w)
    best = int(np.argmin(misfit))
    deviance = (misfit - misfit[best]) / noise**2
    weight = np.exp(-0.5 * np.minimum(deviance, 200.0))
    weight /= weight.sum()
    mean = float(weight @ candidates)
    spread = float(np.sqrt(weight @ (candidates - mean) ** 2))
    step = candidates[1] - candidates[0]
    return Breakaway(mean, float(np.hypot(spread, step / np.sqrt(12.0))))


def _misfit(after: Matrix, speed: Vector) -> Vector:
    """Least sums of squares of a line and a parabola with coefficients of 0 or more, (c,).

    Args:
        after: Time since each candidate, 0 before it, (c, n), s.
        speed: Speeds, (n,), rad/s.
    """
    square = after**2
    right = np.stack([after @ speed, square @ speed])
    first, mixed, second = ((a * b).sum(axis=1) for a, b in _pairs(after, square))
    total = float(speed @ speed)
    singles = [
        np.where(r > 0.0, r**2 / np.maximum(p, 1e-300), 0.0)
        for r, p in zip(right, (first, second), strict=True)
    ]
    gain = np.maximum(*singles)
    determinant = first * second - mixed**2
    regular = determinant > 1e-12 * first * second
    divisor = np.where(regular, determinant, 1.0)
    line = (second * right[0] - mixed * right[1]) / divisor
    bend = (first * right[1] - mixed * right[0]) / divisor
    both = line * right[0] + bend * right[1]
    return total - np.where(regular & (line >= 0.0) & (bend >= 0.0), both, gain)


def _pairs(after: Matrix, square: Matrix) -> tuple[tuple[Matrix, Matrix], ...]:
    return (after, after), (after, square), (square, square)
