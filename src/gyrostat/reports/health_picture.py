"""Picture of the health of flying wheels."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.monitoring.change.assess import WheelHealth
from gyrostat.monitoring.health import Health
from gyrostat.monitoring.windows import PARAMETERS
from gyrostat.reports.axis import scaled_unit
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.health_charts import SIGMAS, TITLES, since
from gyrostat.reports.health_series import WheelSeries, wheel_series

ROW = 2.0
"""Height of the row of a wheel in the picture, inches."""
MOST_WHEELS = 8
"""Largest number of wheels in the picture, those with an alarm first."""


def health_figure(health: Health) -> Figure:
    """Draw the trends of each wheel with alarms, limit and windows that are not observable.

    Args:
        health: Result of monitoring.
    """
    ordered = sorted(health.conditions, key=lambda each: not each.alarm)[:MOST_WHEELS]
    rows = max(len(ordered), 1)
    with panels(rows, len(TITLES), height=ROW * rows, squeeze=False) as (figure, grid):
        for axes_row, condition in zip(grid, ordered, strict=False):
            series = wheel_series(health.windows.wheel(condition.wheel), condition)
            for axes, name in zip(axes_row, TITLES, strict=True):
                _trend_axes(axes, series, condition, name)
            axes_row[0].set_title(literal(condition.wheel), fontsize=9, loc="left")
            if condition.alarm:
                axes_row[1].set_title(
                    literal(f"ALARM: {condition.class_text}"), fontsize=8, color=MARK, loc="left"
                )
    return figure


def _trend_axes(axes: Axes, series: WheelSeries, condition: WheelHealth, name: str) -> None:
    """Draw one parameter of one wheel."""
    trend, (level, spread) = series.trends[name], series.level[name]
    factor, unit = scaled_unit(float(np.nanmax(np.abs(level), initial=0.0)), PARAMETERS[name], 0)
    low, high = factor * (level - SIGMAS * spread), factor * (level + SIGMAS * spread)
    axes.fill_between(series.middle, low, high, color=BAND, alpha=0.7, lw=0)
    axes.errorbar(
        series.middle,
        factor * trend.value,
        factor * SIGMAS * trend.sigma,
        fmt=".",
        ms=3,
        lw=0.7,
        color=MEASURED,
    )
    axes.plot(series.middle, factor * level, color=MODEL, lw=1.2)
    for k in np.flatnonzero(trend.unknown):
        axes.axvspan(series.edges[k], series.edges[k + 1], color=MEASURED, alpha=0.2, lw=0)
    for alarm in condition.alarms:
        axes.axvline(since(condition, alarm, series), color=MARK, lw=0.8, ls=":")
    axes.set_xlim(0.0, series.edges[-1])
    axes.set_xlabel(f"time ({series.unit})")
    axes.set_ylabel(f"{TITLES[name]}\n({unit})")
