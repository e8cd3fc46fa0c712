"""Result of pooling the records of one wheel."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.views import content as json_view
from gyrostat.core.views import lines as text_view
from gyrostat.identification.pool.mixture import Mixture
from gyrostat.identification.pool.posterior import Posterior
from gyrostat.identification.result.stored_fit import StoredFit

INTERVAL = (0.025, 0.975)
"""Shares below the ends of an interval of 95 %."""


@dataclass(frozen=True)
class Quantity(Described):
    """Value with standard deviation and 95 % interval.

    Attributes:
        value: Median.
        sigma: Half of the width of the central 68 %.
        low: Lower end of the interval.
        high: Upper end.
    """

    value: float
    sigma: float
    low: float
    high: float

    @classmethod
    def of(cls, mixture: Mixture, size: float) -> "Quantity":
        """Quantity with a distribution relative to a size."""
        middle, low, high = (size * mixture.quantile(share) for share in (0.5, *INTERVAL))
        return cls(middle, size * mixture.sigma, low, high)


@dataclass(frozen=True)
class HeldOut(Described):
    """Prediction of each record from all others.

    Attributes:
        scores: Standard normal number of each estimate in its prediction, (n,).
        chances: P-values, adjusted for all records and parameters, (n,).
        log_scores: Law over temperature -> sum of the logarithms of the predicted densities,
            relative to the size of the parameter.
    """

    scores: Vector
    chances: Vector
    log_scores: Mapping[str, float]


@dataclass(frozen=True)
class PooledParameter(Described):
    """One parameter over the records of a wheel.

    Attributes:
        name: Name.
        unit: SI unit.
        size: Size of the parameter, SI; the posterior is relative to it.
        values: Estimates, (n,), SI.
        errors: Standard deviations of their errors that the records do not share, (n,), SI.
        shared: Standard deviation of the error that all records share, relative.
        posterior: Posterior.
        mean: Mean over records at the temperature and date of the prediction, SI.
        scatter: Standard deviation between records there, SI.
        trend: Change per year there, SI; None without dates.
        trend_known: Whether the records determine the trend.
        slope: Change per °C there, SI; None without temperatures.
        slope_known: Whether the records determine the law over temperature.
        prediction: Parameter of the wheel at the temperature and date, SI.
        record: Estimate of a further record there with errors of typical size, SI.
        pooled: Parameter in each record, from its estimate and all others.
        held_out: Prediction of each record from all others.
    """

    name: str
    unit: str
    size: float
    values: Vector
    errors: Vector
    shared: float
    posterior: Posterior
    mean: Quantity
    scatter: Quantity
    trend: Quantity | None
    trend_known: bool
    slope: Quantity | None
    slope_known: bool
    prediction: Quantity
    record: Quantity
    pooled: tuple[Quantity, ...]
    held_out: HeldOut


def _is_outside(values: Vector | None, value: float) -> bool:
    return values is not None and not values.min() <= value <= values.max()


@dataclass(frozen=True)
class Conditions(Described):
    """Temperatures and dates of the records, and of the prediction.

    Attributes:
        temperatures: Temperature of each record, (n,), °C; None if one is unknown.
        years: Date of each record, (n,), years since the first; None if one is unknown.
        temperature: Temperature of the prediction, °C; 0 if those of the records are unknown.
        year: Date of the prediction, years since the first record; 0 if dates are unknown.
    """

    temperatures: Vector | None
    years: Vector | None
    temperature: float
    year: float

    @property
    def reference(self) -> float | None:
        """Mean temperature of the records, °C."""
        return None if self.temperatures is None else float(np.mean(self.temperatures))

    @property
    def middle(self) -> float:
        """Mean date of the records, from which the posteriors count, years since the first."""
        return 0.0 if self.years is None else float(np.mean(self.years))

    @property
    def is_outside(self) -> dict[str, bool]:
        """Whether temperature and date of the prediction are outside those of the records."""
        return {
            "temperature": _is_outside(self.temperatures, self.temperature),
            "date": _is_outside(self.years, self.year),
        }


@dataclass(frozen=True)
class Pool(Pictured):
    """One model of a wheel from several records.

    Attributes:
        fits: Fit of each record, in the order of dates if all are known.
        labels: Label of each record.
        conditions: Temperatures and dates.
        parameters: Name -> parameter over the records.
        correlation: Correlation of the predicted parameters, in their order, (p, p).
        notes: Remarks on the data.
    """

    fits: tuple[StoredFit, ...]
    labels: tuple[str, ...]
    conditions: Conditions
    parameters: Mapping[str, PooledParameter]
    correlation: Matrix
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        """Table as the command line prints it."""
        return "\n".join(text_view(self))

    def to_dict(self) -> dict[str, object]:
        """Content of pool.json."""
        return json_view(self)
