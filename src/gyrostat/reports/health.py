"""Page of the health of flying wheels."""

import math
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from gyrostat.core.text import measured, plain
from gyrostat.monitoring.change.assess import WheelHealth
from gyrostat.monitoring.health import Health, unknown_text
from gyrostat.monitoring.windows import PARAMETERS, Windows
from gyrostat.reports.axis import scaled_unit
from gyrostat.reports.health_charts import SHADES, SIGMAS, health_charts, shade
from gyrostat.reports.health_series import DAY, WheelSeries, wheel_series
from gyrostat.reports.template import render

MOST_ALARMS = 12
"""Largest number of alarms whose day is written."""
SHOWN = 0.01
"""Smallest probability of a class that the page names."""


@dataclass(frozen=True)
class _Wheel:
    """Section of a wheel.

    Attributes:
        name: Name of the wheel.
        kind: Class of its verdict: "invalid" (alarm), "open" or "good".
        verdict: Verdict in one line.
        details: Further lines.
        charts: Charts.
        bins: What a mark of the charts is.
        rows: Parameter, value with its interval or why there is none.
    """

    name: str
    kind: str
    verdict: str
    details: list[str]
    charts: list[Markup]
    bins: str
    rows: list[tuple[str, str, str]]


def health_page(health: Health, *, command: str) -> str:
    """HTML report of the health of wheels.

    Args:
        health: Result of monitoring.
        command: Command line that produced it.
    """
    tables = [health.windows.wheel(condition.wheel) for condition in health.conditions]
    histories = [wheel_series(*pair) for pair in zip(tables, health.conditions, strict=True)]
    step = shade(histories)
    wheels = [
        _wheel(health, condition, series, step)
        for condition, series in zip(health.conditions, histories, strict=True)
    ]
    return render(
        "health.html",
        health=health,
        command=command,
        wheels=wheels,
        shades=range(2 * SHADES + 1),
        reach=100.0 * SHADES * step,
        first=float(np.min(health.windows["start"], initial=np.inf)),
        last=float(np.max(health.windows["end"], initial=-np.inf)),
    )


def _wheel(health: Health, condition: WheelHealth, series: WheelSeries, step: float) -> _Wheel:
    table = health.windows.wheel(condition.wheel)
    window = float(np.median(table["end"] - table["start"]))
    mark = "one window" if series.per_bin == 1 else f"{series.per_bin} windows"
    kind, verdict = _verdict(table, condition)
    return _Wheel(
        condition.wheel,
        kind,
        verdict,
        _details(condition),
        health_charts(series, condition, health.settings.threshold, step, condition.wheel),
        f"{mark} of {window / DAY:.3g} d",
        _rows(health, condition.wheel),
    )


def _verdict(table: Windows, condition: WheelHealth) -> tuple[str, str]:
    """Class and text of the verdict on a wheel."""
    if condition.alarm:
        return "invalid", f"ALARM: {condition.class_text}"
    if not table["valid"].any():
        return "open", f"not valid: {table['why'][-1]}"
    text = "no change found"
    if condition.alarms:
        text = f"no alarm stands after the last window, {_count(condition)} before"
    if not table["valid"][-1]:
        return "open", f"{text}, but the last window is not valid: {table['why'][-1]}"
    return "open" if condition.alarms else "good", text


def _count(condition: WheelHealth) -> str:
    number = len(condition.alarms)
    return "1 alarm" if number == 1 else f"{number} alarms"


def _details(condition: WheelHealth) -> list[str]:
    """Onset, probabilities, earlier alarms and forecast."""
    lines = []
    last = condition.verdicts[-1]
    if condition.alarm:
        low, high = (_day(condition, k) for k in (last.onset or (0, 0, 0))[1:])
        lines.append(f"began between day {low:.4g} and day {high + 1.0:.4g} (90 %)")
        probable = sorted(last.probabilities.items(), key=lambda pair: -pair[1])
        shown = [f"{name} {100.0 * share:.0f} %" for name, share in probable if share > SHOWN]
        lines.append(f"probabilities: {', '.join(shown)}")
    if condition.alarms:
        days = [f"{_day(condition, k):.4g}" for k in condition.alarms]
        more = f" and {len(days) - MOST_ALARMS} more" if len(days) > MOST_ALARMS else ""
        lines.append(f"alarms began on day {', '.join(days[:MOST_ALARMS])}{more}")
    if condition.forecast is not None:
        lines.append(_forecast_text(condition))
    return lines


def _day(condition: WheelHealth, window: int) -> float:
    return float(condition.start[window] - condition.start[0]) / DAY


def _forecast_text(condition: WheelHealth) -> str:
    """When the friction reaches the limit."""
    forecast = condition.forecast
    if forecast is None or condition.limit is None:
        return ""
    limit = f"the friction limit of {_scaled(condition.limit, 'N·m')}"
    early, middle, late = (forecast.quantile(share) for share in (0.1, 0.5, 0.9))
    years = forecast.days[-1] / 365.25
    if not math.isfinite(early):
        return f"{limit} is not reached within {years:.0f} years (90 %)"
    if early <= forecast.days[0]:
        return f"{limit} is reached"
    if not math.isfinite(middle):
        return f"{limit} is not reached within {years:.0f} years (50 %), in {early:.0f} days (10 %)"
    end = f"{late:.0f} days" if math.isfinite(late) else f"more than {years:.0f} years"
    return f"{limit} is reached in {early:.0f} days to {end} (80 %), median {middle:.0f} days"


def _scaled(value: float, unit: str) -> str:
    factor, shown = scaled_unit(abs(value), unit, 0)
    return f"{plain(factor * value)} {shown}"


def _rows(health: Health, name: str) -> list[tuple[str, str, str]]:
    """Parameters of the last valid window: name, class, text."""
    row = health.latest(name)
    if row is None:
        return []
    rows = []
    for parameter, unit in PARAMETERS.items():
        title = parameter.replace("_", " ")
        if row[f"{parameter}_observable"]:
            factor, shown = scaled_unit(abs(row[parameter]), unit, 0)
            half = SIGMAS * row[f"{parameter}_sigma"]
            text = f"{measured(factor * row[parameter], factor * half)} {shown}"
            rows.append((title, "", text))
        else:
            rows.append((title, "open", unknown_text(row, parameter)))
    if math.isfinite(row["speed_scale"]):
        text = measured(row["speed_scale"], SIGMAS * row["speed_scale_sigma"])
        rows.append(("true over measured speed", "", text))
    return rows
