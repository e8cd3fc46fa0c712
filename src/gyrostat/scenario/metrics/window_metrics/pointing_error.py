"""Pointing error in a window."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.statistic import LAST, MAX, RMS
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowSample


class PointingError(WindowMetric):
    """Pointing error."""

    place = 10
    columns: ClassVar[Mapping[str, Column]] = {
        "error_max": Column("rad", "Largest pointing error.", MAX),
        "error_rms": Column("rad", "Root mean square of the pointing error.", RMS),
        "error_end": Column("rad", "Pointing error at the last sample.", LAST),
    }

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        return memory, dict.fromkeys(self.columns, sample.angle)
