"""Zero crossings of the wheels of a run."""

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Bool, Float, Int

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import TOLERANCE, Column, Metric, RunEnd, RunStart
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.schema import Key, positive


class Crossings(NamedTuple):
    """Zero crossings so far.

    Attributes:
        sense: Sense of rotation of the wheels at the last sample, (wheels,).
        time: Time of the last zero crossing of a wheel, s.
        number: Number of zero crossings.
        peak: Largest pointing error within the window after a crossing, rad.
    """

    sense: Float[Array, " wheels"]
    time: Scalar
    number: Int[Array, ""]
    peak: Scalar


class ZeroCrossings(Metric):
    """Zero crossings of the wheels, and the pointing error after them.

    Attributes:
        after: Start of the evaluated interval, s.
        window: Time after a crossing in which the error is evaluated, s.
        sense: Sense of rotation of the wheels at the start, (wheels,).
    """

    after: Scalar
    window: Scalar
    sense: Float[Array, " wheels"]
    place = 30
    columns: ClassVar[Mapping[str, Column]] = {
        "crossings": Column(
            "1", "Number of times that a wheel reaches zero speed after `metrics.after`."
        ),
        "crossing_peak": Column(
            "rad",
            "Largest pointing error within `metrics.crossing_window` after a zero crossing; none: "
            "no crossing.",
        ),
    }
    keys: ClassVar[Mapping[str, Key]] = {
        "crossing_window": positive(
            "time", 10.0, "Time after a zero crossing in which `crossing_peak` is evaluated."
        )
    }

    @classmethod
    def of(cls, run: RunStart) -> Self:
        """See `Metric.of`."""
        keys = ("metrics.after", "metrics.crossing_window")
        after, window = (run.values[key] for key in keys)
        return cls(after, window, jnp.sign(run.state.wheel_speed))

    def start(self) -> Crossings:
        """See `Metric.start`."""
        return Crossings(self.sense, jnp.array(-jnp.inf), jnp.zeros((), dtype=int), jnp.zeros(()))

    def __call__(self, memory: Crossings, sample: Sample, is_last: Bool[Array, ""]) -> Crossings:
        """See `Metric.__call__`."""
        time, error = sample.time, sample.error
        counts = time + TOLERANCE >= self.after
        sense = jnp.sign(sample.state.wheel_speed)
        crossings = jnp.sum(counts & (sense != memory.sense) & (memory.sense != 0.0))
        crossing_time = jnp.where(crossings > 0, time, memory.time)
        near = counts & (time - crossing_time <= self.window + TOLERANCE)
        peak = jnp.where(near, jnp.maximum(memory.peak, error), memory.peak)
        return Crossings(sense, crossing_time, memory.number + crossings, peak)

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """See `Metric.results`."""
        return {
            "crossings": memory.number.astype(float),
            "crossing_peak": np.where(memory.number > 0, memory.peak, np.nan),
        }
