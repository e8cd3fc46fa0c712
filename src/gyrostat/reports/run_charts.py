"""Charts of a run over time."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.campaigns.pointing.text import angle_text, is_of_error
from gyrostat.core.units import RPM
from gyrostat.reports.chart import Chart
from gyrostat.reports.mode_chart import mode_chart
from gyrostat.reports.page_units import shown_unit
from gyrostat.reports.time_chart import held, time_chart
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.timeline import modes

LEAST_SHOWN = 1e-5
"""Smallest error and rate drawn, deg and deg/s; smaller ones are rounding errors."""
MOST_POINTS = 4000
"""Largest number of points of a curve in the page of a run."""


def run_charts(
    scenario: Scenario,
    values: Mapping[str, Any],
    history: Mapping[Any, Any],
    group: str = "run",
    most: int = MOST_POINTS,
) -> list[Chart]:
    """Modes, pointing error, body rate, wheel speeds and motor torques over time, with the events.

    Args:
        scenario: Scenario of the run.
        values: Row of the run in the table of runs, whose events may have times of their own.
        history: Histories of the run: name -> array, or what can be converted to one.
        group: Name of the group of charts that are zoomed together.
        most: Largest number of points of a curve.
    """
    error = np.degrees(np.asarray(history["error"]))
    rate = np.degrees(np.linalg.norm(np.asarray(history["rate"]), axis=1))
    torque = np.asarray(history["torque"])
    factor, unit = shown_unit("N·m")
    sizes = [np.maximum(each, LEAST_SHOWN)[:, None] for each in (error, rate)]
    speed = np.asarray(history["wheel_speed"]) / RPM
    time = np.asarray(history["time"])
    charts = [
        time_chart(time, sizes[0], "pointing error (deg)", ["error"], most, is_log=True),
        time_chart(time, sizes[1], "body rate (deg/s)", ["rate"], most, is_log=True),
        time_chart(time, speed, "wheel speed (rpm)", scenario.wheels, most),
        time_chart(*held(time, factor * torque), f"motor torque ({unit})", scenario.wheels, most),
    ]
    for each in scenario.requirements:
        if is_of_error(each, scenario):
            text = f"{each.name} {angle_text(each.value, each.value)}"
            charts[0].level(float(np.degrees(each.value)), text, "required")
    shown_modes = mode_chart(modes(scenario.parts), history)
    if shown_modes is not None:
        charts.append(shown_modes)
    for k, chart in enumerate(charts):
        chart.attributes["group"] = group
        for event in scenario.events:
            key = f"event.{event.name}.time"
            at = values.get(key, scenario.values[key])
            chart.level(at, event.name if k == 0 else "", "event", across=False)
    return charts
