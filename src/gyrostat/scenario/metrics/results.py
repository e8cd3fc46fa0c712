"""Names, units and meanings of the metrics of a scenario."""

from typing import NamedTuple

from gyrostat.scenario.metrics.budget import BUDGET, gained
from gyrostat.scenario.metrics.kinds import WINDOW_METRICS, kinds_of_run
from gyrostat.scenario.metrics.mode_metrics import columns_of
from gyrostat.scenario.metrics.schema import PERCENTILE, WINDOW_PERCENTILE
from gyrostat.scenario.metrics.tracker_view import HEADS, heads_of
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowStart
from gyrostat.scenario.scenario import Scenario, Window
from gyrostat.scenario.timeline import branches, mode_names


class Metric(NamedTuple):
    """Metric of a run: a column of the table of runs.

    Attributes:
        unit: SI unit.
        meaning: One sentence.
        window: Name of its window; None for the whole run.
    """

    unit: str
    meaning: str
    window: str | None = None


def metrics_of(scenario: Scenario) -> dict[str, Metric]:
    """Every metric of a scenario, by name and in the order of the table of runs."""
    percentiles = [percentile_name(percent) for percent in scenario.percentiles]
    columns = dict.fromkeys(percentiles, PERCENTILE)
    for kind in kinds_of_run(scenario.parts):
        columns |= kind.columns
    metrics = {name: Metric(column.unit, column.meaning) for name, column in columns.items()}
    for window in scenario.windows:
        entries = {name: Metric(*WINDOW_PERCENTILE[:2], window.name) for name in percentiles}
        entries |= window_metrics(window_start(scenario, window))
        metrics |= {f"{window.name}.{name}": metric for name, metric in entries.items()}
    metrics |= {each.metric: Metric(each.unit, each.meaning) for each in scenario.requirements}
    return metrics | _user_metrics(scenario) | _modes(scenario) | _budget(scenario)


def _modes(scenario: Scenario) -> dict[str, Metric]:
    """Metrics of the modes of a reference that branches."""
    columns = columns_of(*mode_names(scenario)) if branches(scenario.parts) else {}
    return {name: Metric(column.unit, column.meaning) for name, column in columns.items()}


def _budget(scenario: Scenario) -> dict[str, Metric]:
    """Metrics of the momentum budget."""
    if not scenario.budget:
        return {}
    from gyrostat.scenario.kinds.registry import chosen  # imports JAX, which takes long

    names = ["constant"]
    names += chosen(scenario, "environment").torque_names
    names += [part.name for part in scenario.parts if part.section == "environment.torque"]
    names += [f"actuator.{part.name}" for part in scenario.parts if part.section == "actuator"]
    return {gained(name): Metric(BUDGET.unit, BUDGET.meaning) for name in names}


def _user_metrics(scenario: Scenario) -> dict[str, Metric]:
    parts = [part for part in scenario.parts if part.section == "metric"]
    if not parts:
        return {}
    from gyrostat.scenario.kinds.registry import component  # imports JAX, which takes long

    components = {part.name: component(part.section, part.kind, scenario.sources) for part in parts}
    return {name: Metric(metric.unit, metric.meaning()) for name, metric in components.items()}


def percentile_name(percent: float) -> str:
    """Name of a percentile of the pointing error."""
    return f"error_p{percent:g}"


def window_metrics(window: WindowStart) -> dict[str, Metric]:
    """Metrics of a window except percentiles, without the name of the window."""
    return {
        name: Metric(column.unit, column.meaning, window.window.name)
        for kind in kinds_of_window(window)
        for name, column in kind.columns_of(window).items()
    }


def kinds_of_window(window: WindowStart) -> list[type[WindowMetric]]:
    """Metrics that a window asks for."""
    keys = {"", *window.values}
    keys |= {HEADS} if window.heads else set()
    keys |= {"boresight"} if window.boresight is not None else set()
    keys |= {"propellant"} if window.window.propellant is not None else set()
    return [kind for kind in WINDOW_METRICS if kind.asked_by in keys]


def window_start(scenario: Scenario, window: Window) -> WindowStart:
    """Window of a scenario with the numbers that it gives."""
    prefix = f"window.{window.name}."
    values = {k.removeprefix(prefix): v for k, v in scenario.values.items() if k.startswith(prefix)}
    boresight = window.boresight or scenario.boresight
    heads = heads_of(scenario.parts)
    return WindowStart(window, scenario.wheels, boresight, values, heads=heads)
