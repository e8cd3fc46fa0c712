"""Pointing error of a run."""

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Bool, Int

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import TOLERANCE, Column, Metric, RunEnd, RunStart
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.schema import Key, size


class Errors(NamedTuple):
    """Pointing errors so far.

    Attributes:
        counted: Number of samples after `metrics.after`.
        last: Error at the last sample, rad.
        largest: Largest error after `metrics.after`, rad.
        square: Sum of squared errors after `metrics.after`, rad².
    """

    counted: Int[Array, ""]
    last: Scalar
    largest: Scalar
    square: Scalar


class PointingError(Metric):
    """Pointing error of a run.

    Attributes:
        after: Start of the evaluated interval, s.
    """

    after: Scalar
    place = 10
    columns: ClassVar[Mapping[str, Column]] = {
        "error_max": Column("rad", "Largest pointing error after `metrics.after`."),
        "error_rms": Column("rad", "Root mean square of the pointing error after `metrics.after`."),
        "error_end": Column("rad", "Pointing error at the end of the run."),
    }
    keys: ClassVar[Mapping[str, Key]] = {
        "after": size(
            "time", 0.0, "Start of the interval that error and crossing metrics evaluate."
        )
    }

    @classmethod
    def of(cls, run: RunStart) -> Self:
        """See `Metric.of`."""
        return cls(run.values["metrics.after"])

    def start(self) -> Errors:
        """See `Metric.start`."""
        zero = jnp.zeros(())
        return Errors(jnp.zeros((), dtype=int), zero, zero, zero)

    def __call__(self, memory: Errors, sample: Sample, is_last: Bool[Array, ""]) -> Errors:
        """See `Metric.__call__`."""
        counts, error = sample.time + TOLERANCE >= self.after, sample.error
        return Errors(
            memory.counted + counts,
            error,
            jnp.where(counts, jnp.maximum(memory.largest, error), memory.largest),
            memory.square + jnp.where(counts, error**2, 0.0),
        )

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """See `Metric.results`."""
        has_errors = memory.counted > 0
        mean = memory.square / np.maximum(memory.counted, 1)
        return {
            "error_max": np.where(has_errors, memory.largest, np.nan),
            "error_rms": np.where(has_errors, np.sqrt(mean), np.nan),
            "error_end": memory.last,
        }
