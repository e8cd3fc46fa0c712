"""Report of a search for the worst case: the case, its values, and what each contributes."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gyrostat.campaigns import Store
from gyrostat.core.text import or_none
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.page_units import labelled, page_unit, shown_unit, told, told_in
from gyrostat.reports.template import render
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.unlikely import unlikely_numbers
from gyrostat.search.worst import at_bound
from gyrostat.search.worst_case import FoundWorst, found_worst

AT_BOUND = 0.99
"""Coordinate from which a value is said to be at its bound."""
MUCH_NOISE = 0.5
"""Share of the variance from which noise is said to drive the metric."""


def worst_page(folder: Path, command: str, address: str) -> tuple[dict[str, Any], str, list[str]]:
    """Content of report.json, page, and lines for a terminal, of a finished search.

    Args:
        folder: Folder of the search.
        command: Command line that produced the report.
        address: Address of the folder for the reader.

    Raises:
        InputError: The folder has no finished search.
    """
    search = found_worst(folder)
    content = _content(search, Store(folder))

    page = render(
        "worst_case.html",
        scenario=search.stored.scenario,
        content=content,
        figure=figure_charts(progress_figure(search)),
        told_key=lambda key, value, unit: told_in(value, *page_unit(key, unit)),
        folder=address,
        command=command,
    )
    return content, page, _lines(content)


def _content(search: FoundWorst, store: Store) -> dict[str, Any]:
    """Content of report.json, SI units."""
    worst, scenario, campaign = search.worst, search.stored.scenario, search.stored.campaign
    entries, name = numbers_of(scenario), search.question.metric
    metric = name, metrics_of(scenario)[name].unit
    with np.errstate(invalid="ignore"):  # of equal infinite responses
        effect = worst.response - worst.without
    # infinite differences, of runs that end early, come first
    order = np.argsort(-effect, kind="stable")  # NaN last
    keys = scenario.dispersed
    return {
        "kind": "worst case",
        "scenario": scenario.name,
        "unlikely": unlikely_numbers(scenario),
        "digest": campaign.digest,
        "seed": campaign.seed,
        "runs": len(search.stored.columns["run"]),
        "metric": name,
        "within": search.question.within,
        "worst": or_none(worst.response),
        "outcome": outcome(worst.response, *metric),
        "run": worst.number,
        "doubts": [*search.doubts()],
        "kept": worst.number in store.histories(campaign),
        "worst_of_random": or_none(worst.random),
        "outcome_of_random": outcome(worst.random, *metric),
        "random_runs": worst.independent,
        "noise_share": or_none(worst.noise_share),
        "noise_drives": bool(worst.noise_share > MUCH_NOISE),
        "not_allowed": search.refused,
        "values": [
            {
                "key": keys[k],
                "value": float(search.stored.columns[keys[k]][worst.number]),
                "nominal": scenario.values[keys[k]],
                "unit": entries[keys[k]].unit,
                "place": float(worst.coordinates[k]),
                "at": at_bound(float(worst.coordinates[k]), AT_BOUND),
                "worst_at_nominal": or_none(float(worst.without[k])),
                "outcome_at_nominal": outcome(float(worst.without[k]), *metric),
            }
            for k in order
        ],
        "engine": dict(campaign.engine),
    }


def outcome(response: float, metric: str, unit: str) -> str:
    """Response of a run as text, with a reason for one that is no number.

    Args:
        response: Metric; infinite for a run that ends early or never settles, minus infinity for
            one without the metric, NaN for one that was not simulated.
        metric: Name of the metric.
        unit: Its SI unit.
    """
    if np.isfinite(response):
        return told(response, unit)
    if np.isnan(response):
        return "not simulated"
    if response < 0.0:
        return f"no {metric}"
    return "never settles" if metric.split(".")[-1] == "settling" else "ends early"


def _lines(content: dict[str, Any]) -> list[str]:
    """The outcome as lines for a terminal."""
    lines = [
        f"{content['runs']} runs of {content['scenario']}, worst {content['metric']} within "
        f"{content['within']}: {content['outcome']}, run {content['run']} (worst of "
        f"{content['random_runs']} independent runs: {content['outcome_of_random']})"
    ]
    if content["doubts"]:
        return [*lines, *(f"  no worst case: {doubt}" for doubt in content["doubts"])]
    causes = []
    for each in content["values"][:3]:
        position = f"at its {each['at']}" if each["at"] else f"at {each['place']:+.0%} of its bound"
        causes.append(f"{each['key']} {position}")
    lines.append(f"  by {', '.join(causes)}")
    if content["noise_drives"]:
        share = f"{content['noise_share']:.0%} of the variance over all runs"
        lines.append(f"  noise drives it: {share} is due to sensor noise")
    return lines


def progress_figure(found: FoundWorst) -> Figure:
    """Plot the metric of every run, and the worst so far, over the number of the run."""
    name = found.question.metric
    scale, unit = shown_unit(metrics_of(found.stored.scenario)[name].unit)
    value = found.question.response(found.stored.columns) * scale
    value = np.where(np.isfinite(value), value, np.nan)
    largest = np.fmax.accumulate(value)
    with panels(width=7.0, height=3.2, layout=None) as (figure, axes):
        runs = np.arange(len(value))
        axes.plot(runs, value, ".", ms=1.2, color=MEASURED, rasterized=True)
        axes.step(runs, largest, where="post", color=MODEL, lw=1.4)
        axes.plot(found.worst.number, value[found.worst.number], "o", ms=5, mfc="none", color=MARK)
        axes.set_xlabel("run")
        axes.set_ylabel(literal(labelled(name, unit)))
        figure.tight_layout()
    return figure
