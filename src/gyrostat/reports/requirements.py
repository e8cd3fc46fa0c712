"""Pointing requirements in the report of a campaign: verdicts, and errors over time."""

import math
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.campaigns import Scenario, Store
from gyrostat.campaigns.blocks import list_parts
from gyrostat.campaigns.pointing.campaign import (
    ERROR_PROFILE,
    PROFILED,
    counts_name,
    profile_name,
)
from gyrostat.campaigns.pointing.collected import instants
from gyrostat.campaigns.pointing.text import (
    ARCSECOND,
    angle_text,
    is_of_error,
    required_errors,
    requirement_text,
)
from gyrostat.campaigns.pointing.verdicts import Estimate, Verdict, judged
from gyrostat.core.text import or_none
from gyrostat.reports.drawing import BAND, MARK, MODEL, STYLE, literal

if TYPE_CHECKING:
    from gyrostat.core.types import Matrix, Vector

BANDS = ((5.0, 95.0, 0.35), (25.0, 75.0, 0.7))
"""Percentiles of the runs between which a band is drawn, and its opacity."""


def verdicts(scenario: Scenario, columns: "dict[str, Vector]", store: Store) -> list[Verdict]:
    """Verdict on each requirement of a finished campaign."""
    found = []
    with store.open_table() as file:
        for each in scenario.requirements:
            totals = np.zeros(1)
            if each.interpretation == "mixed":
                runs = len(columns["status"])
                for part in list_parts(file, counts_name(each.metric), runs):
                    totals = totals + part.sum(axis=0)
            found.append(judged(each, columns[each.metric], columns["status"], totals))
    return found


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
    margin = entry["margin"]["low"]
    size, low, high = (
        angle_text(entry["size"][name], entry["required"]) for name in ("value", "low", "high")
    )
    told = "none" if margin is None else f"{100.0 * margin:.3g} %"
    return (
        f"  requirement {entry['name']}: {entry['verdict'].upper()}, {entry['requirement']}: found "
        f"{size} (95 % confidence: {low} to {high}), margin {told}; {entry['why']}"
    )


def mark_required(axes: Axes, scenario: Scenario, metric: str) -> None:
    """Draw the required value, deg, or the allowed share of time, in a histogram of the metric.

    Args:
        axes: Axes of the histogram.
        scenario: Scenario.
        metric: Name of the metric.
    """
    for each in scenario.requirements:
        if each.metric == metric:
            value = 1.0 - each.level if each.interpretation == "mixed" else math.degrees(each.value)
            axes.axvline(value, color="black", lw=1.2, ls=":")


def over_time_figure(scenario: Scenario, store: Store) -> Figure | None:
    """Plot bands of the pointing error, and of each required index, over time; None without data.

    The bands are percentiles over at most 1000 runs at each time.

    Args:
        scenario: Scenario.
        store: Folder of the finished campaign.
    """
    labels = {ERROR_PROFILE: ("pointing error", required_errors(scenario))}
    for each in scenario.requirements:
        if is_of_error(each, scenario):
            continue
        text = f"{each.index} of {each.name}" if each.name != each.index.lower() else each.index
        labels[profile_name(each.metric)] = (text, [each.value])
    with store.open_table() as file:
        parts = {name: [*list_parts(file, name, PROFILED)] for name in labels}
    found: dict[str, Matrix] = {n: np.concatenate(own) for n, own in parts.items() if own}
    if not found:
        return None
    times = scenario.values["run.control_period"] * instants(scenario.count + 1).astype(float)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 2.3 * len(found) + 0.3))
        grid = np.atleast_1d(figure.subplots(len(found), 1, sharex=True)).ravel()
        for axes, (name, values) in zip(grid, found.items(), strict=True):
            _band(axes, times, values, *labels[name])
        grid[-1].set_xlabel("time (s)")
        figure.tight_layout()
    return figure


def _band(axes: Axes, times: "Vector", values: "Matrix", label: str, required: list[float]) -> None:
    """Draw the bands of one quantity."""
    few = np.sum(np.isfinite(values), axis=0) > 0
    times, values = times[few], values[:, few]
    is_small = np.nanmax(values) < math.radians(1.0)
    scale = 1.0 / ARCSECOND if is_small else math.degrees(1.0)
    values = values * scale
    for low, high, opacity in BANDS:
        edges = np.nanpercentile(values, [low, high], axis=0)
        axes.fill_between(times, *edges, color=BAND, alpha=opacity, lw=0.0)
    axes.plot(times, np.nanmedian(values, axis=0), color=MODEL, lw=1.2)
    axes.plot(times, np.nanmax(values, axis=0), color=MODEL, lw=0.5)
    for value in required:
        axes.axhline(value * scale, color=MARK, lw=1.0, ls="--")
    axes.set_ylabel(literal(f"{label} ({'arcsec' if is_small else 'deg'})"))
    middle = np.nanmedian(values)
    if middle > 0.0 and np.nanmax(values) > 50.0 * middle:
        axes.set_yscale("log")
