"""Star tracker in a window: availability, longest outage, heads that are not blind."""

from typing import Any, Self

import equinox as eqx

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.metrics.tracker_view import COLUMNS, HEADS, TrackerView, viewed
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowSample, WindowStart


class Tracker(WindowMetric):
    """View of the star tracker; an outage is counted from its start in the window.

    Attributes:
        heads: Number of its heads.
        period: Control period, s.
        periods: Control periods between its samples.
    """

    heads: int = eqx.field(static=True)
    period: Scalar | float
    periods: Scalar | float
    place = 90
    columns = COLUMNS
    asked_by = HEADS

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """See `WindowMetric.of`."""
        return cls(window.heads, window.period, window.tracker_periods)

    def before(self) -> TrackerView:
        """See `WindowMetric.before`."""
        return TrackerView.before(self.heads)

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        measurement = sample.run.measurement
        return viewed(memory, measurement, self.period, self.periods, sample.inside)
