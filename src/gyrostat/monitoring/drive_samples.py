"""What the samples of a drive leave open: their noise, and when it steps between two of them.

The difference of two samples is the regressor of a lag, and its own instrument. Their noise is the
same, so that its square passes for information on the lag. A noise with the same variance
(`lag_noise`) takes it out of their product (errors in variables: Fuller, Measurement Error Models,
1987, ch. 1).

A step of height a between two samples happens anywhere between them. The mean over a block of N
samples then has an error of variance a² / (12 N²).
"""

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks

FAR = 12.0
"""Largest step of a block over the noise of the samples about it, above which it is one. One of
some 20000 blocks of white noise reaches it."""
ABOUT = 17
"""Number of blocks that show the noise before, or after, a block, with it."""
CALM = 0.25
"""Share of the blocks that is enough to be without slews."""
CHANCE = 0.9
"""A share `CALM` of blocks of N samples of white noise shows less than 1 - CHANCE / √N of its
standard deviation, within 8 % for N from 4 to 600."""
MANY = 40
"""Number of samples of a block whose noise a step hardly changes: by 0.4 % of its height."""
DIVIDES = 0.01
"""Remainder over a step, below which it is an error of arithmetic."""
MOST = 0.9
"""Share of the blocks whose differences are multiples of the resolution: one odd sample, as a fill
value, does not decide."""
PRINTED = 4.0
"""Resolution over that of the printed digits, above which it shows in them."""
INEXACT = 1.5
"""Largest error of a difference of two printed values, with that of the step, in units of the last
digit."""
MIDWAY = 0.3
"""Largest error of a multiple over a step, which half a step would leave open."""
CHANCES = 1e-2
"""Largest chance that the multiples of a step are none."""
TRIED = 24
"""Number of differences among which resolutions are sought."""


def sample_noise(blocks: Blocks, wheel: int, step: float) -> float:
    """Standard deviation of the noise of a sample of the drive, or of its rounding, A.

    Args:
        blocks: Blocks of the window.
        wheel: Place of the wheel.
        step: Their `resolution`, A.
    """
    noise = blocks.drive_noise[:, wheel]
    noise = noise[np.isfinite(noise)]
    usual = float(np.quantile(noise, CALM)) / _chance(blocks) if noise.size else 0.0
    return max(usual, step / 12.0**0.5)


def stepping(blocks: Blocks, wheel: int, step: float) -> NDArray[np.bool_]:
    """Blocks in which the drive steps between two samples, (B,).

    A block of many samples with noise of its own has no steps.

    Args:
        blocks: Blocks of the window.
        wheel: Place of the wheel.
        step: Their `resolution`, A.
    """
    own, height = np.nan_to_num(blocks.drive_noise[:, wheel]), blocks.drive_steps[:, wheel]
    near = np.pad(own, ABOUT - 1, mode="symmetric")
    near = np.lib.stride_tricks.sliding_window_view(near, ABOUT)
    calm = np.partition(near, int(CALM * ABOUT), axis=1)[:, int(CALM * ABOUT)]
    calm /= _chance(blocks)
    about = np.maximum(calm[: len(blocks)], calm[ABOUT - 1 :])
    about = np.maximum(about, np.where(blocks.count >= MANY, own, 0.0))
    least = np.maximum(about, step / 12.0**0.5)
    return height > FAR * least


def step_variance(
    blocks: Blocks, wheel: int, steps: NDArray[np.bool_], noise: float, other: float
) -> Vector:
    """Variance of the mean of the drive with its steps over that without them, (B,).

    Args:
        blocks: Blocks of the window.
        wheel: Place of the wheel.
        steps: Those that are `stepping`, (B,).
        noise: Their `sample_noise`, A.
        other: Standard deviation that the balance of a block has for other reasons, A.
    """
    usual = noise**2 / blocks.count + other**2
    height = np.where(steps, blocks.drive_steps[:, wheel], 0.0)
    # a drive that has come back has stepped twice
    twice = np.where(np.abs(blocks.drive_change[:, wheel]) < 0.5 * height, 2.0, 1.0)
    return 1.0 + twice * height**2 / (12.0 * blocks.count**2 * np.maximum(usual, 1e-300))


