"""Settling time of a run."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import Column, Metric, RunEnd, RunStart
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.schema import Key, positive


class Settling(Metric):
    """Time since which a run is settled; infinite while it is not settled.

    Attributes:
        angle: Settling threshold of the pointing error, rad.
        rate: Settling threshold of the rate error, rad/s.
    """

    angle: Scalar
    rate: Scalar
    place = 20
    columns: ClassVar[Mapping[str, Column]] = {
        "settling": Column(
            "s",
            "Time after which pointing error and rate error stay settled until the end; none: "
            "never.",
        )
    }
    keys: ClassVar[Mapping[str, Key]] = {
        "settled_angle": positive(
            "angle", 0.1 * np.pi / 180.0, "Settling threshold: pointing error."
        ),
        "settled_rate": positive(
            "speed",
            0.01 * np.pi / 180.0,
            "Settling threshold: body rate relative to the reference.",
        ),
    }

    @classmethod
    def of(cls, run: RunStart) -> Self:
        """See `Metric.of`."""
        return cls(run.values["metrics.settled_angle"], run.values["metrics.settled_rate"])

    def start(self) -> Scalar:
        """See `Metric.start`."""
        return jnp.array(jnp.inf)

    def __call__(self, memory: Scalar, sample: Sample, is_last: Bool[Array, ""]) -> Scalar:
        """See `Metric.__call__`."""
        is_settled = sample.error < self.angle
        is_settled &= sample.rate_error @ sample.rate_error < self.rate**2
        return jnp.where(is_settled, jnp.minimum(memory, sample.time), jnp.inf)

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """See `Metric.results`."""
        return {"settling": np.where(np.isfinite(memory), memory, np.nan)}
