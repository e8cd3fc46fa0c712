"""Noise, integrals and runs of sampled signals."""

import numpy as np
from numpy.typing import NDArray

NORMAL_MAD = 1.482602218505602
"""Standard deviation of a normal variable over its median absolute deviation."""


def scatter(values: NDArray[np.float64]) -> float:
    """Standard deviation of the noise on a smooth signal, from its second differences.

    The median makes it insensitive to steps.

    Args:
        values: Samples, (N,).
    """
    differences = np.abs(np.diff(values, 2))
    return NORMAL_MAD * float(np.median(differences)) / np.sqrt(6.0) if len(differences) else 0.0


def trapezoidal(values: NDArray[np.float64], time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cumulative trapezoidal integral, (N,). Importing SciPy's would take half a second."""
    areas = 0.5 * (values[1:] + values[:-1]) * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(areas)])


def held_integral(values: NDArray[np.float64], time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cumulative integral of a signal that is held from sample to sample, (N,)."""
    return np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(time))])


def runs(at: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Start and end (exclusive) of each run of True.

    Args:
        at: Flags, (N,).
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def rounded(values: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Values, (N,), rounded to multiples of a step; as they are if it is zero."""
    return step * np.round(values / step) if step else values
