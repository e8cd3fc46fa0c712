"""Pointing requirements in the report of a campaign: verdicts, and errors over time."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from gyrostat.campaigns import Store
from gyrostat.campaigns.blocks import list_parts
from gyrostat.campaigns.pointing.campaign import ERROR_PROFILE, PROFILED, counts_name, profile_name
from gyrostat.campaigns.pointing.collected import instants
from gyrostat.campaigns.pointing.text import (
    ARCSECOND,
    SMALL,
    angle_text,
    is_of_error,
    requirement_text,
)
from gyrostat.campaigns.pointing.verdicts import Verdict, judged
from gyrostat.campaigns.summary import Estimate
from gyrostat.core.text import or_none
from gyrostat.reports.axis import Axis, axis_of
from gyrostat.reports.chart import Chart
from gyrostat.scenario import Scenario
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.requirement import Requirement

if TYPE_CHECKING:
    from gyrostat.core.types import Matrix, Vector

BANDS = ((5.0, 95.0, "wide"), (25.0, 75.0, "narrow"))
"""Percentiles of the runs between which a band is drawn, and its class."""
ERRORS = ("error_max", "error_end", "crossing_peak")
"""Metrics that are a pointing error at some time, beside its percentiles."""


def verdicts(scenario: Scenario, columns: "Mapping[str, Vector]", store: Store) -> list[Verdict]:
    """Verdict on each requirement of a finished campaign."""
    results = []
    with store.open_table() as file:
        for each in scenario.requirements:
            totals = np.zeros(1)
            if each.interpretation == "mixed":
                runs = len(columns["status"])
                for part in list_parts(file, counts_name(each.metric), runs):
                    totals = totals + part.sum(axis=0)
            results.append(judged(each, columns[each.metric], columns["status"], totals))
    return results


def content(verdict: Verdict) -> dict[str, Any]:
    """Entry of report.json of a verdict, SI units."""
    each = verdict.requirement
    return {
        "name": each.name,
        "requirement": requirement_text(each),
        "index": each.index,
        "interpretation": each.interpretation,
        "level": each.level,
        "share_of_runs": each.share if each.interpretation == "temporal" else None,
        "required": each.value,
        "verdict": verdict.verdict,
        "why": verdict.why,
        "size": _numbers(verdict.size),
        "size_is_limit": verdict.is_limit,
        "within": _numbers(verdict.share),
        "margin": _numbers(verdict.margin),
        "runs": verdict.runs,
        "runs_without_values": verdict.without,
        "runs_needed": verdict.needed,
    }


def _numbers(estimate: Estimate) -> dict[str, float | None]:
    return {name: or_none(value) for name, value in estimate._asdict().items()}


def line(entry: dict[str, Any]) -> str:
    """Verdict as a line for a terminal."""
    return (
        f"  requirement {entry['name']}: {entry['verdict'].upper()}, {entry['requirement']}: found "
        f"{size_text(entry)} ({interval_text(entry)}), margin {margin_text(entry)}; {entry['why']}"
    )


def size_text(entry: dict[str, Any]) -> str:
    """Size that is not exceeded at the level, as text."""
    value = entry["size"]["value"]
    if value is None:
        return "not determined"
    return ("at most " if entry["size_is_limit"] else "") + angle_text(value, entry["required"])


def interval_text(entry: dict[str, Any]) -> str:
    """Confidence limits of the size as text, also if one is missing."""
    low, high = entry["size"]["low"], entry["size"]["high"]
    texts = [angle_text(each, entry["required"]) for each in (low, high)]
    if not low and high is None:
        return "without confidence limits"
    if high is None:
        return f"95 % confidence: at least {texts[0]}"
    if not low:
        return f"95 % confidence: at most {texts[1]}"
    return f"95 % confidence: {texts[0]} to {texts[1]}"


def margin_text(entry: dict[str, Any]) -> str:
    """Margin at the upper confidence limit as text; without it, that at the lower limit."""
    low, high = entry["margin"]["low"], entry["margin"]["high"]
    if low is None and (high is None or high >= 1.0):
        return "not determined"
    margin = 100.0 * (high if low is None else low)
    text = f"{margin:.3g} %" if abs(margin) < 1000.0 else f"{margin:.0f} %"
    return f"at most {text}" if low is None else text


def required_in(scenario: Scenario, metric: str) -> list[tuple[float, str]]:
    """Required values that have a meaning for a metric, SI, each with its text.

    These are the value of the requirement whose metric it is, or its allowed share of time; and for
    metrics that are a pointing error at some time, the required value of this error.

    Args:
        scenario: Scenario.
        metric: Name of the metric.
    """
    pairs = []
    window = metrics_of(scenario)[metric].window or ""
    quantity = metric.removeprefix(f"{window}.")
    is_error = quantity in ERRORS or quantity.startswith("error_p")
    for each in scenario.requirements:
        if each.metric == metric:
            if each.interpretation == "mixed":
                share = 1.0 - each.level
                pairs.append((share, f"allowed {100.0 * share:.3g} %"))
            else:
                pairs.append((each.value, f"required {angle_text(each.value, each.value)}"))
        elif is_error and window in ("", *each.during) and _is_error_of(each, scenario, window):
            pairs.append((each.value, f"{each.name} {angle_text(each.value, each.value)}"))
    return pairs


def _is_error_of(each: Requirement, scenario: Scenario, window: str) -> bool:
    """Whether the index of a requirement is the pointing error of the run, or of a window."""
    if not window:
        return is_of_error(each, scenario)
    axis = next(w.boresight for w in scenario.windows if w.name == window)
    boresight = axis or scenario.boresight
    error_axis = "full" if boresight is None else "half_cone"
    return each.index == "APE" and each.axis == error_axis and each.boresight == boresight


def over_time_charts(scenario: Scenario, store: Store) -> list[Markup]:
    """Charts with bands of the pointing error, and of each required index, over time.

    The bands are percentiles over at most 1000 runs at each time.

    Args:
        scenario: Scenario.
        store: Folder of the finished campaign.
    """
    of_error = [each for each in scenario.requirements if is_of_error(each, scenario)]
    errors = [(each.value, each.name) for each in of_error]
    labels = {ERROR_PROFILE: ("pointing error", errors)}
    for each in scenario.requirements:
        if each in of_error:
            continue
        text = f"{each.index} of {each.name}" if each.name != each.index.lower() else each.index
        labels[profile_name(each.metric)] = (text, [(each.value, "")])
    with store.open_table() as file:
        parts = {name: [*list_parts(file, name, PROFILED)] for name in labels}
    profiles = {name: np.concatenate(series) for name, series in parts.items() if series}
    if not profiles:
        return []
    times = scenario.values["run.control_period"] * instants(scenario.count + 1).astype(float)
    # one axis for all, because they are zoomed together
    has_values = [np.any(np.isfinite(values), axis=0) for values in profiles.values()]
    span = times[np.any(has_values, axis=0)]
    x = Axis(float(span[0]), float(span[-1]), "time (s)")
    return [_band_chart(x, times, values, *labels[name]) for name, values in profiles.items()]


def _band_chart(
    x: Axis, times: "Vector", values: "Matrix", label: str, required: list[tuple[float, str]]
) -> Markup:
    """Chart of the bands of one quantity."""
    has_values = np.sum(np.isfinite(values), axis=0) > 0
    times, values = times[has_values], values[:, has_values]
    is_small = bool(required) and all(value < SMALL for value, _ in required)
    scale = 1.0 / ARCSECOND if is_small else math.degrees(1.0)
    values = values * scale
    percentiles = [*(end for low, high, _ in BANDS for end in (low, high)), 50.0, 100.0]
    *edges, middle, largest = np.nanpercentile(values, percentiles, axis=0)
    limits = np.array([scale * value for value, _ in required])
    is_log = 0.0 < 50.0 * np.median(middle) < np.max(largest)
    extents = np.concatenate([largest, limits, edges[0] if is_log else [0.0]])
    y = axis_of(extents, "", is_log=is_log)
    y = y if is_log else y._replace(low=0.0)
    title = f"{label} ({'arcsec' if is_small else 'deg'})"
    chart = Chart(title, x, y, {"group": "time"})
    for k, (*_, kind) in enumerate(BANDS):
        chart.band(times, edges[2 * k], edges[2 * k + 1], kind)
    chart.line(times, middle, "median", "s0")
    chart.line(times, edges[1], "95 %", "hidden")
    chart.line(times, largest, "largest", "thin")
    for value, name in required:
        text = f"{name} {angle_text(value, value)}".strip()
        chart.level(value * scale, text, "required")
    return chart.svg()
