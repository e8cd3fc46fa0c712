"""Smear in a window."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import MOST_PERIODS
from gyrostat.scenario.metrics.exposures import Exposures, exposed, no_exposures
from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.statistic import MAX
from gyrostat.scenario.metrics.window_metric import (
    WindowMetric,
    WindowSample,
    WindowStart,
    WindowTable,
)
from gyrostat.scenario.schema import Key, positive


class Smear(WindowMetric):
    """Largest rotation of the boresight within an exposure.

    Attributes:
        periods: Exposure time in control periods, a whole number.
    """

    periods: Scalar
    place = 50
    asked_by = "exposure"
    keys: ClassVar[Mapping[str, Key]] = {
        "exposure": positive(
            "time", None, "Exposure time of `smear`; a whole number of control periods."
        )
    }
    columns: ClassVar[Mapping[str, Column]] = {
        "smear": Column(
            "rad",
            "Largest rotation of the boresight, relative to the reference, within an exposure; "
            "none: the window is shorter.",
            MAX,
        )
    }

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """See `WindowMetric.of`."""
        return cls(jnp.round(window.values["exposure"] / window.period))

    @classmethod
    def check(cls, window: WindowStart, length: float, table: WindowTable) -> None:
        """See `WindowMetric.check`."""
        exposure = window.values.get("exposure")
        if exposure is None:
            return
        if exposure > length:
            expected = f"at most the length of the window, {length:g} s"
            raise table.refuse("exposure", exposure, expected)
        period = float(window.period)
        table.multiple("exposure", exposure, "control period", period, MOST_PERIODS)
        if window.boresight is None:
            raise table.refuse("boresight", None, "the direction that is exposed, [x, y, z]")

    def before(self) -> Exposures:
        """See `WindowMetric.before`."""
        return no_exposures()

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        memory, angle = exposed(memory, sample.line, sample.inside, self.periods)
        return memory, {"smear": angle}
