"""Result of the analysis of a lot of wheels."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.types import Vector
from gyrostat.core.views import content as json_view
from gyrostat.identification.lot.best_set import BestSet
from gyrostat.identification.lot.correlation import Correlation
from gyrostat.identification.lot.limits import Limits
from gyrostat.identification.lot.outliers import Suspect
from gyrostat.identification.lot.over_dates import ControlChart, Drift
from gyrostat.identification.lot.posterior import LotDraws
from gyrostat.identification.result.stored_fit import StoredFit

INTERVAL = (0.025, 0.975)
"""Shares below the ends of an interval of 95 %."""


@dataclass(frozen=True)
class Interval(Described):
    """Typical value and 95 % interval of a quantity."""

    value: float
    low: float
    high: float


def interval(draws: LotDraws, values: Vector) -> Interval:
    """Median and 95 % interval of a function of the draws, of which `values` are the values."""
    low, high = (draws.quantile(values, share) for share in INTERVAL)
    return Interval(draws.quantile(values, 0.5), low, high)


@dataclass(frozen=True)
class LotParameter(Described):
    """Distribution of one parameter over the wheels of a lot.

    Attributes:
        name: Name.
        unit: SI unit.
        values: Estimates, (n,), SI.
        errors: Standard deviations of their errors, (n,), SI.
        common_error: Standard deviation of the error that all estimates share, SI.
        draws: Draws of the lot.
        median: Median of the wheels, SI.
        sigma: Standard deviation of the wheels, without the errors of the fits, SI, for the medians
            of scale and shape; and its 95 % interval.
        shape: Shape of the lot; see `gyrostat.core.skewed_normal`.
        limits: Tolerance limits.
        chart: Control chart.
        drift: Trend over the date of production; None without dates.
        outliers: Wheels that do not belong to the lot.
    """

    name: str
    unit: str
    values: Vector
    errors: Vector
    common_error: float
    draws: LotDraws
    median: Interval
    sigma: Interval
    shape: Interval
    limits: Limits
    chart: ControlChart
    drift: Drift | None
    outliers: tuple[Suspect, ...]

    @property
    def sigma_estimates(self) -> float:
        """Standard deviation of the estimates, errors of the fits included, SI."""
        return float(np.std(self.values, ddof=1))

    @property
    def sigma_errors(self) -> float:
        """Root mean square of the standard deviations of the errors, SI."""
        return float(np.sqrt(np.mean(self.errors**2)))


@dataclass(frozen=True)
class Lot(Pictured):
    """Analysis of a lot of wheels.

    Attributes:
        fits: Fits in the order of production, or of their labels without dates.
        labels: Serial number of each wheel, or the folder of its fit.
        days: Days since the first date, (n,); None if a date is unknown.
        parameters: Name -> distribution.
        correlation: Correlation between the parameters.
        best: Best set of wheels.
        shape: Shape that the analysis was told: "unknown", "normal" or "log-normal".
        content: Share of the wheels that tolerance limits contain.
        confidence: Probability that they do.
        factors: Classical factors of a one-sided limit and of an interval.
        notes: Remarks on the data.
    """

    fits: tuple[StoredFit, ...]
    labels: tuple[str, ...]
    days: Vector | None
    parameters: Mapping[str, LotParameter]
    correlation: Correlation
    best: BestSet
    shape: str
    content: float
    confidence: float
    factors: tuple[float, float]
    notes: tuple[str, ...]

    @property
    def outliers(self) -> tuple[tuple[str, str, float], ...]:
        """Label, parameter and chance of each outlier."""
        return tuple(
            (self.labels[suspect.wheel], name, suspect.chance)
            for name, parameter in self.parameters.items()
            for suspect in parameter.outliers
        )

    def to_dict(self) -> dict[str, object]:
        """Content of lot.json."""
        return json_view(self)