def lag_noise(blocks: Blocks, noise: float) -> Vector:
    """A noise with the variance of that of the rate of a drive over a block, (B,), A/s.

    Neighbouring blocks share a sample, whose noise is given in A.
    """
    random = np.random.default_rng(0)
    start, other = random.choice([-1.0, 1.0], (2, len(blocks)))
    end = other.copy()
    end[:-1] = np.where(blocks.gaps, other[:-1], start[1:])
    return noise * (end - start) / blocks.length


def _chance(blocks: Blocks) -> float:
    """Noise that a quarter of the blocks shows, over its standard deviation."""
    return 1.0 - CHANCE / float(np.sqrt(np.median(np.maximum(blocks.count, 4))))


def resolution(blocks: Blocks, wheel: int) -> float:
    """Largest step of which most differences of the drive are multiples, A; 0 if there are none.

    A common divisor of the least differences of the blocks: without noise, a current that is the
    same before each slew may change by many steps, and never by one. Counts of a converter that are
    printed with few digits are multiples of its step within one unit of the last digit. Where there
    is no common divisor, it is the least difference.
    """
    found = blocks.step[:, wheel]
    found = found[np.isfinite(found)]
    if not found.size:
        return 0.0
    values = np.unique(found)
    if values.size > TRIED:
        values = np.quantile(found, np.linspace(0.0, 1.0, TRIED), method="nearest")
        values = np.unique(values)
    steps = np.unique(np.concatenate([values, _common_divisors(values[1:], values[:-1])]))
    digits = _largest_divisor(_refined(steps, values, 0.0), found, 0.0)
    if not digits:
        return float(values[0])
    coarse = _refined(steps[steps > PRINTED * digits], values, INEXACT * digits)
    return _largest_divisor(coarse, found, digits) or digits


def _largest_divisor(steps: Vector, differences: Vector, digits: float) -> float:
    """Largest of some steps of which most differences are multiples; 0 if none is.

    Args:
        steps: The steps.
        differences: The differences.
        digits: Unit of the last printed digit; 0: they are exact.
    """
    error = INEXACT * digits
    steps = np.sort(steps)[::-1]
    counts = _counts(steps[:, None], differences, np.maximum(DIVIDES * steps, error)[:, None])
    for place in np.flatnonzero(np.mean(counts > 0.0, axis=1) >= MOST):
        step = float(steps[place])
        if not digits:
            return step
        chance = 2.0 * max(error, DIVIDES * step) / step
        told = np.unique(np.round(differences[counts[place] > 0.0] / digits)).size
        if chance**told < CHANCES:
            return step
    return 0.0


def _counts(steps: Vector, differences: Vector | float, allowed: Vector) -> Vector:
    """How many steps a difference has; 0 if it is no multiple within what is allowed."""
    counts = np.round(differences / steps)
    return np.where(np.abs(differences - counts * steps) <= allowed, counts, 0.0)


def _common_divisors(first: Vector, second: Vector) -> Vector:
    """Common divisor of each pair, by Euclid's algorithm."""
    first, second = first.copy(), second.copy()
    for _ in range(TRIED):
        rest = np.abs(first - second * np.round(first / second))
        going = rest > DIVIDES * second
        if not going.any():
            break
        first, second = np.where(going, second, first), np.where(going, rest, second)
    return second


def _refined(steps: Vector, differences: Vector, error: float) -> Vector:
    """Steps by least squares from their multiples, the small ones first: their errors grow."""
    weight = np.ones_like(steps)
    total = steps.copy()
    for difference in differences:
        step = total / weight
        # the step itself is known as well as the multiples before allow
        allowed = error * (1.0 + np.round(difference / step) / np.sqrt(weight))
        allowed = np.minimum(np.maximum(allowed, DIVIDES * step), MIDWAY * step)
        counts = _counts(step, difference, allowed)
        total, weight = total + counts * difference, weight + counts**2
    return total / weight
