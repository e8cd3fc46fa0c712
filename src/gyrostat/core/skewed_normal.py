"""Skewed normal distribution: a function of a standard normal number.

    x = location + scale (exp(shape z) - 1) / shape,    z standard normal

The g distribution of Tukey (D. C. Hoaglin, "Summarizing shape numerically: the g-and-h
distributions", 1985), which is the three-parameter log-normal distribution, of either sense.
A shape of 0 is the normal distribution; a log-normal one has scale = shape x location.
"""

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.types import Matrix

SMALLEST_SHAPE = 1e-9
"""Smaller shapes are computed with this one: the values differ by less than 1e-7 of the scale."""


def usable_shape(shape: ArrayLike) -> Matrix:
    """Shape that is not zero."""
    shapes = np.asarray(shape, dtype=float)
    return np.where(np.abs(shapes) < SMALLEST_SHAPE, SMALLEST_SHAPE, shapes)


def value_at(score: ArrayLike, location: ArrayLike, scale: ArrayLike, shape: ArrayLike) -> Matrix:
    """Value of a parameter at a standard normal number; the arguments are broadcast."""
    g = usable_shape(shape)
    return np.asarray(location) + np.asarray(scale) * np.expm1(g * np.asarray(score)) / g


def score_of(value: ArrayLike, location: ArrayLike, scale: ArrayLike, shape: ArrayLike) -> Matrix:
    """Standard normal number of a value, infinite where the lot has no such values."""
    g = usable_shape(shape)
    argument = g * (np.asarray(value) - np.asarray(location)) / np.asarray(scale)
    inside = argument > -1.0
    with np.errstate(divide="ignore"):
        return np.where(inside, np.log1p(np.where(inside, argument, 0.0)) / g, -np.sign(g) * np.inf)


def deviation(scale: ArrayLike, shape: ArrayLike) -> Matrix:
    """Standard deviation of the value."""
    g = usable_shape(shape)
    return np.asarray(scale) * np.sqrt(np.exp(g**2) * np.expm1(g**2)) / np.abs(g)
