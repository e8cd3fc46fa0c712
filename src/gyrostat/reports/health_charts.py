"""Charts of a flying wheel: friction over speed and time, trends of its parameters, alarms."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from gyrostat.core.text import plain
from gyrostat.core.types import Vector
from gyrostat.monitoring.change.assess import WheelHealth
from gyrostat.monitoring.windows import PARAMETERS
from gyrostat.reports.axis import Axis, axis_of, scaled_unit
from gyrostat.reports.chart import Chart
from gyrostat.reports.health_series import DAY, YEAR, Mask, Trend, WheelSeries

SHADES = 4
"""Number of shades of an increase, and of a decrease."""
STEPS = (0.01, 0.02, 0.05)
"""Changes of one shade; a smaller change is noise, a larger one has the last shade."""
TITLES = {
    "coulomb": "Coulomb torque",
    "viscous": "viscous coefficient",
    "motor_constant": "motor constant",
}
"""Parameter with a chart -> title."""
SIGMAS = 1.96
"""Half the width of a 95 % interval, standard deviations."""
NEAR = 2.0
"""Limit over the largest friction below which it is on the axis."""
ABOVE = 3.0
"""Largest alarm statistic drawn, in the threshold."""


def health_charts(
    series: WheelSeries, health: WheelHealth, threshold: float, step: float, group: str
) -> list[Markup]:
    """Friction surface, friction with its limit, trends of the parameters, and alarm statistic.

    Args:
        series: History of the wheel.
        health: Its health.
        threshold: Log of the statistic at which an alarm is raised.
        step: Change of the friction of one shade of the surface, relative.
        group: Name of the group of charts that are zoomed together.
    """
    across = Axis(0.0, float(series.edges[-1]), f"time ({series.unit})")
    charts = [_surface(series, across, step), _friction(series, health, across)]
    charts += [_trend_chart(series, name, across) for name in TITLES]
    charts.append(_statistic(series, threshold, across))
    for k, chart in enumerate(charts):
        chart.attributes |= {"group": group, "unit": series.unit}
        for number, alarm in enumerate(health.alarms):
            name = "alarm" if k == number == 0 else ""
            chart.level(since(health, alarm, series), name, "event", across=False)
    return [chart.svg() for chart in charts]


def since(health: WheelHealth, window: int, series: WheelSeries) -> float:
    """Start of a window since that of the first one, in the unit of the series."""
    days = float(health.start[window] - health.start[0]) / DAY
    return days / YEAR if series.unit == "years" else days


def shade(histories: Sequence[WheelSeries]) -> float:
    """Change of the friction of one shade for all wheels, relative: one of `STEPS`."""
    largest = max((_largest(series.change) for series in histories), default=0.0)
    return next((step for step in STEPS if SHADES * step >= largest), STEPS[-1])


def _surface(series: WheelSeries, across: Axis, step: float) -> Chart:
    upright = Axis(float(series.speeds[0]), float(series.speeds[-1]), "")
    chart = Chart("change of the friction torque over speed (rpm)", across, upright)
    _mark_unknown(chart, series, series.unsteady)
    number = np.clip(np.round(series.change / step), -SHADES, SHADES)
    for k in range(-SHADES, SHADES + 1):
        chart.cells(series.edges, series.speeds, number == k, f"shade{k + SHADES}")
    return chart


def _friction(series: WheelSeries, health: WheelHealth, across: Axis) -> Chart:
    trend = series.friction
    factor, unit = scaled_unit(_largest(trend.value), "N·m", 0)
    near = [v for v in [health.limit] if v is not None and v < NEAR * _largest(trend.value)]
    chart = Chart(
        f"friction at {health.speed * 30.0 / np.pi:.0f} rpm and 20 °C ({unit})",
        across,
        axis_of(factor * np.concatenate([*_ends(trend), near]), ""),
    )
    _draw(chart, series, trend, factor)
    if health.limit is not None:
        name = f"limit {plain(factor * health.limit)} {unit}"
        chart.level(factor * health.limit, name, "required")
    return chart


def _trend_chart(series: WheelSeries, name: str, across: Axis) -> Chart:
    trend, (level, spread) = series.trends[name], series.level[name]
    factor, unit = scaled_unit(max(_largest(trend.value), _largest(level)), PARAMETERS[name], 0)
    low, high = level - SIGMAS * spread, level + SIGMAS * spread
    fine = (low > 0.0) & np.isfinite(high)
    extent = np.concatenate([*_ends(trend), level, low[fine], high[fine]])
    chart = Chart(f"{TITLES[name]} ({unit})", across, axis_of(factor * extent, ""))
    chart.band(series.middle[fine], factor * low[fine], factor * high[fine], "narrow")
    _draw(chart, series, trend, factor)
    chart.line(series.middle, factor * level, "level", "s0")
    return chart


def _statistic(series: WheelSeries, threshold: float, across: Axis) -> Chart:
    """Log of the alarm statistic, of which large values are left out: an alarm is an alarm."""
    fine = np.minimum(series.statistic, ABOVE * threshold)
    low = min(0.0, float(np.nanmin(fine, initial=0.0)))
    title = "evidence of a change (log of the alarm statistic)"
    chart = Chart(title, across, Axis(low, 1.05 * ABOVE * threshold, ""))
    chart.line(series.middle, fine, "log")
    chart.level(threshold, "alarm above", "required")
    return chart


def _draw(chart: Chart, series: WheelSeries, trend: Trend, factor: float) -> None:
    """Draw estimates with their 95 % intervals, and bins without an estimate."""
    _mark_unknown(chart, series, trend.unknown)
    low, high = _ends(trend)
    fine = np.isfinite(trend.value)
    chart.spans(series.middle[fine], factor * low[fine], factor * high[fine], "measured")
    chart.points(series.middle[fine], factor * trend.value[fine], "measured")


def _mark_unknown(chart: Chart, series: WheelSeries, unknown: Mask) -> None:
    ends = np.array([chart.y.low, chart.y.high])
    chart.cells(series.edges, ends, unknown[None, :], "unknown")


def _ends(trend: Trend) -> tuple[Vector, Vector]:
    """Ends of the 95 % intervals."""
    return trend.value - SIGMAS * trend.sigma, trend.value + SIGMAS * trend.sigma


def _largest(values: Vector) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))
