"""Star tracker in a run: availability, longest outage, heads that are not blind."""

from typing import Any, ClassVar, Self

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import Metric, RunEnd, RunStart, results, started, updated
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.tracker_view import (
    COLUMNS,
    HEADS,
    TRACKER_PERIODS,
    TrackerView,
    viewed,
)
from gyrostat.scenario.schema import size


class Tracker(Metric):
    """View of the star tracker.

    Attributes:
        heads: Number of its heads.
        period: Control period, s.
        periods: Control periods between its samples.
    """

    heads: int = eqx.field(static=True)
    period: Scalar
    periods: Scalar
    place = 70
    columns = COLUMNS
    keys: ClassVar = {
        "least_availability": size(
            "1",
            0.9,
            "Least `tracker_availability` of a window, below which a line says so; with "
            "`[[star_tracker]]` only.",
            most=1.0,
        )
    }
    asked_by = HEADS

    @classmethod
    def of(cls, run: RunStart) -> Self:
        """See `Metric.of`."""
        return cls(run.heads, run.values["run.control_period"], run.values[TRACKER_PERIODS])

    def start(self) -> Any:
        """See `Metric.start`."""
        return TrackerView.before(self.heads), started(self.columns)

    def __call__(self, memory: Any, sample: Sample, is_last: Bool[Array, ""]) -> Any:
        """See `Metric.__call__`."""
        before, statistics = memory
        after, signals = viewed(before, sample.measurement, self.period, self.periods)
        return after, updated(self.columns, statistics, signals)

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """See `Metric.results`."""
        return results(cls.columns, memory[1], end.samples)
