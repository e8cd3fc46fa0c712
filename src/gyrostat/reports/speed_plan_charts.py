"""Charts of a plan of wheel speeds beside the present law."""

import numpy as np
from matplotlib.figure import Figure

from gyrostat.core.units import RPM
from gyrostat.reports.axis import Axis, axis_of
from gyrostat.reports.chart import COLOURS, Chart
from gyrostat.reports.chart_figure import figure_of
from gyrostat.reports.page_units import shown_unit
from gyrostat.reports.thinned import thinned
from gyrostat.reports.time_chart import held
from gyrostat.runs.speed_plan.flight import Flight
from gyrostat.search.speed_plan import SpeedPlan

MOST_POINTS = 3000
"""Largest number of points of a curve."""
AXES = ("x", "y", "z")
GROUP = "plan"
"""Charts that are zoomed together."""


def plan_charts(result: SpeedPlan) -> list[Chart]:
    """Wheel speeds and torques of the external actuator over time, by each law on common axes.

    Args:
        result: Plan of wheel speeds.
    """
    flights = [("present law", result.present)]
    if result.planned is not None:
        flights.append(("with the plan", result.planned))
    speeds = np.concatenate([flight.speed.ravel() for _, flight in flights]) / RPM
    torques = np.concatenate([flight.unloading.ravel() for _, flight in flights])
    factor, unit = shown_unit("N·m")
    charts = []
    for name, flight in flights:
        x = Axis(float(flight.time[0]), float(flight.time[-1]), "time (s)")
        chart = Chart(f"wheel speed (rpm), {name}", x, axis_of(speeds, ""))
        _shade(chart, result, flight)
        chart.level(0.0, "", "zero")
        for k, wheel in enumerate(result.scenario.wheels):
            chart.line(
                *thinned(flight.time, flight.speed[:, k] / RPM, MOST_POINTS),
                f"wheel {wheel}",
                f"s{k % COLOURS}",
            )
        charts.append(chart)
    if np.any(torques):
        for name, flight in flights:
            x = charts[0].x
            chart = Chart(f"unloading torque ({unit}), {name}", x, axis_of(factor * torques, ""))
            _windows(chart, flight)
            for k, axis in enumerate(AXES):
                time, torque = held(flight.time, factor * flight.unloading[:, k : k + 1])
                chart.line(*thinned(time, torque[:, 0], MOST_POINTS), axis, f"s{k}")
            charts.append(chart)
    for chart in charts:
        chart.attributes["group"] = GROUP
    return charts


def plan_figure(result: SpeedPlan) -> Figure:
    """Draw the charts of a plan; the science windows are grey, the speeds to avoid red.

    Args:
        result: Plan of wheel speeds.
    """
    return figure_of(plan_charts(result), 1 if result.planned is None else 2)


def _windows(chart: Chart, flight: Flight) -> None:
    """Shade the science windows."""
    ends = np.array([chart.y.low, chart.y.high])
    chart.cells(_edges(flight), ends, flight.inside[None, :], "unknown")


def _shade(chart: Chart, result: SpeedPlan, flight: Flight) -> None:
    """Shade the science windows, and the speeds to avoid in them."""
    _windows(chart, flight)
    low, high = chart.y.low, chart.y.high
    clearance, limits = result.clearance, result.limits
    most = float(np.min(limits.momentum / limits.inertia)) - clearance
    avoided = [(-clearance, clearance), (most, np.inf), (-np.inf, -most)]
    for start, end in limits.bands:
        inner, outer = max(start - clearance, 0.0), end + clearance
        avoided += [(inner, outer), (-outer, -inner)]
    for start, end in avoided:
        ends = np.clip(np.array([start, end]) / RPM, low, high)
        if ends[1] > ends[0]:
            chart.cells(_edges(flight), ends, flight.inside[None, :], "avoided")


def _edges(flight: Flight) -> np.ndarray:
    """Ends of the control periods of a run."""
    return np.append(flight.time, 2.0 * flight.time[-1] - flight.time[-2])
