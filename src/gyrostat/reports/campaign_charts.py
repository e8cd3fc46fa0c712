"""Charts of a campaign: distributions of the metrics, and metrics over their drivers."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from gyrostat.campaigns.summary import percentile_of
from gyrostat.core.types import Vector
from gyrostat.reports.axis import Axis, axis_of, scaled_unit
from gyrostat.reports.chart import Chart
from gyrostat.reports.page_units import labelled, page_unit
from gyrostat.reports.requirements import required_in
from gyrostat.reports.run_table import rounded
from gyrostat.scenario import Scenario
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.metrics.results import metrics_of

PERCENT = 99.7
"""Percentile of the runs that is marked."""
MOST_POINTS = 400
"""Largest number of runs in a scatter plot: the first ones, drawn like any other."""
_AT_ONCE = 1_000_000
"""Number of runs whose values are in memory in another unit at a time."""
DRIVERS = 2
"""Number of drivers over which a metric is plotted."""


def shown_metrics(scenario: Scenario, columns: Mapping[str, Vector]) -> list[str]:
    """Metrics that differ between runs."""
    extents = {name: _extent(columns[name]) for name in metrics_of(scenario)}
    return [name for name, (low, high) in extents.items() if high - low > 0.0]


def histograms(
    scenario: Scenario, columns: Mapping[str, Vector], strongest: Mapping[str, Sequence[str]]
) -> list[Chart]:
    """Histograms of metrics, with the 99.7 % percentile and required values.

    Args:
        scenario: Scenario of the campaign.
        columns: Columns of the table of runs.
        strongest: Drivers of each metric, the strongest first.
    """
    metrics, charts = metrics_of(scenario), []
    for name, keys in strongest.items():
        values = columns[name]
        scale, label = _unit(values, name, metrics[name].unit)
        to_page, _ = page_unit(name, metrics[name].unit)
        edges, counts = _histogram(values, to_page, scale / to_page)
        required = [(scale * v, text) for v, text in required_in(scenario, name)]
        x = _with(axis_of(edges, label), [v for v, _ in required])
        y = Axis(0.0, 1.05 * float(np.max(counts)), "runs")
        attributes = {"metric": name, "scale": f"{scale / to_page:.9g}"}
        attributes["bins"] = f"{edges[0]:.9g} {edges[-1]:.9g} {len(counts)}"
        attributes["drivers"] = json.dumps(list(keys))
        chart = Chart(name, x, y, attributes)
        chart.bars(edges, counts.astype(float))
        mark = scale * percentile_of(values, PERCENT).value
        del values  # before the next column is read
        chart.level(mark, "", "percentile", across=False)
        for level, text in required:
            chart.level(level, text, "required", across=False)
        charts.append(chart)
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
        values = columns[name]
        fine = _first_finite(values)
        values = values[fine]
        scale, unit = _unit(values, name, metrics[name].unit)
        values = scale * values
        required = [(scale * v, text) for v, text in required_in(scenario, name)]
        y = _with(axis_of(values, unit), [v for v, _ in required])
        for key in keys[:DRIVERS]:
            x_values = columns[key][fine]
            across, label = _unit(x_values, key, numbers[key].unit)
            x_values = across * x_values
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


def _first_finite(values: Vector) -> NDArray[np.int64]:
    """Runs of a scatter plot; the indices of all runs would take as much memory as the values."""
    found = np.zeros(0, np.int64)
    for first in range(0, len(values), _AT_ONCE):
        if len(found) < MOST_POINTS:
            finite = np.isfinite(values[first : first + _AT_ONCE])
            found = np.append(found, first + np.flatnonzero(finite))[:MOST_POINTS]
    return found


def _histogram(values: Vector, to_page: float, scale: float) -> tuple[Vector, NDArray[np.int64]]:
    """Edges and counts of the bins of values, NaN for missing ones.

    They are those of the values that the page has, so that a bar and the runs behind it are the
    same.

    Args:
        values: Values, SI.
        to_page: Factor from SI to the unit of the page.
        scale: Factor from this unit to that of the chart.
    """

    def parts() -> Iterator[Vector]:
        for first in range(0, len(values), _AT_ONCE):
            part = values[first : first + _AT_ONCE]
            yield rounded(to_page * part[np.isfinite(part)]).astype(float) * scale

    count, low, high = 0, np.inf, -np.inf
    for part in parts():
        count += len(part)
        low = min(low, float(np.min(part, initial=np.inf)))
        high = max(high, float(np.max(part, initial=-np.inf)))
    if low == high:  # they differ in digits that the page does not have
        high += abs(high) or 1.0
    edges = np.linspace(low, high, 1 + min(50, 5 + count // 10))
    counts = sum(np.bincount(_bins(part, edges), minlength=len(edges) - 1) for part in parts())
    return edges, np.asarray(counts)


def _extent(values: Vector) -> tuple[float, float]:
    """Least and largest finite value; infinite, in the wrong order, without any."""
    finite = np.isfinite(values)
    low = np.min(values, where=finite, initial=np.inf)
    return float(low), float(np.max(values, where=finite, initial=-np.inf))


def _bins(values: Vector, edges: Vector) -> NDArray[np.int64]:
    """Bin of each value; the script of the page computes the same."""
    count = len(edges) - 1
    places = np.floor((values - edges[0]) / (edges[-1] - edges[0]) * count + 1e-6)
    return np.minimum(places, count - 1).astype(np.int64)


def _unit(values: Vector, name: str, unit: str) -> tuple[float, str]:
    """Factor from SI and unit in which values are drawn."""
    scale, label = page_unit(name, unit)
    low, high = _extent(values)
    factor, label = scaled_unit(scale * max(-low, high, 0.0), label)
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
