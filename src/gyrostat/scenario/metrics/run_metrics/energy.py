"""Mechanical work of the motors."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import Column, Metric, RunEnd
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.statistic import SUM


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
