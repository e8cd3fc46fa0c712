"""Motor torques that are commanded to the wheels."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import Column, Metric
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.statistic import MAX, ROOT_OF_MEAN


class MotorTorque(Metric):
    """Commanded motor torques."""

    place = 50
    columns: ClassVar[Mapping[str, Column]] = {
        "torque_peak": Column("N·m", "Largest motor torque commanded to any wheel.", MAX),
        "torque_rms": Column(
            *("N·m", "Root mean square of the commanded motor torques of all wheels."),
            ROOT_OF_MEAN,
        ),
    }

    def signals(self, sample: Sample) -> dict[str, Any]:
        """See `Metric.signals`."""
        torque = sample.command.torque
        return {"torque_peak": jnp.max(jnp.abs(torque)), "torque_rms": jnp.mean(torque**2)}
