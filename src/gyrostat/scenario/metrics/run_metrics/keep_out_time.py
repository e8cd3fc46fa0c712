"""Time in which instruments do not keep their angles to Sun, Earth and Moon."""

from typing import Any, ClassVar, Self

from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import Column, Metric, RunStart, updated
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.statistic import SUM
from gyrostat.scenario.scenario import KEEP_OUT
from gyrostat.spacecraft.sensors.keep_out import KeepOut


class KeepOutTime(Metric):
    """Time in which a body is too near to a boresight.

    Attributes:
        keep_outs: Instruments.
        period: Control period, s.
    """

    keep_outs: tuple[KeepOut, ...]
    period: Scalar
    place = 80
    columns: ClassVar = {
        "keep_out_time": Column(
            "s",
            "Time in which the Sun, the limb of the Earth or the Moon is nearer to the boresight "
            "of an instrument than its angle.",
            SUM,
        )
    }
    asked_by = KEEP_OUT

    @classmethod
    def of(cls, run: RunStart) -> Self:
        """See `Metric.of`."""
        return cls(run.keep_outs, run.values["run.control_period"])

    def __call__(self, memory: Any, sample: Sample, is_last: Bool[Array, ""]) -> Any:
        """See `Metric.__call__`."""
        attitude = sample.state.attitude
        near = [each.violated(attitude, sample.time) for each in self.keep_outs]
        # a sample stands for the period that follows it
        counts = jnp.any(jnp.array(near)) & jnp.logical_not(is_last)
        return updated(self.columns, memory, {"keep_out_time": jnp.where(counts, self.period, 0.0)})
