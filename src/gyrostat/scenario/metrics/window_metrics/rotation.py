"""Rotation about the boresight in a window."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.statistic import MAX, RMS
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowSample, WindowStart


class Rotation(WindowMetric):
    """Rotation about the boresight.

    Attributes:
        axis: Boresight, body axes, (3,).
    """

    axis: Vector3
    place = 20
    asked_by = "boresight"
    columns: ClassVar[Mapping[str, Column]] = {
        "rotation_max": Column("rad", "Largest rotation about the boresight.", MAX),
        "rotation_rms": Column("rad", "Root mean square of the rotation about the boresight.", RMS),
    }

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """See `WindowMetric.of`."""
        return cls(jnp.asarray(window.boresight))

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, dict[str, Any]]:
        """See `WindowMetric.signals`."""
        # the error is a rotation about the boresight, followed by one that tilts it
        about = 2.0 * jnp.arctan2(sample.turn[1:] @ self.axis, sample.turn[0])
        return memory, dict.fromkeys(self.columns, jnp.abs(about))
