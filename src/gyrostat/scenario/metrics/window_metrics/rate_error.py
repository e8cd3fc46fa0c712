"""Rate error in a window."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.statistic import MAX, RMS
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowSample


class RateError(WindowMetric):
    """Body rate relative to the reference."""

    place = 30
    columns: ClassVar[Mapping[str, Column]] = {
        "rate_error_max": Column("rad/s", "Largest body rate relative to the reference.", MAX),
        "rate_error_rms": Column(
            "rad/s", "Root mean square of the body rate relative to the reference.", RMS
        ),
    }

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        return memory, dict.fromkeys(self.columns, sample.rate)
