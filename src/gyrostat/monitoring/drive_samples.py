"""What the samples of a drive leave open: their noise, and when it steps between two of them.

The difference of two samples is the regressor of a lag, and its own instrument. Their noise is the
same, so that its square passes for information on the lag. A noise with the same variance
(`lag_noise`) takes it out of their product (errors in variables: Fuller, Measurement Error Models,
1987, ch. 1).

A step of height a between two samples happens anywhere between them. The mean over a block of N
samples then has an error of variance a² / (12 N²), and the sum of the squared second differences
grows by 2 a², so that their rms over √6, r, tells a variance of r² / (4 N).
"""

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks


def sample_noise(blocks: Blocks, wheel: int) -> float:
    """Standard deviation of the noise of a sample of the drive, with its rounding, A."""
    finest = np.where(np.isfinite(blocks.step[:, wheel]), blocks.step[:, wheel], 0.0)
    noise = np.median(blocks.drive_noise[:, wheel])
    return max(float(noise), float(np.median(finest)) / 12.0**0.5)


def step_variance(blocks: Blocks, wheel: int, other: float) -> Vector:
    """Variance of the mean of the drive with its steps over that without them, (B,).

    The median is 1: noise has second differences too.

    Args:
        blocks: Blocks of the window.
        wheel: Place of the wheel.
        other: Standard deviation that the balance of a block has for other reasons, A.
    """
    usual = sample_noise(blocks, wheel) ** 2 / blocks.count + other**2
    steps = blocks.drive_noise[:, wheel] ** 2 / (4.0 * blocks.count)
    if not np.all(usual > 0.0):
        return np.ones(len(blocks))
    grown = 1.0 + steps / usual
    return grown / np.median(grown)


def lag_noise(blocks: Blocks, wheel: int) -> Vector:
    """A noise with the variance of that of the rate of the drive over a block, (B,), A/s.

    Neighbouring blocks share a sample.
    """
    signs = np.random.default_rng(0).choice([-1.0, 1.0], len(blocks) + 1)
    return sample_noise(blocks, wheel) * np.diff(signs) / blocks.length
