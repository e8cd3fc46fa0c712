"""Metrics that every run and every window can have, found in their folders."""

from collections.abc import Iterable
from math import inf

from gyrostat.core.classes_of import classes_of
from gyrostat.scenario.metrics import run_metrics, window_metrics
from gyrostat.scenario.metrics.metric import Metric
from gyrostat.scenario.metrics.window_metric import WindowMetric
from gyrostat.scenario.scenario import Part
from gyrostat.scenario.schema import Key, size

RUN_METRICS = tuple(sorted(classes_of(run_metrics, Metric), key=lambda kind: kind.place))
"""Metrics that a run can have, in the order of their columns."""
WINDOW_METRICS = tuple(
    sorted(classes_of(window_metrics, WindowMetric), key=lambda kind: kind.place)
)
"""Metrics that a window can have, in the order of their columns."""
METRICS: dict[str, Key] = {name: key for kind in RUN_METRICS for name, key in kind.keys.items()}
"""Keys of the section "metrics"."""


def kinds_of_run(parts: Iterable[Part]) -> list[type[Metric]]:
    """Metrics of the runs of a scenario with these parts."""
    sections = {"", *(part.section for part in parts)}
    return [kind for kind in RUN_METRICS if kind.asked_by in sections]


def keys_of_run(parts: Iterable[Part]) -> dict[str, Key]:
    """Keys of the section "metrics" of a scenario with these parts."""
    return {name: key for kind in kinds_of_run(parts) for name, key in kind.keys.items()}


WINDOW: dict[str, Key] = {
    "from": size("time", 0.0, "Start of the window, which includes a sample at this time."),
    "until": size(
        "time",
        inf,
        "End of the window, which includes a sample at this time; none: the next slew for a window "
        "of an event, otherwise the end of the run.",
    ),
    **{name: key for kind in WINDOW_METRICS for name, key in kind.keys.items()},
}
"""Keys of a window; those without default are optional, and each adds a metric."""
