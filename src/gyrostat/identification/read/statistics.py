"""Residual statistics: noise level, whiteness, serial correlation."""

import math
from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.telemetry.signals import scatter

NUMERICAL_NOISE = 1e-6
"""Smallest noise assumed for a record, relative to the level of its speed."""


FALSE_ALARMS = 0.05
"""False-alarm rate: fraction of records with white residuals in which at least one test rejects."""
FEWEST_BLOCKS = 8
"""Smallest number of blocks for a test of the scatter of their means."""


@dataclass(frozen=True)
class Whiteness(Described):
    """Tests for independence of residuals in time, at all time scales.

    Attributes:
        runs: Number of runs of one sign.
        runs_expected: Expected number of runs for independent residuals.
        runs_probability: Two-sided p-value of the number of runs (Wald and Wolfowitz 1940).
        lags: Number of lags in the Ljung-Box test.
        ljung_box: Statistic of the Ljung-Box test (Ljung and Box 1978).
        ljung_box_probability: p-value of the Ljung-Box test.
        block_lengths: Number of samples in a block, for each test of block means.
        block_probabilities: Two-sided p-value of the test of block means, for each length.
    """

    runs: int
    runs_expected: float
    runs_probability: float
    lags: int
    ljung_box: float
    ljung_box_probability: float
    block_lengths: tuple[int, ...] = ()
    block_probabilities: tuple[float, ...] = ()

    @property
    def probability(self) -> float:
        """Smallest p-value of all tests times the number of tests, at most 1 (Bonferroni)."""
        every = (self.runs_probability, self.ljung_box_probability, *self.block_probabilities)
        return min(1.0, len(every) * min(every))

    @property
    def white(self) -> bool:
        """Whether no test rejects, at the false-alarm rate `FALSE_ALARMS` of all together."""
        return self.probability >= FALSE_ALARMS

    @property
    def worst_block(self) -> tuple[int, float] | None:
        """Block length and p-value of the most significant block test; None without block tests."""
        pairs = zip(self.block_lengths, self.block_probabilities, strict=True)
        return min(pairs, key=lambda pair: pair[1], default=None)

    def to_dict(self) -> dict[str, object]:
        """Content of the key for whiteness in fit.json and validation.json."""
        return {
            "white": self.white,
            "probability": self.probability,
            "runs": self.runs,
            "runs_expected": self.runs_expected,
            "runs_probability": self.runs_probability,
            "ljung_box_probability": self.ljung_box_probability,
            "block_lengths": list(self.block_lengths),
            "block_probabilities": list(self.block_probabilities),
        }


def autocorrelation(residual: Vector, lags: int) -> Vector:
    """Autocorrelation of a residual series at lags 1 to `lags`, (lags,)."""
    centred = residual - residual.mean()
    size = 2 ** int(np.ceil(np.log2(2 * len(centred))))
    # zero padding to twice the length avoids circular correlation
    products = np.fft.irfft(np.abs(np.fft.rfft(centred, size)) ** 2, size)[: lags + 1]
    return products[1:] / products[0] if products[0] > 0.0 else np.zeros(lags)


