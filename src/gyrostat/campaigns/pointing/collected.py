"""Values of pointing indices in runs, collected during the simulation at constant memory."""

from collections.abc import Sequence
from itertools import chain
from math import ceil, log2, pi

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.pointing.indices import (
    Inside,
    Part,
    ReproducibilityIndex,
    Vectors,
    WindowIndex,
    differences,
)
from gyrostat.campaigns.pointing.statistics import size_at
from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.metrics.percentiles import Collector, collectors
from gyrostat.scenario.requirement import Requirement

OCTAVE, UNIT = 16, 128
"""Number of sizes of an octave at which a mixed requirement counts, and place of its value."""
LARGEST = 2.0 * pi
"""Largest possible size of an index, rad: difference of two rotations."""
INSTANTS = 120
"""Number of times of a profile."""


def counted_sizes(value: float) -> Vector:
    """Sizes at which a mixed requirement counts, in required values, rising.

    They are from 1/256 to at least 4, and so large that every index is counted. All tables of runs
    begin with the same ones; older tables end at 4.

    Args:
        value: Required value, rad.
    """
    above = max(2 * OCTAVE, ceil(OCTAVE * log2(LARGEST / value)))
    return 2.0 ** (np.arange(-UNIT, above + 1) / OCTAVE)


class Profile:
    """Values at times that are spread evenly over the run.

    Args:
        runs: Number of runs.
        samples: Number of samples of a run.
    """

    def __init__(self, runs: int, samples: int):
        self._samples = instants(samples)
        self.values: Matrix = np.full((runs, len(self._samples)), np.nan)

    def add(self, part: Part) -> None:
        """Take the values at the times of the profile; infinite ones are missing."""
        places = self._samples - part.first
        is_inside = (places >= 0) & (places < part.sizes.shape[1])
        values = part.sizes[:, places[is_inside]]
        self.values[:, is_inside] = np.where(values < np.inf, values, self.values[:, is_inside])


def instants(samples: int) -> NDArray[np.int64]:
    """Indices of the samples of a profile."""
    return np.unique(np.linspace(0, samples - 1, INSTANTS).round().astype(int))


class Moments:
    """Mean and mean square of an index over the time of each run.

    Args:
        runs: Number of runs.
        parts: Number of parts of the index.
    """

    def __init__(self, runs: int, parts: int):
        self._count, self._square = np.zeros(runs), np.zeros(runs)
        self._sum: Matrix = np.zeros((runs, parts))

    def add(self, part: Part) -> None:
        """Take values of an index."""
        if part.vectors is None or part.sizes.shape[1] == 0:
            return
        is_defined = part.sizes < np.inf
        self._count += np.sum(is_defined, axis=1)
        self._square += np.sum(part.sizes**2, axis=1, where=is_defined)
        self._sum = self._sum + np.sum(part.vectors, axis=1, where=is_defined[..., None])

    def columns(self, metric: str) -> dict[str, Vector]:
        """Mean square, rad², and each part of the mean, rad, (runs,); NaN without values."""
        count = np.where(self._count > 0.0, self._count, np.nan)
        names = mean_square_name(metric), *mean_names(metric, self._sum.shape[1])
        return dict(zip(names, (self._square / count, *(self._sum.T / count)), strict=True))


def mean_square_name(metric: str) -> str:
    """Column with the mean square of the index of a requirement."""
    return f"{metric}.mean_square"


def mean_names(metric: str, parts: int) -> tuple[str, ...]:
    """Columns with the parts of the mean of the index of a requirement."""
    return tuple(f"{metric}.mean.{part}" for part in range(parts))


