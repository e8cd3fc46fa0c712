"""Charts of a campaign: distributions of the metrics, and metrics over their drivers."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from gyrostat.campaigns.summary import percentile_of
from gyrostat.core.types import Vector
from gyrostat.reports.axis import Axis, axis_of, scaled_unit
from gyrostat.reports.campaign_run import labelled
from gyrostat.reports.chart import Chart
from gyrostat.reports.requirements import required_in
from gyrostat.reports.run_table import page_unit, rounded
from gyrostat.scenario import Scenario
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.metrics.results import metrics_of

PERCENT = 99.7
"""Percentile of the runs that is marked."""
MOST_POINTS = 400
"""Largest number of runs in a scatter plot: the first ones, drawn like any other."""
DRIVERS = 2
"""Number of drivers over which a metric is plotted."""


def shown_metrics(scenario: Scenario, columns: Mapping[str, Vector]) -> list[str]:
    """Metrics that differ between runs."""
    finite = {name: columns[name][np.isfinite(columns[name])] for name in metrics_of(scenario)}
    return [name for name, values in finite.items() if len(values) and np.ptp(values) > 0.0]


def histograms(
    scenario: Scenario, columns: Mapping[str, Vector], strongest: Mapping[str, Sequence[str]]
) -> list[Markup]:
    """Histograms of metrics, with the 99.7 % percentile and required values.

    Args:
        scenario: Scenario of the campaign.
        columns: Columns of the table of runs.
        strongest: Drivers of each metric, the strongest first.
    """
    metrics, charts = metrics_of(scenario), []
    for name, keys in strongest.items():
        scale, label = _unit(columns[name], name, metrics[name].unit)
        # the values that the page has, so that a bar and the runs behind it are the same
        to_page, _ = page_unit(name, metrics[name].unit)
        values = rounded(to_page * columns[name][np.isfinite(columns[name])]).astype(float)
        values *= scale / to_page
        low, high = float(np.min(values)), float(np.max(values))
        if low == high:  # they differ in digits that the page does not have
            high += abs(high) or 1.0
        edges = np.linspace(low, high, 1 + min(50, 5 + len(values) // 10))
        counts = np.bincount(_bins(values, edges), minlength=len(edges) - 1)
        required = [(scale * v, text) for v, text in required_in(scenario, name)]
        x = _with(axis_of(edges, label), [v for v, _ in required])
        y = Axis(0.0, 1.05 * float(np.max(counts)), "runs")
        attributes = {"metric": name, "scale": f"{scale / to_page:.9g}"}
        attributes["bins"] = f"{edges[0]:.9g} {edges[-1]:.9g} {len(counts)}"
        attributes["drivers"] = json.dumps(list(keys))
        chart = Chart(name, x, y, attributes)
        chart.bars(edges, counts.astype(float))
        mark = scale * percentile_of(columns[name], PERCENT).value
        chart.level(mark, "", "percentile", across=False)
        for value, text in required:
            chart.level(value, text, "required", across=False)
        charts.append(chart.svg())
    return charts


def scatter_plots(
    scenario: Scenario, columns: Mapping[str, Vector], strongest: Mapping[str, Sequence[str]]
) -> dict[str, list[Markup]]:
    """Metrics over their drivers, from at most 400 runs.

    Args:
        scenario: Scenario of the campaign.
        columns: Columns of the table of runs.
        strongest: Drivers of each metric, the strongest first.
    """
    metrics, numbers = metrics_of(scenario), numbers_of(scenario)
    charts: dict[str, list[Markup]] = {}
    for name, keys in strongest.items():
        fine = np.flatnonzero(np.isfinite(columns[name]))[:MOST_POINTS]
        scale, unit = _unit(columns[name][fine], name, metrics[name].unit)
        values = scale * columns[name][fine]
        required = [(scale * v, text) for v, text in required_in(scenario, name)]
        y = _with(axis_of(values, unit), [v for v, _ in required])
        for key in keys[:DRIVERS]:
            across, label = _unit(columns[key][fine], key, numbers[key].unit)
            x_values = across * columns[key][fine]
            x = axis_of(x_values, labelled(key, label))
            chart = Chart(labelled(name, unit), x, y, {"over": key, "of": name})
            pairs = (across, key, numbers[key].unit), (scale, name, metrics[name].unit)
            scales = [factor / page_unit(*of)[0] for factor, *of in pairs]
            chart.attributes["scales"] = " ".join(f"{each:.9g}" for each in scales)
            chart.points(x_values, values)
            for value, each in required:
                chart.level(value, each, "required")
            charts.setdefault(name, []).append(chart.svg())
    return charts


def _bins(values: Vector, edges: Vector) -> NDArray[np.int64]:
    """Bin of each value; the script of the page computes the same."""
    count = len(edges) - 1
    places = np.floor((values - edges[0]) / (edges[-1] - edges[0]) * count + 1e-6)
    return np.minimum(places, count - 1).astype(np.int64)


def _unit(values: Vector, name: str, unit: str) -> tuple[float, str]:
    """Factor from SI and unit in which values are drawn."""
    scale, label = page_unit(name, unit)
    finite = np.abs(values[np.isfinite(values)])
    factor, label = scaled_unit(scale * float(np.max(finite, initial=0.0)), label)
    return scale * factor, label


def _with(axis: Axis, values: Sequence[float]) -> Axis:
    """Axis that also has values which are not farther away than it is wide."""
    room: Any = axis.high - axis.low
    near = [v for v in values if axis.low - room <= v <= axis.high + room]
    low, high = min([axis.low, *near]), max([axis.high, *near])
    return axis._replace(
        low=low if low == axis.low else low - 0.04 * room,
        high=high if high == axis.high else high + 0.04 * room,
    )
