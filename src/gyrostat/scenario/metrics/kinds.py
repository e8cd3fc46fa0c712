"""Metrics that every run and every window can have, found in their folders."""

from importlib import import_module
from math import inf
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

from gyrostat.scenario.metrics import run_metrics, window_metrics
from gyrostat.scenario.metrics.metric import Metric
from gyrostat.scenario.metrics.window_metric import WindowMetric
from gyrostat.scenario.schema import Key, size

Kind = TypeVar("Kind", bound=Metric | WindowMetric)


def _kinds(folder: ModuleType, base: type[Kind]) -> tuple[type[Kind], ...]:
    """Metrics in the files of a folder, in the order of their columns."""
    made: set[type[Kind]] = set()
    for file in iter_modules(folder.__path__):
        content = vars(import_module(f"{folder.__name__}.{file.name}")).values()
        made |= {each for each in content if isinstance(each, type) and issubclass(each, base)}
    return tuple(sorted(made - {base}, key=lambda kind: kind.place))


RUN_METRICS = _kinds(run_metrics, Metric)
"""Metrics of every run."""
WINDOW_METRICS = _kinds(window_metrics, WindowMetric)
"""Metrics that a window can have."""
METRICS: dict[str, Key] = {name: key for kind in RUN_METRICS for name, key in kind.keys.items()}
"""Keys of the section "metrics"."""
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
