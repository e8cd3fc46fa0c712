"""Wheel speeds in a forbidden band during a window."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import equinox as eqx

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.statistic import MEAN
from gyrostat.scenario.metrics.window_metric import (
    WindowMetric,
    WindowSample,
    WindowStart,
    WindowTable,
    check_band,
)
from gyrostat.scenario.schema import Key, positive, size


class Dwell(WindowMetric):
    """Fraction of time in which wheel speeds are in a band, for any wheel and for each.

    Attributes:
        wheels: Names of the wheels.
        above: Lower end of the band, rad/s.
        below: Upper end of the band, rad/s.
    """

    wheels: tuple[str, ...] = eqx.field(static=True)
    above: Scalar
    below: Scalar
    place = 70
    asked_by = "dwell_below"
    keys: ClassVar[Mapping[str, Key]] = {
        "dwell_above": size(
            "speed", 0.0, "Lower end of the wheel speeds of `dwell`, of either sign."
        ),
        "dwell_below": positive("speed", None, "Upper end of the wheel speeds of `dwell`."),
    }
    columns: ClassVar[Mapping[str, Column]] = {
        "dwell": Column("1", "Fraction of time in which any wheel has a speed in the band.", MEAN)
    }

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """See `WindowMetric.of`."""
        band = window.values
        return cls(tuple(window.wheels), band["dwell_above"], band["dwell_below"])

    @classmethod
    def check(cls, window: WindowStart, length: float, table: WindowTable) -> None:
        """See `WindowMetric.check`."""
        if "dwell_above" in window.values and "dwell_below" not in window.values:
            raise table.refuse("dwell_below", None, "the upper end of the band")
        check_band(window.values, "dwell", table)

    @classmethod
    def columns_of(cls, window: WindowStart) -> Mapping[str, Column]:
        """See `WindowMetric.columns_of`."""
        each = Column("1", "Fraction of time in which the speed of this wheel is in the band.")
        return {**cls.columns, **{f"dwell.{wheel}": each for wheel in window.wheels}}

    def start(self) -> Any:
        """See `WindowMetric.start`."""
        names = ("dwell", *(f"dwell.{wheel}" for wheel in self.wheels))
        return (), dict.fromkeys(names, jnp.zeros(()))

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        speed = jnp.abs(sample.run.state.wheel_speed)
        in_band = (speed >= self.above) & (speed <= self.below)
        each = {f"dwell.{wheel}": in_band[i] for i, wheel in enumerate(self.wheels)}
        return memory, {"dwell": jnp.any(in_band), **each}
