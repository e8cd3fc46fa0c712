"""Noise, steps and decelerations of evenly sampled values, from their differences.

A step of height a between the samples j and j + 1 has the second differences a and -a at j - 1 and
j. White noise has second differences √6 times as large, and fourth ones √70 times; slow motion
hardly has fourth ones.
"""

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector

ROOT = 0.8222
"""Mean square root of the absolute value of a standard normal variable."""
LARGE = 0.7
"""Product of two second differences over the square of one, above which both are of one step."""
STEP = 3.0
"""Difference of two samples over the largest of the next ones, above which it is a step."""
BESIDE = 3
"""Number of these: the difference of two samples of a smooth current may be 0, but not of three."""
BRAKING = 5.0
"""Least time over which a deceleration is a mean, s: the smallest number of samples that has it."""


def noise(bend: Matrix, first: NDArray[np.int64], last: NDArray[np.int64]) -> Matrix:
    """Standard deviation of the noise of a sample of each block; steps count as noise.

    Args:
        bend: Second differences of the samples, up to the one after the last of `last`, (N, M).
        first: Places of the first samples of the blocks, (B,).
        last: Places of the first samples of the next blocks, (B,).
    """
    return np.sqrt(np.add.reduceat(bend * bend, first, axis=0) / (6.0 * (last - first))[:, None])


def calm_noise(bend: Matrix, first: NDArray[np.int64], last: NDArray[np.int64]) -> Matrix:
    """The same, to which a few steps and slow motion add little; 0 of less than three samples."""
    wild = np.zeros_like(bend)
    wild[2:] = np.sqrt(np.abs(np.diff(bend, n=2, axis=0)))
    # a block is the same whatever was given before it
    for early in (first, np.minimum(first + 1, last - 1)):
        wild[early] = 0.0
    mean = np.add.reduceat(wild, first, axis=0) / np.maximum(last - first - 2, 1)[:, None]
    return (mean / ROOT) ** 2 / np.sqrt(70.0)


def steps(bend: Matrix, first: NDArray[np.int64], last: NDArray[np.int64]) -> Matrix:
    """Height of the largest step of each block.

    A step with a sample on its way has second differences of half its height, two samples apart.
    """
    square = np.zeros_like(bend)
    square[1:] = np.maximum(-bend[1:] * bend[:-1], 0.0)
    square[2:] = np.maximum(-bend[2:] * bend[:-2], square[2:])
    # the samples before those of a step at the start of a block are not there
    early = np.stack([first, np.minimum(first + 1, last - 1)])
    begins = bend[early] ** 2
    pair = np.zeros_like(begins)
    for away in (1, 2):
        later = np.minimum(early + away, bend.shape[0] - 1)
        pair = np.maximum(pair, -bend[early] * bend[later])
    square[first] = 0.0
    square[early[1]] = np.maximum(-bend[early[1]] * bend[first], 0.0)
    square[early] = np.where(pair < LARGE * begins, begins, square[early])
    return np.sqrt(np.maximum.reduceat(square, first, axis=0))


def change_inwards(values: Matrix, edge: NDArray[np.int64], far: NDArray[np.int64]) -> Matrix:
    """Change from the edge of each block to the next sample inside; 0 if it is a step, (B, M).

    Gregory's rule holds for what is smooth: a step would count for a twelfth of a sample, which
    changed the current of a slew of 20 samples by 0.4 %.

    Args:
        values: Samples, (N, M).
        edge: Place of the first or the last sample of each block, (B,).
        far: Place of the other one, (B,).
    """
    inwards = np.minimum(np.arange(BESIDE + 2)[:, None], np.abs(far - edge))
    change = np.diff(values[edge + np.sign(far - edge) * inwards], axis=0)
    size = np.abs(change)
    return np.where(size[0] > STEP * np.max(size[1:], axis=0), 0.0, change[0])


def deceleration(
    time: Vector, magnitude: Matrix, first: NDArray[np.int64], last: NDArray[np.int64]
) -> Matrix:
    """Largest deceleration between two samples of each block that are `BRAKING` apart."""
    period = (time[last] - time[first]) / (last - first)
    # a little jitter of the samples does not take one more
    lags = np.minimum(np.ceil(0.99 * BRAKING / period).astype(np.int64), last - first)
    largest = np.empty((first.size, magnitude.shape[1]))
    for lag in np.unique(lags):
        blocks = lags == lag
        slowed = magnitude[:-lag] - magnitude[lag:]
        slowed /= (time[lag:] - time[:-lag])[:, None]
        # each block up to the pair that ends with its last sample
        slowed = np.concatenate([slowed, slowed[-1:]])
        bounds = np.column_stack([first[blocks], last[blocks] - lag + 1]).ravel()
        largest[blocks] = np.maximum.reduceat(slowed, bounds, axis=0)[::2]
    return largest
