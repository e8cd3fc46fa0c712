"""What a star tracker with heads sees, sample by sample: signals of its metrics."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.metric import TOLERANCE, Column
from gyrostat.scenario.metrics.statistic import MAX, MEAN
from gyrostat.scenario.scenario import Part

TRACKER_PERIODS = "sensors.tracker_periods"
"""Key of the control periods between samples of the star tracker."""
LEAST = "metrics.least_availability"
"""Key of the least availability in a window, below which a line says so."""
HEADS = "star_tracker"
"""Section of the heads of a star tracker."""


def heads_of(parts: Iterable[Part]) -> int:
    """Number of star tracker heads of a scenario with these parts."""
    return sum(part.section == HEADS for part in parts)


COLUMNS: Mapping[str, Column] = {
    "tracker_availability": Column(
        "1",
        "Fraction of time with an attitude from the star tracker that is not older than its "
        "sampling interval.",
        MEAN,
    ),
    "tracker_outage": Column("s", "Longest time without such an attitude.", MAX),
    "heads_in_view": Column("1", "Mean number of star tracker heads that are not blind.", MEAN),
}
"""Metrics of the view of a star tracker."""


class TrackerView(NamedTuple):
    """Memory from sample to sample.

    Attributes:
        age: Time since the last attitude, s.
        ages: Time since the last sample of each head, (heads,), s; a scalar before the first one.
        outage: Time without an attitude until now, s.
    """

    age: Scalar
    ages: Float[Array, "..."]
    outage: Scalar

    @classmethod
    def before(cls, heads: int) -> "TrackerView":
        """Memory before the first sample."""
        return cls(jnp.array(jnp.inf), jnp.full(heads, jnp.inf), jnp.zeros(()))


def viewed(
    view: TrackerView,
    measurement: Any,
    period: Scalar | float,
    periods: Scalar | float,
    counts: Bool[Array, ""] | bool = True,
) -> tuple[TrackerView, dict[str, Any]]:
    """Memory after a sample, and the signal of each column.

    Args:
        view: Memory before it.
        measurement: Measurement with `attitude`, `attitude_measured` and `tracker_heads`.
        period: Control period, s.
        periods: Control periods between samples of the star tracker.
        counts: Whether the sample is in the interval in which outages are counted.
    """
    # a dropout leaves no number
    finite = jnp.all(jnp.isfinite(measurement.attitude))
    age = jnp.where(measurement.attitude_measured & finite, 0.0, view.age + period)
    ages = jnp.where(measurement.tracker_heads, 0.0, view.ages + period)
    interval = (jnp.round(periods) - 1.0) * period + TOLERANCE
    is_known = age <= interval
    outage = jnp.where(is_known | ~jnp.asarray(counts), 0.0, view.outage + period)
    signals = {
        "tracker_availability": is_known,
        "tracker_outage": outage,
        "heads_in_view": jnp.sum(ages <= interval),
    }
    return TrackerView(age, ages, outage), signals
