"""Mean, scatter and largest of repeated values, and size of a value, each with its sigma."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2, kstatvar, norm, t

from gyrostat.core.types import Vector
from gyrostat.identification.judge.acceptance_lines import CONFIDENCE

LEAST_VARIANCE = 0.1
"""Smallest variance of a sample variance, over that of normal values."""
LEAST_CUMULANT, MOST_CUMULANT = -2.0, 6.0
"""Fourth cumulant over the squared variance: of two values, and of an exponential law."""
DRAWS = 4096
"""Number of normal errors of the bootstrap; its error is 2 % of sigma."""
QUANTILES = norm.ppf((np.arange(400) + 0.5) / 400.0)
"""Normal quantiles over which expectations are taken, (400,)."""


class Estimate(NamedTuple):
    """Value from repetitions.

    Attributes:
        value: Value.
        sigma: Its standard deviation.
        guard: Standard deviation of a normal error with the same one-sided 95 % bound: larger than
            sigma if repetitions are few.
    """

    value: float
    sigma: float
    guard: float

    def times(self, factor: float) -> "Estimate":
        """Multiple of the value, by a positive factor."""
        return Estimate(*(factor * each for each in self))

    def widened(self, sigma: float) -> "Estimate":
        """The value with another, independent error."""
        return Estimate(
            self.value, float(np.hypot(self.sigma, sigma)), float(np.hypot(self.guard, sigma))
        )


def student(freedom: int) -> float:
    """One-sided 95 % point of Student's t over that of the normal law."""
    return float(t.ppf(CONFIDENCE, freedom) / norm.ppf(CONFIDENCE))


def mean_of(values: Vector) -> Estimate:
    """Mean of repetitions, (n,); Student's t bounds it."""
    count = len(values)
    sigma = float(np.std(values, ddof=1) / np.sqrt(count))
    return Estimate(float(np.mean(values)), sigma, student(count - 1) * sigma)


def scatter_of(values: Vector, noise: float = 0.0, fitted: int = 1) -> Estimate:
    """Standard deviation of repetitions without their noise.

    The sample variance S has the unbiased variance of k-statistics (Kendall and Stuart, section
    12.16), which also holds for values that are not normal. The sigma is that of the root of the
    positive part of S - noise²; the guard has the upper 95 % bound of the chi-square law.

    Args:
        values: Repetitions, (n,), n >= 4.
        noise: Standard deviation of the error of each.
        fitted: Number of parameters that were fitted to them, the mean included.
    """
    count, freedom = len(values), len(values) - fitted
    total = float(np.sum((values - values.mean()) ** 2)) / freedom
    excess = max(total - noise**2, 0.0)
    value = float(np.sqrt(excess))
    # over their size: values of 1e-5 to the fourth power are tiny
    size = np.sqrt(total) or 1.0
    normal, found = 2.0 / freedom, float(kstatvar(values / size, 2))
    # the noise is normal: only what exceeds it has a fourth cumulant, of which the least is -2
    part = (excess / total) ** 2 / count if total else 0.0
    variance = normal + np.clip(found - normal, LEAST_CUMULANT * part, MOST_CUMULANT * part)
    variance = max(variance, LEAST_VARIANCE * normal)
    squares = np.maximum(excess + total * np.sqrt(variance) * QUANTILES, 0.0)
    sigma = float(np.std(np.sqrt(squares)))
    upper = total * freedom / chi2.ppf(1.0 - CONFIDENCE, freedom)
    bound = np.sqrt(max(upper - noise**2, 0.0))
    return Estimate(value, sigma, float((bound - value) / norm.ppf(CONFIDENCE)))


def size_of(value: float, sigma: float, guard: float) -> Estimate:
    """Absolute value of an estimate with a normal error.

    Near zero it scatters less than the estimate itself (folded normal law).

    Args:
        value: Estimate.
        sigma: Its standard deviation.
        guard: That for its bound.
    """
    middle = np.sqrt(max(value**2 - sigma**2, 0.0))
    folded = float(np.std(np.abs(middle + sigma * QUANTILES)))
    return Estimate(abs(value), folded, guard)


def largest_of(values: Vector, sigma: Vector, groups: Sequence[object]) -> Estimate:
    """Largest of several quantities that are measured with normal errors, without the bias of it.

    The largest of n values exceeds the largest truth: of four equal ones by 1.03 sigma. Therefore
    the truth is a mean, plus an effect of the group, plus one of each repetition; both effects are
    normal, with the variance by which their scatter exceeds the errors (empirical Bayes, James and
    Stein 1961). The estimate is mean and standard deviation of the largest truth. Its guard
    has the bound that holds without such a model: the largest of the bounds of all values.

    Args:
        values: Measured values, (n,).
        sigma: Standard deviations of their independent errors, (n,).
        groups: Group of each value, such as repetitions at one temperature; equally many in each.
    """
    labels = list(dict.fromkeys(groups))
    index = np.array([labels.index(each) for each in groups])
    count, size = len(values), len(values) // len(labels)
    error = float(np.mean(sigma**2))
    means = np.bincount(index, values) / np.bincount(index)
    within, between = values - means[index], means - means.mean()
    kept, kept_group = (
        _kept(within, error, count - len(labels)),
        _kept(between, error / size, len(labels) - 1),
    )
    random = np.random.default_rng(0)
    draws = random.standard_normal((DRAWS, 1 + len(labels) + count))
    group = kept_group * between + np.sqrt(kept_group * error / size) * draws[:, 1:-count]
    own = kept * within + np.sqrt(kept * error) * draws[:, -count:]
    truth = values.mean() + np.sqrt(error / count) * draws[:, :1] + group[:, index] + own
    largest = np.max(truth, axis=1)
    value, spread = float(largest.mean()), float(np.std(largest))
    bound = float(np.max(values + norm.ppf(CONFIDENCE) * sigma))
    return Estimate(value, spread, max(spread, (bound - value) / float(norm.ppf(CONFIDENCE))))


def _kept(deviations: Vector, variance: float, freedom: int) -> float:
    """Part of the variance of deviations from a mean that is no error, 0 to 1."""
    total = float(deviations @ deviations)
    if freedom < 1 or total == 0.0:
        return 0.0
    return max(1.0 - variance * freedom / total, 0.0)
