"""Percentiles by the rank definition: exact, or from bins if the values do not fit in memory.

The p-th percentile of n values is the value of rank ceil(p n / 100), counted from 1: the smallest
value such that at least p % of the values do not exceed it. This is definition 1 of R. J. Hyndman
and Y. Fan, "Sample quantiles in statistical packages", 1996, and "inverted_cdf" of NumPy.
"""

from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from math import ceil
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector

MEMORY = 200e6
"""Memory for the errors of one group of runs, bytes; longer runs are counted in bins."""
LEAST, MOST = 2.0**-30, 4.0
"""Range of the bins, rad; smaller errors are counted in the first bin."""
_SHIFT = 52 - 9
"""Number of low mantissa bits that a bin ignores: each octave has 2^9 bins, 0.1 to 0.2 % wide."""


def _code(value: float) -> int:
    return int(np.float64(value).view(np.int64)) >> _SHIFT


_FIRST = _code(LEAST)
BINS = _code(MOST) - _FIRST
"""Number of bins."""


@lru_cache(maxsize=1024)
def rank(percent: float, count: int) -> int:
    """Rank of a percentile, from 1.

    Args:
        percent: Percentage, above 0 and below 100; its decimal representation is used, so that
            99.7 % of 1000 is 997.
        count: Number of values.
    """
    return max(1, ceil(Fraction(repr(float(percent))) * count / 100))


@lru_cache(maxsize=16)
def ranks(percent: float, most: int) -> tuple[int, ...]:
    """Rank of a percentile for 0 to `most` values; see `rank`."""
    return tuple(rank(percent, count) for count in range(most + 1))


def are_sorted(group: int, samples: int, count: int) -> bool:
    """Whether percentiles are exact; see `collectors`."""
    return 8 * group * samples * count <= MEMORY


class Percentiles(Protocol):
    """Percentiles of the errors of several runs."""

    def percentile(self, percent: float) -> Vector:
        """Percentile of each run, (runs,), rad; NaN for a run without errors."""
        ...


class FoundPercentiles:
    """Percentiles that an accelerator has found.

    Args:
        values: Percentage -> percentile of each run, (runs,), rad.
    """

    def __init__(self, values: Mapping[float, Vector]):
        self._values = values

    def percentile(self, percent: float) -> Vector:
        """Percentile of each run; see `SortedErrors`."""
        return self._values[percent]


class SortedErrors:
    """Collector that keeps every error, for exact percentiles.

    Args:
        runs: Number of runs.
        samples: Number of samples of each run, over all calls of `add`.
    """

    def __init__(self, runs: int, samples: int):
        self._errors = np.full((runs, samples), np.inf)
        self._filled = 0
        self._counted: list[int] | None = None

    def add(self, errors: Matrix) -> None:
        """Add the errors of the next samples, (runs, samples), rad; infinite ones are ignored."""
        self._errors[:, self._filled : self._filled + errors.shape[1]] = errors
        self._filled += errors.shape[1]
        self._counted = None

    def percentile(self, percent: float) -> Vector:
        """Percentile of each run, (runs,), rad; NaN for a run without errors."""
        counts = self._counted
        if counts is None:
            self._errors.sort(axis=1)
            self._counted = counts = np.sum(self._errors < np.inf, axis=1).tolist()
        indices = [rank(percent, count) - 1 for count in counts]
        errors = self._errors[np.arange(len(indices)), indices]
        return np.where(errors < np.inf, errors, np.nan)


class BinnedErrors:
    """Collector that counts errors in bins; percentiles are accurate to 0.1 %.

    Args:
        runs: Number of runs.
    """

    def __init__(self, runs: int):
        # the last bin counts the ignored samples
        self._counts: NDArray[np.int64] = np.zeros((runs, BINS + 1), np.int64)
        self._largest = np.full(runs, -np.inf)

    def add(self, errors: Matrix) -> None:
        """Add the errors of the next samples; see `SortedErrors`."""
        # the bits of a positive float, as an integer, increase with its value
        codes = np.ascontiguousarray(errors).view(np.int64) >> _SHIFT
        indices = np.clip(codes - _FIRST, 0, BINS)
        indices += (BINS + 1) * np.arange(len(indices))[:, None]
        np.add.at(self._counts.reshape(-1), indices.ravel(), 1)
        largest = np.max(errors, axis=1, where=errors < np.inf, initial=-np.inf)
        self._largest = np.maximum(self._largest, largest)

    def percentile(self, percent: float) -> Vector:
        """Percentile of each run; see `SortedErrors`."""
        running = np.cumsum(self._counts[:, :BINS], axis=1)
        counts = running[:, -1]
        ranks = np.array([rank(percent, count) for count in counts.tolist()])
        bins = np.argmax(running >= ranks[:, None], axis=1)
        edges = (np.array([bins, bins + 1]) + _FIRST << _SHIFT).view(np.float64)
        middle = np.minimum(edges.mean(axis=0), self._largest)
        return np.where(counts > 0, middle, np.nan)


Collector = SortedErrors | BinnedErrors
"""Collection of the pointing errors of several runs during the simulation."""


def collectors(runs: int, samples: int, group: int, count: int) -> list[Collector]:
    """Choose how errors are collected; the choice does not depend on the requested runs.

    Args:
        runs: Number of runs.
        samples: Number of samples of each run.
        group: Number of runs of the whole group.
        count: Number of signals, each with its own collector.
    """
    if are_sorted(group, samples, count):
        return [SortedErrors(runs, samples) for _ in range(count)]
    return [BinnedErrors(runs) for _ in range(count)]
