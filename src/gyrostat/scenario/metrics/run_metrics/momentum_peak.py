"""Largest momentum of a wheel."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import Column, Metric
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.statistic import MAX


class MomentumPeak(Metric):
    """Largest momentum of any wheel."""

    place = 40
    columns: ClassVar[Mapping[str, Column]] = {
        "momentum_peak": Column("N·m·s", "Largest momentum of any wheel.", MAX)
    }

    def signals(self, sample: Sample) -> dict[str, Any]:
        """See `Metric.signals`."""
        return {"momentum_peak": jnp.max(jnp.abs(sample.record.wheel_momentum))}
