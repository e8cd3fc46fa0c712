"""Likelihood of the noise parameters of a record, from its cosine transform.

The coefficients c_k are independent and normal with the mean r d_k, where d_k are those of a line
of slope 1 and r is the rate ramp, and with the variance sum_i p_i v_ik over the kinds of noise
(`noise.coefficient_variances`), with p_i the squares of the parameters. The maximum is found by
scoring: a least-squares fit of the c_k² with weights of the last iteration, non-negative in p. The
ramp is removed by restricted likelihood (H. D. Patterson and R. Thompson, "Recovery of inter-block
information when block sizes are unequal", Biometrika 58, 1971). Intervals of a parameter hold all
values whose likelihood, maximised over the others, is above that of the chi-square quantile.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct
from scipy.optimize import brentq, nnls
from scipy.stats import chi2

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.gyro.noise import LOWEST, NAMES, coefficient_variances
from gyrostat.identification.gyro.parameters import QUANTILE

LEVEL = 0.95
"""Confidence level of all intervals."""
_BINS = 32
"""Bins per octave above the lowest frequencies."""
_ITERATIONS, _HALVINGS, _ENOUGH = 30, 20, 1e-5


class Maximum(NamedTuple):
    """Largest likelihood.

    Attributes:
        variances: Squares of the parameters in the order of `noise.NAMES`, (4,), SI units.
        likelihood: Logarithm of the restricted likelihood.
        ramp: Rate ramp, rad/s².
        ramp_variance: Its variance, (rad/s²)², for these parameters.
    """

    variances: Vector
    likelihood: float
    ramp: float
    ramp_variance: float


@dataclass(frozen=True, eq=False)
class Transformed:
    """Cosine transform of a record in bins of frequency.

    Attributes:
        basis: Mean variance of the coefficients of each bin for parameters of 1, (4, bins).
        power: Mean square of the coefficients of each bin, (bins,).
        members: Number of coefficients of each bin, (bins,); 1 in the first `LOWEST` or fewer.
        frequency: Mean frequency of each bin, (bins,), Hz.
        low: Coefficients of the lowest frequencies, without the fitted line.
        line: Those of a line of slope 1 s^-1.
        slope: Slope of the line that was removed beforehand, rad/s².
    """

    basis: Matrix
    power: Vector
    members: Vector
    frequency: Vector
    low: Vector
    line: Vector
    slope: float

    def maximise(
        self,
        held: int | None = None,
        value: float = 0.0,
        *,
        negative: bool = False,
        start: Vector | None = None,
    ) -> Maximum:
        """Maximise the likelihood over all variances, or over those that are not held.

        Args:
            held: Index of the variance that is held, or None.
            value: Its value.
            negative: Whether variances may be negative where the sum is positive.
            start: Variances to start from, (4,); None: a start from the record.
        """
        free = np.arange(len(NAMES)) != (-1 if held is None else held)
        # each kind alone explains half of the bins
        alone = np.median(self.power / self.basis, axis=1)
        for first in (alone if start is None else start, alone):
            best, response = self.at(np.where(free, first, value))
            if best.likelihood > -np.inf:
                break
        for _ in range(_ITERATIONS):
            move = self._scored(best.variances, response, free, negative) - best.variances
            for halving in range(_HALVINGS):
                trial, trial_response = self.at(best.variances + 0.5**halving * move)
                gain = trial.likelihood - best.likelihood
                if gain >= 0.0:
                    best, response = trial, trial_response
                    break
            else:
                break
            if gain < _ENOUGH:
                break
        return best

    def at(self, variances: Vector) -> tuple[Maximum, Vector]:
        """Likelihood at some variances, and the squares to which scoring fits the variances.

        Args:
            variances: Squares of the parameters in the order of `noise.NAMES`, (4,), SI units.
        """
        expected = variances @ self.basis
        if not np.all(expected > 0.0):
            return Maximum(variances, -np.inf, 0.0, 0.0), self.power
        early = expected[: self.low.size]
        weight = self.line**2 / early
        total = float(np.sum(weight))
        ramp = float(np.sum(self.line * self.low / early)) / total
        power = self.power.copy()
        power[: self.low.size] = (self.low - ramp * self.line) ** 2
        terms = self.members * (np.log(expected) + power / expected)
        likelihood = -0.5 * (float(np.sum(terms)) + np.log(total))
        power[: self.low.size] += weight / total * early
        return Maximum(variances, likelihood, ramp + self.slope, 1.0 / total), power

    def _scored(
        self, variances: Vector, response: Vector, free: NDArray[np.bool_], negative: bool
    ) -> Vector:
        """Next variances of the scoring iteration."""
        weight = np.sqrt(self.members) / (variances @ self.basis)
        columns = self.basis[free] * weight
        rest = response * weight - (variances[~free] @ self.basis[~free]) * weight
        scale = np.linalg.norm(columns, axis=1)
        following = variances.copy()
        scaled = (columns / scale[:, None]).T
        solution = np.linalg.lstsq(scaled, rest)[0] if negative else nnls(scaled, rest)[0]
        following[free] = solution / scale
        return following

    def information(self, variances: Vector) -> Matrix:
        """Fisher information of the variances, (4, 4)."""
        expected = variances @ self.basis
        return (self.basis * (0.5 * self.members / expected**2)) @ self.basis.T

    def limits(self, index: int, best: Maximum) -> tuple[float, float]:
        """Limits of one variance by the likelihood ratio; the lower one is 0 if 0 is inside.

        The other variances may be negative, because the law of the ratio is that of the chi-square
        distribution only inside of their range. 0 is also inside if it is accepted with the others
        of 0 or more.

        Args:
            index: Index of the variance in `noise.NAMES`.
            best: The maximum over variances of 0 or more; it is inside of the limits.
        """
        freest = self.maximise(negative=True, start=best.variances)
        value, middle = (max(float(each.variances[index]), 0.0) for each in (best, freest))
        if self._excess(index, middle, freest, negative=True) > 0.0:
            # the best value is negative, and no other is accepted
            return 0.0, self._upper(index, best, value, negative=False)
        low = 0.0
        if middle > 0.0 and all(
            self._excess(index, 0.0, each, negative=each is freest) > 0.0 for each in (best, freest)
        ):
            low = _root(lambda at: self._excess(index, at, freest, negative=True), 0.0, middle)
        return min(low, value), max(value, self._upper(index, freest, middle, negative=True))

    def _excess(self, index: int, value: float, top: Maximum, *, negative: bool) -> float:
        """Likelihood ratio of a value of one variance to the maximum, above the quantile."""
        trial = self.maximise(index, value, negative=negative, start=top.variances)
        return 2.0 * (top.likelihood - trial.likelihood) - float(chi2.ppf(LEVEL, 1))

    def _upper(self, index: int, top: Maximum, middle: float, *, negative: bool) -> float:
        """Upper limit of one variance, above an accepted value."""

        def excess(value: float) -> float:
            return self._excess(index, value, top, negative=negative)

        reach = middle + 3.0 / np.sqrt(self.information(top.variances)[index, index])
        while excess(reach) < 0.0:
            reach = middle + 2.0 * (reach - middle)
        return _root(excess, middle, reach)

    def ramp_half_width(self, best: Maximum) -> float:
        """Half width of the interval of the rate ramp, rad/s².

        Its variance depends on the estimated noise. It is taken one standard deviation of itself
        larger, because the normal quantile at the estimate alone covers 85 to 90 % where a random
        walk of the rate is barely visible.
        """
        early = (best.variances @ self.basis)[: self.low.size]
        slope = best.ramp_variance**2 * np.sum(
            self.line**2 / early**2 * self.basis[:, : self.low.size], axis=1
        )
        information = self.information(best.variances)
        scale = np.sqrt(np.diag(information))
        inverse = np.linalg.pinv(information / np.outer(scale, scale), rcond=1e-10)
        spread = float(np.sqrt((slope / scale) @ inverse @ (slope / scale)))
        return QUANTILE * float(np.sqrt(best.ramp_variance + spread))


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Zero of a function to 1e-5 of the upper limit."""
    result: Any = brentq(function, low, high, xtol=1e-5 * high)
    return float(result)


