"""Jitter in a window."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.band_filter import Sections, at_rest, filtered, high_pass, low_pass
from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.statistic import RMS
from gyrostat.scenario.metrics.window_metric import (
    WindowMetric,
    WindowSample,
    WindowStart,
    WindowTable,
    check_band,
)
from gyrostat.scenario.schema import Key, positive


class Jitter(WindowMetric):
    """Pointing error in a band of frequencies.

    Attributes:
        sections: Sections of the filter.
    """

    sections: Sections
    place = 60
    asked_by = "jitter_above"
    keys: ClassVar[Mapping[str, Key]] = {
        "jitter_above": positive("frequency", None, "Lower cut-off frequency of `jitter`."),
        "jitter_below": positive("frequency", None, "Upper cut-off frequency of `jitter`."),
    }
    columns: ClassVar[Mapping[str, Column]] = {
        "jitter": Column(
            "rad",
            "Root mean square of the pointing error above `jitter_above` and below `jitter_below`.",
            RMS,
        )
    }

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """See `WindowMetric.of`."""
        sections = high_pass(window.values["jitter_above"], window.period)
        if "jitter_below" in window.values:
            sections += low_pass(window.values["jitter_below"], window.period)
        return cls(sections)

    @classmethod
    def check(cls, window: WindowStart, length: float, table: WindowTable) -> None:
        """See `WindowMetric.check`."""
        nyquist = 0.5 / window.period
        for end in cls.keys:
            if window.values.get(end, 0.0) >= nyquist:
                expected = f"below {nyquist:g} Hz, half of the sample frequency"
                raise table.refuse(end, window.values[end], expected)
        if "jitter_below" in window.values and "jitter_above" not in window.values:
            raise table.refuse("jitter_above", None, "the lower end of the band")
        check_band(window.values, "jitter", table)

    def before(self) -> Any:
        """See `WindowMetric.before`."""
        return at_rest(self.sections, jnp.zeros(3))

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        # the first sample starts the filter without a step
        memory = jnp.where(sample.first, at_rest(self.sections, sample.line), memory)
        memory, output = filtered(self.sections, memory, sample.line)
        return memory, {"jitter": jnp.sqrt(output @ output)}
