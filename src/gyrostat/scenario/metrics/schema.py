"""Keys of pointing requirements, and the metrics that are no classes: percentiles."""

from gyrostat.scenario.metrics.metric import Column
from gyrostat.scenario.schema import Key, positive

REQUIREMENT: dict[str, Key] = {
    "value": positive("angle", None, "Required value of the index."),
    "level": positive(
        "1", None, 'Probability that it is not exceeded, such as 0.997 or "99.7 %".', most=1.0
    ),
    "window": positive("time", None, "Window of the mean; a whole number of control periods."),
    "stability": positive(
        "time",
        None,
        "Time from the start of one window of PDE to that of the other, at least one window.",
    ),
    "share": positive(
        "1", 0.95, "Share of the runs of which a temporal requirement holds.", most=1.0
    ),
}
"""Numbers of a pointing requirement."""
PERCENTILE = Column("rad", "Percentile of the pointing error over the time after `metrics.after`.")
"""Percentile of the pointing error of a run."""
WINDOW_PERCENTILE = Column("rad", "Percentile of the pointing error.")
"""Percentile of the pointing error in a window."""