def _cosine_transform(values: Vector) -> Vector:
    """Coefficients 1, 2, ... of the orthonormal transform of type II, (N - 1,)."""
    result: Any = dct(values, norm="ortho")
    return result[1:]


def transformed(rate: Vector, interval: float) -> Transformed:
    """Transform a record.

    Args:
        rate: Mean rates over the intervals, (N,), rad/s.
        interval: Interval, s.
    """
    count = rate.size
    time: Vector = (np.arange(count, dtype=np.float64) - 0.5 * (count - 1.0)) * interval
    slope = float(time @ rate / (time @ time))
    centred = rate - float(np.mean(rate)) - slope * time
    coefficients = _cosine_transform(centred)
    lowest = min(LOWEST, count - 1)
    number = np.arange(1.0, count)
    bins = int(_BINS * np.log2(count / lowest)) + 2
    edges = np.concatenate([np.arange(lowest + 1.0), np.geomspace(lowest, count - 1.0, bins)])
    starts = np.unique(np.round(edges)).astype(int)
    starts = starts[starts < count - 1]
    members = np.diff(np.append(starts, count - 1)).astype(float)
    basis = coefficient_variances(count, interval)
    return Transformed(
        np.add.reduceat(basis, starts, axis=1) / members,
        np.add.reduceat(coefficients**2, starts) / members,
        members,
        np.add.reduceat(number, starts) / members / (2.0 * count * interval),
        coefficients[:lowest],
        _cosine_transform(time)[:lowest],
        slope,
    )
