"""Residual statistics: noise level, whiteness, serial correlation."""

import math
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.telemetry.signals import scatter

NUMERICAL_NOISE = 1e-6
"""Of a modelled speed, as a share of its level: no record is taken to be more exact."""


FALSE_ALARMS = 0.05
"""Share of records with white residuals in which one of the tests rejects."""
FEWEST_BLOCKS = 8
"""Blocks from which the scatter of their means is judged."""


@dataclass(frozen=True)
class Whiteness:
    """Tests of whether residuals are independent in time, at all time scales.

    Attributes:
        runs: number of runs of one sign.
        runs_expected: for independent residuals.
        runs_probability: two-sided probability of so odd a count (Wald and Wolfowitz 1940).
        lags: lags in the second test.
        ljung_box: its statistic (Ljung and Box 1978).
        ljung_box_probability: of a statistic so large, were the residuals white.
        block_lengths: samples in a block, for each test of block means.
        block_probabilities: for each length, two-sided probability of so odd a scatter of the means
            of blocks, were the residuals white.
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
        """Smallest probability of all tests times their number (Bonferroni)."""
        every = (self.runs_probability, self.ljung_box_probability, *self.block_probabilities)
        return min(1.0, len(every) * min(every))

    @property
    def white(self) -> bool:
        """Whether no test rejects, at `FALSE_ALARMS` over all of them."""
        return self.probability >= FALSE_ALARMS

    @property
    def worst_block(self) -> tuple[int, float] | None:
        """Length and probability of the block test that deviates most; None without one."""
        pairs = zip(self.block_lengths, self.block_probabilities, strict=True)
        return min(pairs, key=lambda pair: pair[1], default=None)

    def to_dict(self) -> dict[str, object]:
        """As it stands in fit.json and validation.json."""
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
    # padded to twice the length, the circular products are those of the series itself
    products = np.fft.irfft(np.abs(np.fft.rfft(centred, size)) ** 2, size)[: lags + 1]
    return products[1:] / products[0] if products[0] > 0.0 else np.zeros(lags)


def _chi_square_exceeds(statistic: float, freedom: int) -> float:
    """Probability that a chi-square variable with an even number of freedoms is larger.

    A Poisson sum, which spares every command the import of scipy.special.
    """
    half, term, total = 0.5 * statistic, 1.0, 1.0
    for k in range(1, freedom // 2):
        term *= half / k
        total += term
    return math.exp(-half) * total


def chi_square_tail(deviance: float, freedom: int) -> float:
    """Probability that a chi-square variable is larger (Abramowitz and Stegun, 26.4.4 and 26.4.5).

    Args:
        deviance: value of the variable.
        freedom: number of its freedoms.
    """
    value = max(deviance, 0.0)
    if freedom % 2 == 0:
        return _chi_square_exceeds(value, freedom)
    term = math.sqrt(2.0 * value / math.pi) * math.exp(-0.5 * value)
    total = math.erfc(math.sqrt(0.5 * value))
    for odd in range(3, freedom + 1, 2):
        total += term
        term *= value / odd
    return total


def block_tests(residual: Vector, fitted: Matrix | None = None) -> dict[int, float]:
    """Test the scatter of block means against that of single residuals, at all block lengths.

    For white residuals the mean square of the block means and what is left of the sum of squares
    have an F ratio. Fitted parameters take away part of the slow variation: each block length has
    its own freedoms, the trace of the block projector after theirs.

    Args:
        residual: (m,) in time order.
        fitted: (m, n) derivatives of the modelled measurements by the fitted parameters, whitened
            like the residuals; None where nothing was fitted.

    Returns:
        Block length in samples, powers of two -> two-sided probability (Paulson's approximation of
        the F distribution, good to 0.003).
    """
    count = len(residual)
    basis = np.zeros((count, 0))
    if fitted is not None:
        left, size, _ = np.linalg.svd(fitted, full_matrices=False)
        basis = left[:, size > 1e-10 * size.max(initial=0.0)]
    fewest = max(FEWEST_BLOCKS, 2 * basis.shape[1] + 2)
    total, found, length = float(residual @ residual), {}, 2
    while count // length >= fewest:
        blocks = count // length
        used = blocks * length
        sums = residual[:used].reshape(blocks, length).sum(axis=1)
        taken = basis[:used].reshape(blocks, length, basis.shape[1]).sum(axis=1)
        between = float(sums @ sums) / length
        freedom = blocks - float(np.sum(taken**2)) / length
        rest = count - basis.shape[1] - freedom
        within = max(total - between, np.finfo(float).tiny)
        ratio = (between / freedom) / (within / rest)
        above, below = 2.0 / (9.0 * freedom), 2.0 / (9.0 * rest)
        deviation = (1.0 - below) * np.cbrt(ratio) - (1.0 - above)
        z = deviation / np.sqrt(below * np.cbrt(ratio) ** 2 + above)
        found[length] = math.erfc(abs(z) / math.sqrt(2.0))
        length *= 2
    return found


def whiteness(residual: Vector, fitted: Matrix | None = None) -> Whiteness:
    """Test residuals for independence.

    Args:
        residual: (m,) in time order, m >= 3.
        fitted: (m, n) derivatives by the fitted parameters, as for `block_tests`.
    """
    count = len(residual)
    above = residual > np.median(residual)
    positive, negative = int(above.sum()), int(count - above.sum())
    runs = 1 + int(np.sum(above[1:] != above[:-1]))
    expected = 1.0 + 2.0 * positive * negative / count
    spread = (expected - 1.0) * (expected - 2.0) / max(count - 1, 1)
    z = abs(runs - expected) / np.sqrt(spread) if spread > 0.0 else 0.0

    lags = 2 * max(1, min(10, count // 10))
    rho = autocorrelation(residual, lags)
    statistic = count * (count + 2.0) * float(np.sum(rho**2 / (count - np.arange(1, lags + 1))))
    blocks = block_tests(residual, fitted) if float(residual @ residual) > 0.0 else {}
    return Whiteness(
        runs=runs,
        runs_expected=expected,
        runs_probability=math.erfc(z / math.sqrt(2.0)),
        lags=lags,
        ljung_box=statistic,
        ljung_box_probability=_chi_square_exceeds(statistic, lags),
        block_lengths=tuple(blocks),
        block_probabilities=tuple(blocks.values()),
    )


def noise_level(speed: Vector) -> float:
    """Standard deviation of the noise on a smooth speed, from its second differences.

    The median makes it deaf to steps; where a coarse quantum leaves most differences at zero the
    mean square is used instead.

    Args:
        speed: (m,) samples, rad/s.
    """
    if len(speed) < 3:
        return 0.0
    return scatter(speed) or float(np.std(np.diff(speed, 2))) / np.sqrt(6.0)


def quantum(values: Vector) -> float | None:
    """Step of a quantised signal, or None where the samples are not quantised.

    Args:
        values: (m,) samples.
    """
    levels = np.unique(values)
    if len(levels) < 3 or len(levels) > 0.2 * len(values):
        return None
    gaps = np.diff(levels)
    step = float(gaps.min())
    whole = np.abs(gaps / step - np.round(gaps / step))
    return step if step > 0.0 and float(whole.max()) < 0.05 else None


def crossing_times(time: Vector, speed: Vector, noise: float) -> Vector:
    """Times at which a modelled speed changes sign, by straight lines between samples.

    Args:
        time: (N,) s.
        speed: (N,) rad/s.
        noise: rad/s; a speed below it is not taken for motion in either sense.

    Returns:
        The times, s.
    """
    moving = np.flatnonzero(np.abs(speed) > noise)
    before, after = moving[:-1], moving[1:]
    change = np.sign(speed[before]) != np.sign(speed[after])
    before, after = before[change], after[change]
    share = speed[before] / (speed[before] - speed[after])
    return time[before] + share * (time[after] - time[before])


def correlation_length(residual: Vector) -> int:
    """Lags after which the autocorrelation is within its noise, at most a quarter of the series."""
    lags = max(1, len(residual) // 4)
    rho = autocorrelation(residual, lags)
    inside = np.flatnonzero(np.abs(rho) < 2.0 / np.sqrt(len(residual)))
    return int(inside[0]) if len(inside) else lags


def serial_meat(scores: Matrix, lags: int) -> Matrix:
    """Covariance of a sum of serially correlated scores, (n, n).

    Newey and West (1987): Bartlett weights keep it positive semi-definite.

    Args:
        scores: (m, n) gradient of each sample's loss, in time order.
        lags: lags to take in.
    """
    total = scores.T @ scores
    for k in range(1, lags + 1):
        cross = scores[k:].T @ scores[:-k]
        total += (1.0 - k / (lags + 1.0)) * (cross + cross.T)
    return total
