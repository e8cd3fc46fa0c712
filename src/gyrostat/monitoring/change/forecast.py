"""Forecast of the day on which the friction reaches a limit, as a distribution.

The friction torque of the windows is a local linear trend: a level and a slope, both random walks,
seen through noise of known variance. Their variances are not known: a grid of pairs is weighted by
the likelihood of the windows. From the level l and slope v of today, a Brownian motion with drift
reaches the distance g after a time whose law is the inverse Gaussian distribution,

    P(T <= t) = Phi((v t - g)/(s √t)) + exp(2 v g/s²) Phi(-(v t + g)/(s √t)),

with the walk s of the level. The walk q of the slope widens it: s² becomes s² + q² t²/3. The law is
averaged over level and slope, and over the grid.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import log_ndtr, ndtr

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector

LEVEL_WALKS = np.array([0.0, 1e-3, 4e-3])
SLOPE_WALKS = np.array([5e-5, 1e-4, 2e-4, 4e-4])
"""Random walks per square root of a day, relative to the reference torque. Smaller walks of the
slope are left out: a growth that is steadier than these cannot be told from them by daily windows,
and the intervals would be too short for one that is not (benchmarks/monitor_forecast.py)."""
SLOPE_SIGMA = np.array([0.0, 1e-3, 1e-2])
"""Standard deviations of the slope before the first window, 1/day."""
JUMP = 1e-2
"""Standard deviation of the change of the slope at an onset, 1/day."""
NODES = 9
LONGEST = 400
"""Windows that a forecast uses."""


def first_passage(time: Vector, gap: Vector, slope: Vector, variance: Vector) -> Vector:
    """Probability that a Brownian motion with drift reaches a distance within a time.

    Args:
        time: Times, above 0.
        gap: Distance; at most 0: it is reached.
        slope: Drift.
        variance: Variance of the motion per time, above 0.
    """
    root = np.sqrt(variance * time)
    direct = ndtr((slope * time - gap) / root)
    mirrored = np.exp(
        np.minimum(2.0 * slope * gap / variance + log_ndtr(-(slope * time + gap) / root), 0.0)
    )
    return np.where(gap <= 0.0, 1.0, np.minimum(direct + mirrored, 1.0))


@dataclass(frozen=True, eq=False)
class Forecast(Described):
    """Distribution of the time to a limit.

    Attributes:
        days: Days from now, increasing, (N,).
        reached: Probability that the limit is reached by then, (N,).
    """

    days: Vector
    reached: Vector

    def quantile(self, share: float) -> float:
        """Days until the limit is reached with a probability; infinite if never within `days`."""
        at = int(np.searchsorted(self.reached, share))
        if at == 0:
            return float(self.days[0])
        if at == self.days.size:
            return float("inf")
        low, high = self.reached[at - 1], self.reached[at]
        part = (share - low) / (high - low)
        return float(self.days[at - 1] + part * (self.days[at] - self.days[at - 1]))


@dataclass(eq=False)
class Trend:
    """Local linear trends of one wheel's friction, one for each point of the grid.

    Attributes:
        mean: Level and slope (1/day), (M, 2).
        covariance: (M, 2, 2).
        weight: Log of the likelihood, (M,).
        level_walk: Random walk of the level, (M,).
        slope_walk: Random walk of the slope, (M,).
        scatter: Factor of the given variances, learnt.
        count: Number of windows.
    """

    mean: Matrix = field(init=False)
    covariance: Matrix = field(init=False)
    weight: Vector = field(init=False)
    level_walk: Vector = field(init=False)
    slope_walk: Vector = field(init=False)
    scatter: float = 1.0
    count: float = 0.0

    def __post_init__(self):
        level, slope, sigma = (
            each.ravel()
            for each in np.meshgrid(LEVEL_WALKS, SLOPE_WALKS, SLOPE_SIGMA, indexing="ij")
        )
        self.level_walk, self.slope_walk = level, slope
        self.mean = np.tile([1.0, 0.0], (level.size, 1))
        self.covariance = np.zeros((level.size, 2, 2))
        self.covariance[:, 0, 0] = 1.0
        self.covariance[:, 1, 1] = sigma**2
        self.weight = np.zeros(level.size)

    def update(self, value: float, variance: float, elapsed: float = 1.0) -> None:
        """Take the friction of the next window, relative to the reference.

        Args:
            value: Friction torque; NaN: only time passes.
            variance: Its variance.
            elapsed: Days since the window before.
        """
        move = np.array([[1.0, elapsed], [0.0, 1.0]])
        self.mean = self.mean @ move.T
        self.covariance = move @ self.covariance @ move.T
        walk = self.slope_walk**2
        self.covariance[:, 0, 0] += self.level_walk**2 * elapsed + walk * elapsed**3 / 3.0
        self.covariance[:, 0, 1] += walk * elapsed**2 / 2.0
        self.covariance[:, 1, 0] += walk * elapsed**2 / 2.0
        self.covariance[:, 1, 1] += walk * elapsed
        if not np.isfinite(value):
            return
        innovation = value - self.mean[:, 0]
        spread = self.covariance[:, 0, 0] + self.scatter * variance
        # a window far off counts less
        spread = np.maximum(spread, innovation**2 / 16.0)
        self.weight += -0.5 * innovation**2 / spread - 0.5 * np.log(spread)
        gain = self.covariance[:, :, 0] / spread[:, None]
        self.mean = self.mean + gain * innovation[:, None]
        self.covariance -= gain[:, :, None] * self.covariance[:, None, 0, :]
        self._learn(innovation, spread)

    def loosen(self) -> None:
        """Let the slope change now, as at the onset of a growth."""
        self.covariance[:, 1, 1] += JUMP**2

    def _learn(self, innovation: Vector, spread: Vector) -> None:
        self.count += 1.0
        if self.count < 5.0:
            return
        ratio = float(self.shares() @ np.minimum(innovation**2 / spread, 9.0))
        self.scatter += (ratio - 1.0) * self.scatter / min(self.count + 20.0, 200.0)

    def shares(self) -> Vector:
        """Probability of each point of the grid, (M,)."""
        shares = np.exp(self.weight - np.max(self.weight))
        return shares / np.sum(shares)

    def reached(self, limit: float, days: Vector) -> Vector:
        """Probability that the friction reaches a limit within times from now, (N,).

        Args:
            limit: Limit, relative to the reference.
            days: Times, above 0 and increasing, (N,).
        """
        shares = self.shares()
        nodes, weights = np.polynomial.hermite_e.hermegauss(NODES)
        weights = weights / np.sum(weights)
        reached = np.zeros(days.size)
        for m in np.flatnonzero(shares > 1e-3 * np.max(shares)):
            values, vectors = np.linalg.eigh(self.covariance[m])
            root = vectors * np.sqrt(np.maximum(values, 0.0))
            grid = np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 2)
            points = self.mean[m] + grid @ root.T
            masses = np.outer(weights, weights).ravel()
            variance = self.level_walk[m] ** 2 + self.slope_walk[m] ** 2 * days**2 / 3.0 + 1e-12
            law = first_passage(
                days[None, :], limit - points[:, :1], points[:, 1:], variance[None, :]
            )
            reached += shares[m] * (masses @ law)
        return np.maximum.accumulate(reached / np.sum(shares))


@dataclass(frozen=True, eq=False)
class Series:
    """Friction of the windows.

    Attributes:
        value: Friction torque relative to the reference; NaN where unknown, (N,).
        variance: (N,).
        elapsed: Days since the window before, (N,).
    """

    value: Vector
    variance: Vector
    elapsed: Vector


def forecast(series: Series, onsets: Sequence[int], limit: float, days: Vector) -> Forecast:
    """Distribution of the time until the friction reaches a limit.

    Args:
        series: Friction of the windows.
        onsets: Windows in which the slope may have changed, for example quantiles of the onset of a
            change; each is one alternative. Without any, the slope only walks.
        limit: Limit, relative to the reference.
        days: Times from now, above 0 and increasing, (N,).
    """
    first = max(0, series.value.size - LONGEST)
    laws, weights = [], []
    for onset in sorted({*onsets}) or [-1]:
        trend = Trend()
        for k in range(first, series.value.size):
            if k == onset:
                trend.loosen()
            trend.update(
                float(series.value[k]), float(series.variance[k]), float(series.elapsed[k])
            )
        laws.append(trend.reached(limit, days))
        weights.append(np.logaddexp.reduce(trend.weight))
    shares = np.exp(np.array(weights) - np.max(weights))
    return Forecast(days, (shares / np.sum(shares)) @ np.array(laws))
