"""A lot over the dates of production: trend of each parameter, and control charts.

The charts are of the standard normal numbers of the estimates in their lot: about 0 with a standard
deviation of 1, whatever the shape of the lot and the errors of the fits. Shewhart chart: a number
beyond 3 (one false signal in 370 wheels). CUSUM: sums of the excess over 0.5 of either sense beyond
5 (one false signal in 465 wheels; D. C. Montgomery, Introduction to Statistical Quality Control).
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.identification.judge.fit_changes import FALSE_ALARMS
from gyrostat.identification.judge.spread import line

SHEWHART_LIMIT = 3.0
CUSUM_SLACK, CUSUM_LIMIT = 0.5, 5.0
YEAR = 365.25
"""Days of a year."""
FEWEST_DATES = 3


@dataclass(frozen=True)
class ControlChart(Described):
    """Control chart of one parameter, in the order of production.

    Attributes:
        scores: Standard normal number of each estimate, (n,).
        above: Sums of excess above the lot, (n,).
        below: Sums of excess below the lot, (n,).
        beyond: Indices of wheels beyond the Shewhart limits.
        shifts: Indices of wheels at which a sum passes its limit.
    """

    scores: Vector
    above: Vector
    below: Vector
    beyond: tuple[int, ...]
    shifts: tuple[int, ...]


@dataclass(frozen=True)
class Drift(Described):
    """Straight line through a parameter over the date of production.

    Attributes:
        slope: Change per year, SI.
        sigma: Standard deviation of the slope, with the spread between the wheels.
        chance: P-value of no change; in the result, adjusted for the number of parameters.
    """

    slope: float
    sigma: float
    chance: float

    @property
    def significant(self) -> bool:
        """Whether there is a change."""
        return self.chance <= FALSE_ALARMS


def control_chart(scores: Vector) -> ControlChart:
    """Shewhart chart and CUSUM of standard normal numbers in the order of production, (n,).

    After a signal the sums start again at zero.
    """
    sums, shifts, last = np.zeros((2, len(scores))), [], np.zeros(2)
    for k, score in enumerate(scores):
        last = np.maximum(last + np.array([score, -score]) - CUSUM_SLACK, 0.0)
        sums[:, k] = last
        if last.max() > CUSUM_LIMIT:
            shifts.append(k)
            last = np.zeros(2)
    beyond = np.flatnonzero(np.abs(scores) > SHEWHART_LIMIT).tolist()
    return ControlChart(scores, sums[0], sums[1], tuple(beyond), tuple(shifts))


def drift(days: Vector, values: Vector, errors: Vector, spread: float) -> Drift | None:
    """Trend of a parameter; None if there are fewer than three dates.

    Args:
        days: Dates of production, (n,), days.
        values: Estimates, (n,).
        errors: Standard deviations of their errors, (n,).
        spread: Standard deviation between the wheels.
    """
    if len(np.unique(days)) < FEWEST_DATES:
        return None
    trend = line((days - days.mean()) / YEAR, values, np.diag(errors**2 + spread**2))
    return Drift(trend.slope, float(np.sqrt(trend.covariance[1, 1])), trend.chance)
