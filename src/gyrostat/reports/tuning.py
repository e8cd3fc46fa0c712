"""Report of a search for gains: old and new values, proof on fresh runs, and the front."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gyrostat.core.text import or_none
from gyrostat.core.types import Matrix, Vector
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.page_units import labelled, page_unit, shown_unit, told, told_in
from gyrostat.reports.template import render
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.unlikely import unlikely_numbers
from gyrostat.search.tune import COMMON, PERCENT, PROOF
from gyrostat.search.tuning import FoundTuning, TunedGains, found_tuning
from gyrostat.search.worst import at_bound

ENOUGH = 0.02
"""Relative improvement below which the given values are as good as the best found."""


def tuning_figure(found: TunedGains) -> Figure:
    """Draw the candidates of a search, from its folder."""
    return front_figure(found_tuning(found.folder))


def tuning_page(folder: Path, command: str, address: str) -> tuple[dict[str, Any], str, list[str]]:
    """Content of report.json, page, and lines for a terminal, of a finished search.

    Args:
        folder: Folder of the search.
        command: Command line that produced the report.
        address: Address of the folder for the reader.

    Raises:
        InputError: The folder has no finished search.
    """
    tuning = found_tuning(folder)
    content = _content(tuning)
    page = render(
        "tuning.html",
        scenario=tuning.stored.scenario,
        content=content,
        figure=figure_charts(front_figure(tuning)),
        value_text=value_text,
        told_key=lambda key, value, unit: told_in(value, *page_unit(key, unit), 5),
        common=COMMON,
        proof=PROOF,
        percent=PERCENT,
        folder=address,
        command=command,
    )
    return content, page, tuning_lines(content)


def _content(tuning: FoundTuning) -> dict[str, Any]:
    """Content of report.json, SI units."""
    question, tuned, scenario = tuning.question, tuning.tuned, tuning.stored.scenario
    metrics, entries, best = metrics_of(scenario), numbers_of(scenario), tuning.values()
    signs = [1.0, *(-1.0 if limit.above else 1.0 for limit in question.limits)]
    ratio, low, high = (or_none(float(each)) for each in tuned.ratio)
    return {
        "kind": "tuning",
        "scenario": scenario.name,
        "unlikely": unlikely_numbers(scenario),
        "digest": tuning.stored.campaign.digest,
        "seed": tuning.stored.campaign.seed,
        "runs": len(tuning.stored.columns["run"]),
        "candidates": len(tuned.tried),
        "minimise": question.minimise,
        "subject_to": [limit.text for limit in question.limits],
        "free": [
            {
                "key": key,
                "unit": entries[key].unit,
                "before": initial,
                "after": best[key],
                "low": bounds[0],
                "high": bounds[1],
                "at": at_bound(float(coordinate), 1.0 - ENOUGH),
            }
            for (key, bounds), initial, coordinate in zip(
                question.free.items(), question.given, tuned.best, strict=True
            )
        ],
        "metrics": [
            {
                "metric": name,
                "unit": metrics[name].unit,
                "before": or_none(float(sign * before)),
                "after": or_none(float(sign * after)),
            }
            for name, sign, before, after in zip(
                question.metrics, signs, tuned.before, tuned.after, strict=True
            )
        ],
        "ratio": ratio,
        "ratio_low": low,
        "ratio_high": high,
        "within_limits_before": bool(question.excess(tuned.before) <= 0.0),
        "within_limits": bool(question.excess(tuned.after) <= 0.0),
        "doubts": _doubts(question.metrics, tuned.after),
        "engine": dict(tuning.stored.campaign.engine),
    }


def _doubts(metrics: tuple[str, ...], after: Vector) -> list[str]:
    """Why the best candidate is no result: metrics that too many of its runs lack."""
    lacking = [name for name, value in zip(metrics, after, strict=True) if not np.isfinite(value)]
    return [
        f"{100.0 - PERCENT:g} % or more of the runs end early or have no {name}"
        for name in dict.fromkeys(lacking)
    ]


def tuning_lines(content: dict[str, Any]) -> list[str]:
    """The outcome as lines for a terminal."""
    lines = [f"{content['candidates']} candidates, {content['runs']} runs of {content['scenario']}"]
    for each in content["free"]:
        bound = f", its {each['at']}" if each["at"] else ""
        unit = "" if each["unit"] == "1" else f" {each['unit']}"
        lines.append(f"  {each['key']}: {each['before']:g} -> {each['after']:.4g}{unit}{bound}")
    lines.append(f"  {_verdict(content)}")
    for each in content["metrics"]:
        before, after = (value_text(each[when], each["unit"]) for when in ("before", "after"))
        lines.append(f"  {each['metric']}: {before} -> {after} for 95 % of {PROOF} fresh runs")
    if not content["within_limits"]:
        lines.append("  the limits are not met on fresh runs")
    return lines + [f"  no valid result: {doubt}" for doubt in content["doubts"]]


def value_text(value: float | None, unit: str) -> str:
    """Value of a metric that holds for most runs, or that there is no such value."""
    return "without a value" if value is None else told(value, unit)


def _verdict(content: dict[str, Any]) -> str:
    """Whether the best candidate is better, on fresh runs."""
    ratio, low, high = (content[name] for name in ("ratio", "ratio_low", "ratio_high"))
    if ratio is None or low is None or high is None:
        return f"{content['minimise']}: no ratio, because runs end early or do not have it"
    comparison = f"{ratio:.3f} times that before (95 % confidence: {low:.3f} to {high:.3f})"
    if content["within_limits_before"] and ratio > 1.0 - ENOUGH:
        return f"{content['minimise']}: {comparison}: the given values are as good as any found"
    return f"{content['minimise']}: {comparison}"


def front(values: Matrix) -> NDArray[np.bool_]:
    """Whether no other row is smaller in both columns, (n,), for values (n, 2)."""
    order = np.lexsort((values[:, 1], values[:, 0]))
    least = np.minimum.accumulate(values[order, 1])
    is_front = np.zeros(len(values), bool)
    is_front[order] = (values[order, 1] <= least) & np.append(True, np.diff(least) < 0.0)
    return is_front


def front_figure(found: FoundTuning) -> Figure:
    """Plot the candidates over two metrics with their front, or over time for one metric."""
    question, values = found.question, found.tuned.values
    metrics = metrics_of(found.stored.scenario)
    with panels(width=6.4, height=3.8, layout=None) as (figure, axes):
        has_limit = len(question.metrics) > 1
        fine = np.all(np.isfinite(values), axis=1)
        vertical, label = _scaled(values[:, 0], question.minimise, metrics)
        tuned = int(np.flatnonzero(np.all(found.tuned.tried == found.tuned.best, axis=1))[0])
        marks = [0, tuned]
        if not has_limit:
            axes.plot(np.flatnonzero(fine), vertical[fine], "o", ms=3.5, color=MEASURED)
            lowest = np.fmin.accumulate(np.where(fine, vertical, np.nan))
            axes.step(np.arange(len(lowest)), lowest, where="post", color=MODEL)
            axes.set_xlabel("candidate")
        else:
            limit = question.limits[0]
            sign = -1.0 if limit.above else 1.0
            across, name = _scaled(sign * values[:, 1], limit.metric, metrics)
            axes.plot(across[fine], vertical[fine], "o", ms=3.5, color=MEASURED)
            best = np.flatnonzero(fine)[front(values[fine][:, :2])]
            best = best[np.argsort(across[best])]
            axes.plot(across[best], vertical[best], ".-", color=MODEL)
            axes.plot(across[tuned], vertical[tuned], "o", color=MARK)
            axes.plot(across[0], vertical[0], "o", color=MARK, mfc="none")
            bound, _ = _scaled(np.array([limit.bound]), limit.metric, metrics)
            axes.axvline(bound[0], color=MARK, lw=0.9, ls="--")
            axes.set_xlabel(name)
            axes.set_xlim(*_range(across[fine], np.append(across[marks], bound)))
        axes.set_ylabel(label)
        axes.set_ylim(*_range(vertical[fine], vertical[marks]))
        figure.tight_layout()
    return figure


def _scaled(values: Vector, name: str, metrics: Any) -> tuple[Vector, str]:
    """Values of a metric in the unit of reports, and their label."""
    scale, unit = shown_unit(metrics[name].unit)
    return scale * values, literal(labelled(name, unit))


def _range(values: Vector, marks: Vector) -> tuple[float, float]:
    """Range of an axis with the marked values that leaves out a few far candidates."""
    marks = marks[np.isfinite(marks)]
    if len(values) == 0 and len(marks) == 0:
        return 0.0, 1.0
    high = float(np.quantile(values, 0.9)) if len(values) else -np.inf
    low, high = float(np.min([*values, *marks])), float(np.max([high, *marks]))
    margin = 0.08 * (high - low) or 0.1 * abs(high) or 1.0
    return low - margin, high + margin