def chi_square_tail(deviance: float, freedom: int) -> float:
    """Probability that a chi-square variable is larger (Abramowitz and Stegun, 26.4.4 and 26.4.5).

    Importing scipy.special would slow down every command.

    Args:
        deviance: Value of the variable.
        freedom: Number of degrees of freedom.
    """
    value = max(deviance, 0.0)
    if freedom % 2 == 0:
        half, term, total = 0.5 * value, 1.0, 1.0
        for k in range(1, freedom // 2):
            term *= half / k
            total += term
        return math.exp(-half) * total
    term = math.sqrt(2.0 * value / math.pi) * math.exp(-0.5 * value)
    total = math.erfc(math.sqrt(0.5 * value))
    for odd in range(3, freedom + 1, 2):
        total += term
        term *= value / odd
    return total


def block_tests(residual: Vector, fitted: Matrix | None = None) -> dict[int, float]:
    """Test the scatter of block means against that of single residuals, at all block lengths.

    For white residuals the ratio of the mean square between blocks to that within blocks has an F
    distribution. Fitted parameters remove part of the slow variation and reduce the degrees of
    freedom: those between blocks are the trace of the block projector on the residual space.

    Args:
        residual: Residuals in time order, (m,).
        fitted: Derivatives of the modelled measurements by the fitted parameters, (m, n), whitened
            like the residuals; None if no parameter was fitted.

    Returns:
        Block length in samples, a power of two -> two-sided p-value (Paulson's approximation of the
        F distribution, error below 0.003).
    """
    count = len(residual)
    basis = np.zeros((count, 0))
    if fitted is not None:
        vectors, size, _ = np.linalg.svd(fitted, full_matrices=False)
        basis = vectors[:, size > 1e-10 * size.max(initial=0.0)]
    fewest = max(FEWEST_BLOCKS, 2 * basis.shape[1] + 2)
    total, probabilities, length = float(residual @ residual), {}, 2
    while count // length >= fewest:
        blocks = count // length
        end = blocks * length
        sums = residual[:end].reshape(blocks, length).sum(axis=1)
        basis_sums = basis[:end].reshape(blocks, length, basis.shape[1]).sum(axis=1)
        between = float(sums @ sums) / length
        freedom = blocks - float(np.sum(basis_sums**2)) / length
        within_freedom = count - basis.shape[1] - freedom
        within = max(total - between, np.finfo(float).tiny)
        ratio = (between / freedom) / (within / within_freedom)
        above, below = 2.0 / (9.0 * freedom), 2.0 / (9.0 * within_freedom)
        deviation = (1.0 - below) * np.cbrt(ratio) - (1.0 - above)
        z = deviation / np.sqrt(below * np.cbrt(ratio) ** 2 + above)
        probabilities[length] = math.erfc(abs(z) / math.sqrt(2.0))
        length *= 2
    return probabilities


def whiteness(
    residual: Vector, fitted: Matrix | None = None, *, power: int | None = None
) -> Whiteness:
    """Test residuals for independence.

    Args:
        residual: Residuals in time order, (m,), m >= 3.
        fitted: Derivatives by the fitted parameters, (m, n), as for `block_tests`.
        power: Number of samples, 1 or more, whose power the tests of runs and of correlation keep
            in longer records: what so many samples do not show is ignored. None for all samples.
    """
    count = len(residual)
    share = min(1.0, power / count) if power else 1.0
    above = residual > np.median(residual)
    positive, negative = int(above.sum()), int(count - above.sum())
    runs = 1 + int(np.sum(above[1:] != above[:-1]))
    expected = 1.0 + 2.0 * positive * negative / count
    spread = (expected - 1.0) * (expected - 2.0) / max(count - 1, 1)
    z = abs(runs - expected) / np.sqrt(spread) if spread > 0.0 else 0.0
    z *= math.sqrt(share)

    lags = 2 * max(1, min(10, count // 10))
    rho = autocorrelation(residual, lags)
    statistic = count * (count + 2.0) * float(np.sum(rho**2 / (count - np.arange(1, lags + 1))))
    statistic *= share
    blocks = block_tests(residual, fitted) if float(residual @ residual) > 0.0 else {}
    return Whiteness(
        runs=runs,
        runs_expected=expected,
        runs_probability=math.erfc(z / math.sqrt(2.0)),
        lags=lags,
        ljung_box=statistic,
        ljung_box_probability=chi_square_tail(statistic, lags),
        block_lengths=tuple(blocks),
        block_probabilities=tuple(blocks.values()),
    )


def noise_level(speed: Vector) -> float:
    """Standard deviation of the noise on a smooth speed, from its second differences.

    The median of the differences makes it insensitive to steps. If a coarse quantisation makes the
    median zero, the mean square is used instead.

    Args:
        speed: Samples, (m,), rad/s.
    """
    if len(speed) < 3:
        return 0.0
    return scatter(speed) or float(np.std(np.diff(speed, 2))) / np.sqrt(6.0)


def quantum(values: Vector) -> float | None:
    """Step of a quantised signal; None if the samples are not quantised.

    Args:
        values: Samples, (m,).
    """
    levels = np.unique(values)
    if len(levels) < 3 or len(levels) > 0.2 * len(values):
        return None
    gaps = np.diff(levels)
    step = float(gaps.min())
    remainder = np.abs(gaps / step - np.round(gaps / step))
    return step if step > 0.0 and float(remainder.max()) < 0.05 else None


def crossing_times(time: Vector, speed: Vector, noise: float) -> Vector:
    """Times at which a modelled speed changes sign, by linear interpolation between samples.

    Args:
        time: Times, (N,), s.
        speed: Speeds, (N,), rad/s.
        noise: Noise of the speed, rad/s; a speed below it has no definite sign.

    Returns:
        Times, (crossings,), s.
    """
    moving = np.flatnonzero(np.abs(speed) > noise)
    before, after = moving[:-1], moving[1:]
    change = np.sign(speed[before]) != np.sign(speed[after])
    before, after = before[change], after[change]
    share = speed[before] / (speed[before] - speed[after])
    return time[before] + share * (time[after] - time[before])


def correlation_length(residual: Vector) -> int:
    """First lag with an insignificant autocorrelation; at most a quarter of the series."""
    lags = max(1, len(residual) // 4)
    rho = autocorrelation(residual, lags)
    inside = np.flatnonzero(np.abs(rho) < 2.0 / np.sqrt(len(residual)))
    return int(inside[0]) if len(inside) else lags


def serial_meat(scores: Matrix, lags: int) -> Matrix:
    """Covariance of a sum of serially correlated scores, (n, n).

    Newey and West (1987): Bartlett weights keep it positive semi-definite.

    Args:
        scores: Gradient of each sample's loss, in time order, (m, n).
        lags: Number of lags to include.
    """
    total = scores.T @ scores
    for k in range(1, lags + 1):
        cross = scores[k:].T @ scores[:-k]
        total += (1.0 - k / (lags + 1.0)) * (cross + cross.T)
    return total
