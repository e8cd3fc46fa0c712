"""Result of a comparison of fits: changes, trends, and spreads between wheels."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gyrostat.core.pictured import Listed, Pictured
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.views import lines
from gyrostat.identification.result.stored_fit import StoredFit

FALSE_ALARMS = 0.05
"""Largest probability of any false alarm among all tests of a comparison."""
DAY = 86400.0
OTHERS = "mean of the others"
ALL = "all parameters"


class _Tested(Listed):
    """Result of one test of a comparison."""

    chance: float

    @property
    def significant(self) -> bool:
        """Whether it is significant over all tests."""
        return self.chance <= FALSE_ALARMS


@dataclass(frozen=True)
class Change(_Tested):
    """Difference of a parameter of one fit from a reference.

    Attributes:
        parameter: Name; `ALL` for the joint test of all parameters.
        fit: Label of the fit.
        reference: Label of the reference fit, or `OTHERS`.
        difference: Difference, SI; None for the joint test.
        sigma: Standard deviation of the difference, SI; None for the joint test.
        unit: SI unit.
        chance: P-value, adjusted for the number of tests.
    """

    parameter: str
    fit: str
    reference: str
    difference: float | None
    sigma: float | None
    unit: str
    chance: float


@dataclass(frozen=True)
class Trend(_Tested):
    """Linear trend of a parameter over time.

    Attributes:
        parameter: Name.
        start: Value at the first date, SI.
        slope: Change per day, SI.
        sigma: Standard deviation of the slope, SI per day.
        covariance: Covariance of start and slope, (2, 2).
        unit: SI unit of the parameter.
        chance: P-value, adjusted for the number of tests.
    """

    parameter: str
    start: float
    slope: float
    sigma: float
    covariance: Matrix
    unit: str
    chance: float


@dataclass(frozen=True)
class BatchSpread(_Tested):
    """Spread of a parameter between the wheels of a batch.

    Attributes:
        parameter: Name.
        mean: Mean of the batch, SI.
        mean_sigma: Standard deviation of the mean, SI.
        spread: Standard deviation between wheels beyond the errors of the estimates, SI.
        low: Lower end of its 95 % confidence interval, SI.
        high: Upper end, SI.
        unit: SI unit.
        chance: P-value of equal wheels, adjusted for the number of tests.
    """

    parameter: str
    mean: float
    mean_sigma: float
    spread: float
    low: float
    high: float
    unit: str
    chance: float


@dataclass(frozen=True, repr=False)
class Comparison(Pictured):
    """Comparison of several fits.

    Attributes:
        fits: Fits, in the order of their dates if all are known.
        labels: Label of each fit.
        same_wheel: Whether they are of one wheel; otherwise of a batch.
        shared: Tolerances whose errors are common to several fits.
        changes: Differences from the first fit, or from the mean of the other wheels.
        trends: Trends over time, of one wheel.
        spreads: Spreads between wheels, of a batch.
        tests: Number of tests over which significance is judged.
        notes: Remarks on the data.
    """

    fits: tuple[StoredFit, ...]
    labels: tuple[str, ...]
    same_wheel: bool
    shared: tuple[str, ...]
    changes: tuple[Change, ...]
    trends: tuple[Trend, ...]
    spreads: tuple[BatchSpread, ...]
    tests: int
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        """Text that the command line prints."""
        return "\n".join(lines(self))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Parameters that at least two fits have, in order."""
        return common_parameters(self.fits)

    @property
    def days(self) -> Vector | None:
        """Days since the first date, (fits,); None if a date is unknown."""
        return days(self.fits)

    def to_dict(self) -> dict[str, object]:
        """Content of comparison.json."""

        def row(item: Any) -> dict[str, object]:
            entry = asdict(item) | {"significant": item.significant}
            entry.pop("covariance", None)
            return entry

        return {
            "same_wheel": self.same_wheel,
            "shared": list(self.shared),
            "tests": self.tests,
            "false_alarms": FALSE_ALARMS,
            "correction": "Holm",
            "fits": [
                {
                    "label": label,
                    "file": fit.name,
                    "model": fit.model,
                    "serial": fit.serial,
                    "date": None if fit.date is None else fit.date.isoformat(),
                    "mean_temperature": fit.temperature,
                    "parameters": {
                        name: {"value": value, "sigma": sigma, "unit": unit}
                        for name, value, sigma, unit in zip(
                            fit.names,
                            fit.values.tolist(),
                            np.sqrt(np.diag(fit.covariance)).tolist(),
                            fit.units,
                            strict=True,
                        )
                    },
                }
                for label, fit in zip(self.labels, self.fits, strict=True)
            ],
            "changes": [row(item) for item in self.changes],
            "trends": [row(item) for item in self.trends],
            "spreads": [row(item) for item in self.spreads],
            "notes": list(self.notes),
        }


def common_parameters(fits: Sequence[StoredFit]) -> tuple[str, ...]:
    """Parameters that at least two fits have, in order."""
    every = dict.fromkeys(n for fit in fits for n in fit.names)
    return tuple(n for n in every if sum(n in fit.names for fit in fits) > 1)


def days(fits: Sequence[StoredFit]) -> Vector | None:
    """Days since the first date, (fits,); None if a date is unknown."""
    dates = [fit.date for fit in fits if fit.date is not None]
    if len(dates) < len(fits):
        return None
    return np.array([(date - min(dates)).total_seconds() / DAY for date in dates])


def in_order_of_date(
    fits: Sequence[StoredFit], labels: Sequence[str]
) -> tuple[Sequence[StoredFit], Sequence[str]]:
    """Fits and their labels in the order of their dates; as they are if a date is unknown."""
    times = days(fits)
    if times is None:
        return fits, labels
    order: list[int] = np.argsort(times, kind="stable").tolist()
    return [fits[k] for k in order], [labels[k] for k in order]
