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


def sample_noise(blocks: Blocks, wheel: int) -> float:
    """Standard deviation of the noise of a sample of the drive, or of its rounding, A."""
    noise = blocks.drive_noise[:, wheel]
    noise = noise[np.isfinite(noise)]
    usual = float(np.quantile(noise, CALM)) / _chance(blocks) if noise.size else 0.0
    return max(usual, resolution(blocks, wheel) / 12.0**0.5)


def stepping(blocks: Blocks, wheel: int) -> NDArray[np.bool_]:
    """Blocks in which the drive steps between two samples, (B,).

    A block of many samples with noise of its own has no steps.
    """
    own, height = np.nan_to_num(blocks.drive_noise[:, wheel]), blocks.drive_steps[:, wheel]
    near = np.pad(own, ABOUT - 1, mode="symmetric")
    near = np.lib.stride_tricks.sliding_window_view(near, ABOUT)
    calm = np.partition(near, int(CALM * ABOUT), axis=1)[:, int(CALM * ABOUT)]
    calm /= _chance(blocks)
    about = np.maximum(calm[: len(blocks)], calm[ABOUT - 1 :])
    about = np.maximum(about, np.where(blocks.count >= MANY, own, 0.0))
    least = np.maximum(about, resolution(blocks, wheel) / 12.0**0.5)
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
    """Largest step of which all differences of the drive are multiples, A; 0 if there are none.

    The greatest common divisor of the least differences of the blocks: without noise, a current
    that is the same before each slew may change by many steps, and never by one.
    """
    left = blocks.step[:, wheel]
    left = np.unique(left[np.isfinite(left)])
    step = 0.0
    while left.size:
        step = float(left[0])
        left = np.abs(left - step * np.round(left / step))
        left = np.unique(left[left > DIVIDES * step])
    return step
