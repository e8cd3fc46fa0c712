r"""Pointing error indices of ECSS-E-ST-60-10C, section 3.2, of errors that arrive in parts.

With the error vector $e(t)$, a window $\Delta t$ and the mean $\bar e(t)$ over $[t - \Delta t, t]$:

    APE, AKE   e(t)
    MPE, MKE   mean(t)
    RPE, RKE   end:     e(t) - mean(t)
               centre:  e(t - window / 2) - mean(t)
               any:     e(s) - mean(t) of all s in the window, for consecutive windows
    PDE        mean(t) - mean(t - stability), both windows in one observation period
    PRE        difference of the means over the first window of two observation periods, all pairs

The standard leaves open where the time lies in the window of RPE. "any" has the variance that the
windowed variance of ESSB-HB-E-003 gives. Means are integrals by the trapezoidal rule: exact for an
error that is linear between samples. A window lies within one observation period as a whole.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import NDArray

from gyrostat.campaigns.pointing.recent import Recent
from gyrostat.core.types import Matrix
from gyrostat.scenario.requirement import AXES_OF_ERROR, Requirement

Vectors = Float[np.ndarray, "runs samples 3"]
Inside = Bool[np.ndarray, "runs samples"]


class Part(NamedTuple):
    """Values of an index that belong to consecutive samples.

    Attributes:
        first: Index of the first sample; negative before the run.
        sizes: Sizes of the index, rad, (runs, samples); infinite where it is not defined.
        vectors: The index itself, rad, (runs, samples, parts), of any value where it is not
            defined; None for a part that has sizes only.
    """

    first: int
    sizes: Matrix
    vectors: NDArray[np.float64] | None = None


def component(
    requirement: Requirement, vectors: Vectors
) -> Float[np.ndarray, "runs samples parts"]:
    """Part of error vectors whose length is compared with the requirement."""
    if requirement.axis in AXES_OF_ERROR[:3]:
        index = AXES_OF_ERROR.index(requirement.axis)
        return vectors[..., index : index + 1]
    if requirement.boresight is None:
        return vectors
    axis = np.array(requirement.boresight)
    about = vectors @ axis[:, None]
    return about if requirement.axis == "about" else vectors - about * axis


def parts_of(requirement: Requirement) -> int:
    """Number of parts of the index of a requirement: 1 or 3."""
    return component(requirement, np.zeros((1, 1, 3))).shape[-1]


class WindowIndex:
    """Index other than PRE of several runs, computed while they are simulated.

    Args:
        requirement: Requirement.
        runs: Number of runs.
        window: Window time in samples; 0 for APE and AKE.
        stability: Stability time in samples.
    """

    def __init__(self, requirement: Requirement, runs: int, window: int, stability: int = 0):
        self._requirement, self._window, self._stability = requirement, window, stability
        self._operation, self._instant = requirement.operation, requirement.instant
        size = parts_of(requirement)
        self._means = _Means(runs, size, window, 2 * window + stability)
        self._runs, self._next = runs, 0
        is_late = self._operation == "relative" and self._instant == "any"
        self._delay = window if is_late else 0

    def add(self, vectors: Vectors, inside: Inside) -> Part:
        """Process the next samples.

        Args:
            vectors: Error vectors, rad; of any value outside.
            inside: Whether a sample is in an observation period.
        """
        self._means.add(component(self._requirement, vectors), inside)
        count, window = inside.shape[1], self._window
        first, self._next = self._next, self._next + count
        if self._delay:
            return _part(first - window, *self._within(count))
        value, age = self._means.mean(0, count), self._means.age(0, count)
        least = window
        if self._operation == "absolute":
            value = self._means.error(0, count)
        elif self._operation == "drift":
            value = value - self._means.mean(self._stability, count)
            least = window + self._stability
        elif self._operation == "relative":
            back = window // 2 if self._instant == "centre" else 0
            value = self._means.error(back, count) - value
        return _part(first, value, age >= least)

    def finish(self) -> Part:
        """Return the values that remain after the last sample."""
        shape = (self._runs, self._delay)
        return self.add(np.zeros((*shape, 3)), np.zeros(shape, bool))

    def _within(self, count: int) -> tuple[NDArray[np.float64], Inside]:
        """Errors relative to the mean over the consecutive window with them, a window later.

        Returns:
            The errors, and whether their window is complete.
        """
        means, window = self._means, self._window
        age = means.age(window, count)
        # samples from each one to the end of its window
        ahead = np.where(age == 0, window, (-age) % window).astype(int)
        ends = np.arange(count) + ahead
        span = count + window
        rows = np.arange(len(age))[:, None]
        value = means.error(window, count) - means.mean(0, span)[rows, ends]
        return value, (age >= 0) & (means.age(0, span)[rows, ends] == age + ahead)


class ReproducibilityIndex:
    """Means of the first window of each observation period, whose `differences` are the PRE.

    Args:
        requirement: Requirement.
        runs: Number of runs.
        window: Window time in samples.
    """

    def __init__(self, requirement: Requirement, runs: int, window: int):
        self._requirement, self._window = requirement, window
        size = parts_of(requirement)
        self._means = _Means(runs, size, window, window)
        self.found: list[list[NDArray[np.float64]]] = [[] for _ in range(runs)]

    def add(self, vectors: Vectors, inside: Inside) -> Part:
        """Process the next samples; see `WindowIndex`. There are no values before the end."""
        count = inside.shape[1]
        self._means.add(component(self._requirement, vectors), inside)
        ends = self._means.age(0, count) == self._window
        means = self._means.mean(0, count)
        for run, sample in np.argwhere(ends):
            self.found[run].append(means[run, sample])
        return Part(0, np.zeros((len(self.found), 0)))


def differences(means: list[list[NDArray[np.float64]]]) -> Part:
    """Sizes of the differences of all pairs of means of each run."""
    pairs = [[b - a for a, b in combinations(each, 2)] for each in means]
    parts = max((len(mean) for each in means for mean in each), default=1)
    vectors = np.full((len(pairs), max(map(len, pairs)), parts), np.inf)
    for row, row_pairs in zip(vectors, pairs, strict=True):
        if row_pairs:
            row[: len(row_pairs)] = row_pairs
    return _part(0, vectors, np.isfinite(vectors[..., 0]))


def _part(first: int, vectors: NDArray[np.float64], is_defined: Inside) -> Part:
    return Part(first, np.where(is_defined, _length(vectors), np.inf), vectors)


def _length(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sqrt(np.sum(vectors**2, axis=-1))


class _Means:
    """Errors of the last samples, their means over windows, and places in observation periods."""

    def __init__(self, runs: int, size: int, window: int, length: int):
        self._size, self._window = size, window
        # error, its integral in samples, and place in the observation period
        self._recent = Recent(runs, length + 1, 2 * size + 1)
        self._recent.add(np.concatenate([np.zeros((runs, 1, 2 * size)), -np.ones((runs, 1, 1))], 2))

    def add(self, errors: Float[np.ndarray, "runs samples parts"], inside: Inside) -> None:
        errors = np.where(inside[..., None], errors, 0.0)
        last, size = self._recent.back(0, 1), self._size
        before = np.concatenate([last[..., :size], errors[:, :-1]], axis=1)[:, : inside.shape[1]]
        integral = last[..., size:-1] + np.cumsum(0.5 * (before + errors), axis=1)
        number = np.arange(1.0, inside.shape[1] + 1.0)
        # number of the last sample outside; before this part it was the sample at place -1
        outside = np.where(inside, -last[..., -1] - 1.0, number)
        age = number - np.maximum.accumulate(outside, axis=1) - 1.0
        self._recent.add(np.concatenate([errors, integral, age[..., None]], axis=2))

    def error(self, back: int, count: int) -> NDArray[np.float64]:
        return self._recent.back(back, count)[..., : self._size]

    def mean(self, back: int, count: int) -> NDArray[np.float64]:
        """Means over the windows that end with these samples."""
        if self._window == 0:
            return self.error(back, count)
        now, then = (self._recent.back(k, count) for k in (back, back + self._window))
        return (now - then)[..., self._size : -1] / self._window

    def age(self, back: int, count: int) -> NDArray[np.float64]:
        """Number of samples since the start of the observation period; -1 outside."""
        return self._recent.back(back, count)[..., -1]
