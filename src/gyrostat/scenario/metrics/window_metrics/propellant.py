"""Propellant that is used in a window."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import equinox as eqx

from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.statistic import SUM
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowSample, WindowStart


class Propellant(WindowMetric):
    """Integral of a signal of the command or of the record.

    Attributes:
        window: Name of the window.
        signal: Name of the signal.
        period: Control period, s.
    """

    window: str = eqx.field(static=True)
    signal: str = eqx.field(static=True)
    period: Scalar | float
    place = 80
    asked_by = "propellant"
    columns: ClassVar[Mapping[str, Column]] = {
        "propellant": Column("kg", "Integral of the signal `propellant`.", SUM)
    }

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """See `WindowMetric.of`."""
        return cls(window.window.name, window.window.propellant or "", window.period)

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        signals: dict[str, Any] = {**sample.run.record._asdict(), **sample.run.command._asdict()}
        if self.signal not in signals:
            raise InputError(
                f"key metrics.window[{self.window}].propellant: found {self.signal!r}, expected a "
                f"signal of the command or of the record: {', '.join(signals)}"
            )
        return memory, {"propellant": jnp.sum(signals[self.signal]) * self.period}
