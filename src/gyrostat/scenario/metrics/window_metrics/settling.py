"""Settling time of a window."""

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowSample, WindowStart


class SettlingTimes(NamedTuple):
    """Settling times so far.

    Attributes:
        since: Start of the last interval, s.
        settled_from: Time since which the last interval is settled, s; infinite: not settled.
        longest: Longest settling time of the intervals before the last, s.
    """

    since: Scalar
    settled_from: Scalar
    longest: Scalar


class Settling(WindowMetric):
    """Longest settling time of the intervals of a window.

    Attributes:
        angle: Settling threshold of the pointing error, rad.
        rate: Settling threshold of the rate error, rad/s.
    """

    angle: Scalar | float
    rate: Scalar | float
    place = 40
    columns: ClassVar[Mapping[str, Column]] = {
        "settling": Column(
            "s",
            "Time from the start of the window after which it stays settled until its end, the "
            "longest of all times that the window is entered; none: never.",
        )
    }

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """See `WindowMetric.of`."""
        return cls(window.settled_angle, window.settled_rate)

    def start(self) -> SettlingTimes:
        """See `WindowMetric.start`."""
        never = jnp.array(-jnp.inf)
        return SettlingTimes(jnp.zeros(()), never, never)

    def __call__(self, memory: SettlingTimes, sample: WindowSample) -> SettlingTimes:
        """See `WindowMetric.__call__`."""
        entered = sample.entered
        is_settled = (sample.angle < self.angle) & (sample.rate < self.rate)
        before = jnp.where(entered, jnp.inf, memory.settled_from)
        settled_from = jnp.where(is_settled, jnp.minimum(before, sample.run.time), jnp.inf)
        settling_time = jnp.maximum(memory.longest, memory.settled_from - memory.since)
        return SettlingTimes(
            jnp.where(entered, sample.begin, memory.since),
            jnp.where(sample.inside, settled_from, memory.settled_from),
            jnp.where(entered, settling_time, memory.longest),
        )

    @classmethod
    def results(cls, memory: Any, samples: Vector) -> dict[str, Vector]:
        """See `WindowMetric.results`."""
        return {"settling": np.maximum(memory.longest, memory.settled_from - memory.since)}