class Collected:
    """Values of the index of a requirement in several runs.

    Args:
        requirement: Requirement.
        runs: Number of runs.
        period: Control period, s.
        samples: Number of samples of a run.
        group: Number of runs of the whole group, see `collectors`.
        masks: Number of windows whose intervals are observation periods, 1 for the run.
        length: Number of samples of a run if more of them arrive; None for `samples`.
    """

    def __init__(
        self,
        requirement: Requirement,
        runs: int,
        period: float,
        samples: int,
        *,
        group: int,
        masks: int,
        length: int | None = None,
    ):
        self._requirement = requirement
        window, stability = (
            round(time / period) for time in (requirement.window, requirement.stability)
        )
        self._repeated = [
            ReproducibilityIndex(requirement, runs, window)
            for _ in range(masks)
            if requirement.operation == "reproducibility"
        ]
        self._windows = [
            WindowIndex(requirement, runs, window, stability)
            for _ in range(masks)
            if not self._repeated
        ]
        self.profile = Profile(runs, length or samples)
        self.moments: Moments | None = None
        self._largest = np.full(runs, -np.inf)
        self._counted = counted_sizes(requirement.value)
        self._counts = np.zeros((runs, len(self._counted) + 2))
        self._sizes: Collector | None = None
        if requirement.interpretation == "temporal":
            self._sizes = collectors(runs, masks * (samples + window), group, 1)[0]

    def add(self, vectors: Vectors, masks: Sequence[Inside]) -> None:
        """Process the next samples of all runs.

        Args:
            vectors: Error vectors, rad; samples with NaN interrupt an observation period.
            masks: Whether each sample is in an observation period, for each window.
        """
        # without a measurement there is no knowledge error
        is_measured = np.all(np.isfinite(vectors), axis=-1)
        for index, inside in zip(self._repeated or self._windows, masks, strict=True):
            self._take(index.add(vectors, inside & is_measured))

    def _take(self, part: Part) -> None:
        sizes = part.sizes
        if sizes.shape[1] == 0:
            return
        self.profile.add(part)
        if self.moments is not None:
            self.moments.add(part)
        finite = sizes < np.inf
        self._largest = np.maximum(
            self._largest, np.max(sizes, axis=1, where=finite, initial=-np.inf)
        )
        if self._requirement.interpretation == "mixed":
            # values above all sizes have the last place but one, undefined ones the last
            counted = self._counted * self._requirement.value
            places = np.searchsorted(counted, sizes)
            places = np.where(finite, places, len(counted) + 1)
            places += np.arange(len(sizes))[:, None] * (len(counted) + 2)
            self._counts += np.bincount(places.ravel(), minlength=self._counts.size).reshape(
                self._counts.shape
            )
        if self._sizes is not None:
            self._sizes.add(sizes)

    def finish(self) -> None:
        """Process the values that remain after the last sample."""
        if self._repeated:
            runs = zip(*(each.found for each in self._repeated), strict=True)
            self._take(differences([[*chain(*run_means)] for run_means in runs]))
        for index in self._windows:
            self._take(index.finish())

    def metric(self) -> Vector:
        """Metric of the requirement, (runs,); NaN for a run without values."""
        if self._requirement.interpretation == "mixed":
            below, total = self.counts()[:, [UNIT, -1]].T
            none = np.full(len(total), np.nan)
            return np.divide(total - below, total, out=none, where=total > 0.0)
        if self._sizes is not None:
            return self._sizes.percentile(round(100.0 * self._requirement.level, 10))
        return np.where(np.isfinite(self._largest), self._largest, np.nan)

    def size(self) -> Vector:
        """Size that is not exceeded at the level in each run, rad, (runs,); NaN without values.

        Temporal and mixed: in this share of the time; ensemble: at all times.
        """
        if self._requirement.interpretation != "mixed":
            return self.metric()
        counts = self.counts()
        sizes = self._counted * self._requirement.value
        with np.errstate(invalid="ignore"):
            shares = counts[:, :-1] / counts[:, -1:]
        return np.array([size_at(self._requirement.level, row, sizes) for row in shares])

    def counts(self) -> Matrix:
        """Number of values not above each of `counted_sizes`, and of all, (runs, sizes + 1)."""
        return np.cumsum(self._counts[:, :-1], axis=1)
