"""Mechanical work of the motors."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.campaigns.metrics.metric import Column, Metric, RunEnd
from gyrostat.campaigns.metrics.sample import Sample
from gyrostat.campaigns.metrics.statistic import SUM
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector


class Energy(Metric):
    """Mechanical work by the rectangle rule."""

    place = 70
    columns: ClassVar[Mapping[str, Column]] = {
        "energy": Column(
            "J", "Mechanical work of the commanded torques; braking counts as positive.", SUM
        )
    }

    def signals(self, sample: Sample) -> dict[str, Any]:
        """See `Metric.signals`."""
        return {"energy": jnp.sum(jnp.abs(sample.command.torque * sample.state.wheel_speed))}

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """See `Metric.results`."""
        return {"energy": memory["energy"] * end.period}
