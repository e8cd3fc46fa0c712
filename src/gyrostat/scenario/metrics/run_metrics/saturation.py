"""Time in which a wheel is at a limit."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from gyrostat.core.arrays import PerWheel
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import Column, Metric, RunStart
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.statistic import MEAN

FULL = 0.999
"""Fraction of a limit at which a wheel counts as saturated."""


class Saturation(Metric):
    """Time in which any wheel is at a limit.

    Attributes:
        torque_limit: Limit of each wheel, (wheels,), N·m.
        momentum_limit: Limit of each wheel, (wheels,), N·m·s.
    """

    torque_limit: PerWheel | float
    momentum_limit: PerWheel | float
    place = 60
    columns: ClassVar[Mapping[str, Column]] = {
        "saturated": Column(
            "1",
            "Fraction of time in which any wheel is at a limit of torque, momentum or driver.",
            MEAN,
        )
    }

    @classmethod
    def of(cls, run: RunStart) -> Self:
        """See `Metric.of`."""
        wheels = run.spacecraft.wheels
        return cls(wheels.torque_limit, wheels.momentum_limit)

    def signals(self, sample: Sample) -> dict[str, Any]:
        """See `Metric.signals`."""
        torque, momentum = jnp.abs(sample.command.torque), jnp.abs(sample.record.wheel_momentum)
        full = sample.record.saturated | (torque >= FULL * jnp.asarray(self.torque_limit))
        full |= momentum >= FULL * jnp.asarray(self.momentum_limit)
        return {"saturated": jnp.any(full)}
