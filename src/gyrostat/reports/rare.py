"""Report of a search for rare failures: probability, its interval, and what failures share."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gyrostat.campaigns import Campaign, Store
from gyrostat.core.text import or_none
from gyrostat.core.types import Matrix, Vector
from gyrostat.reports.colours import BAND, MARK, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.page_units import labelled, shown_unit, told
from gyrostat.reports.template import render
from gyrostat.scenario import Scenario
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.unlikely import unlikely_numbers
from gyrostat.search.rare import Found, found_failures
from gyrostat.search.subset import REACHED

LISTED = 100
"""Number of failing runs in report.json."""
POINTS = 200
"""Number of points of a curve."""


def rare_page(folder: Path, command: str, address: str) -> tuple[dict[str, Any], str, list[str]]:
    """Content of report.json, page, and lines for a terminal, of a finished search.

    Args:
        folder: Folder of the search.
        command: Command line that produced the report.
        address: Address of the folder for the reader.

    Raises:
        InputError: The folder has no finished search.
    """
    store = Store(folder)
    campaign = store.known()
    scenario, search = Scenario.from_text(campaign.scenario), found_failures(folder)
    content = _content(scenario, campaign, search, store)
    unit = metrics_of(scenario)[search.condition.metric].unit
    page = render(
        "rare.html",
        scenario=scenario,
        content=content,
        figure=figure_charts(exceedance_figure(scenario, search)),
        probability=probability_text(content),
        closest=closest_text(scenario, content),
        told=lambda value: told(value, unit),
        folder=address,
        command=command,
    )
    return content, page, lines(scenario, content)


def _content(scenario: Scenario, campaign: Campaign, search: Found, store: Store) -> dict[str, Any]:
    """Content of report.json, SI units."""
    result, value = search.rarity, search.columns[search.condition.metric]
    response = search.condition.response(search.columns)
    order = np.argsort(-response, kind="stable")
    failures = order[response[order] > 0.0]
    histories = store.histories(campaign)
    return {
        "kind": "rare",
        "scenario": scenario.name,
        "unlikely": unlikely_numbers(scenario),
        "digest": campaign.digest,
        "seed": campaign.seed,
        "runs": len(value),
        "failure": search.condition.text,
        "metric": search.condition.metric,
        "bound": search.condition.bound,
        "probability": result.probability,
        "low": result.low,
        "high": result.high,
        "below": result.below,
        "coefficient_of_variation": result.variation,
        "trusted": not result.doubts,
        "doubts": [*result.doubts],
        "replications": [
            {
                "probability": or_none(each.probability),
                "ended": each.ended,
                "levels": [or_none(level.bound) for level in each.levels],
                "accepted": [or_none(level.accepted) for level in each.levels],
            }
            for each in search.replications
        ],
        "not_allowed": search.refused,
        "failing_runs": len(failures),
        "failures": [
            {"run": int(run), "value": or_none(float(value[run])), "kept": int(run) in histories}
            for run in failures[:LISTED]
        ],
        "closest": _closest(value, response),
        "shared": shared(scenario, search),
        "engine": dict(campaign.engine),
    }


def _closest(value: Vector, response: Vector) -> dict[str, Any] | None:
    """Run that comes closest to the failure, and its value; None if no run has the metric."""
    run = int(np.argmax(response))
    if response[run] == -np.inf:
        return None
    return {"run": run, "value": or_none(float(value[run]))}


def shared(scenario: Scenario, found: Found) -> list[dict[str, Any]]:
    """Dispersed values of the failures, relative to those of all runs, the largest shift first.

    Returns:
        For each key: "key", "shift" (mean of the standard normal numbers of the failures) and
        "spread" (their standard deviation).
    """
    rows, weights = [], []
    for each in found.replications:
        if each.ended == REACHED:
            level = each.levels[-1]
            rows.append(level.normal[level.response > 0.0])
            weights.append(np.full(len(rows[-1]), each.probability / len(rows[-1])))
    if not rows:
        return []
    normal, weights = np.concatenate(rows), np.concatenate(weights)
    shift = np.average(normal, axis=0, weights=weights)
    spread = np.sqrt(np.average((normal - shift) ** 2, axis=0, weights=weights))
    return [
        {"key": scenario.dispersed[k], "shift": float(shift[k]), "spread": float(spread[k])}
        for k in np.argsort(-np.abs(shift))
    ]


def lines(scenario: Scenario, content: dict[str, Any]) -> list[str]:
    """The outcome as lines for a terminal."""
    texts = [
        f"{content['runs']} runs of {scenario.name}, failure: {content['failure']}",
        f"  probability of failure: {probability_text(content)}, "
        f"{content['failing_runs'] or 'no'} failing runs found",
    ]
    because = "because" if content["probability"] is None else "not to be trusted:"
    texts += [f"  {because} {doubt}" for doubt in content["doubts"]]
    shifts = [f"{each['key']} ({each['shift']:+.1f} sigma)" for each in content["shared"][:3]]
    if shifts:
        texts.append(f"  failing runs share {', '.join(shifts)}")
    if content["failures"]:
        texts.append(f"  worst of them: run {content['failures'][0]['run']}")
    else:
        texts.append(f"  {closest_text(scenario, content)}")
    return texts


def probability_text(content: dict[str, Any]) -> str:
    """Probability with its interval, or the limit below which it is."""
    if content["probability"] is None:
        return f"not determined, below {content['below']:.1e} (95 % confidence) or too few runs"
    low, high = content["low"], content["high"]
    return f"{content['probability']:.2e} (95 % confidence: {low:.1e} to {high:.1e})"


def closest_text(scenario: Scenario, content: dict[str, Any]) -> str:
    """How close a search without failing runs came to the failure."""
    metric, closest = content["metric"], content["closest"]
    if closest is None:
        return f"no run has the metric {metric}"
    value = told(closest["value"], metrics_of(scenario)[metric].unit)
    return f"closest to the failure: {metric} {value} in run {closest['run']}"


def exceedance_figure(scenario: Scenario, found: Found) -> Figure:
    """Plot the probability that the metric is beyond a value, over the value."""
    condition = found.condition
    bounds = [each.levels[1].bound for each in found.replications if len(each.levels) > 1]
    finite = [
        level.response[np.isfinite(level.response)]
        for each in found.replications
        for level in each.levels
    ]
    every = np.concatenate(finite)
    low = min(bounds, default=float(np.median(every)) if len(every) else -1.0)
    # beyond the failure few replications have flights
    high = max(0.0, float(np.max(every, initial=0.0)) * 0.5)
    response = np.linspace(low - 0.3 * (high - low), high, POINTS)
    curves = exceedance(found, response)
    value = condition.bound + (response if condition.above else -response)
    scale, unit = shown_unit(metrics_of(scenario)[condition.metric].unit)
    with panels(width=7.0, height=3.6, layout=None) as (figure, axes):
        for curve in curves:
            axes.plot(scale * value, np.where(curve > 0.0, curve, np.nan), color=BAND, lw=0.8)
        mean = np.mean(curves, axis=0)
        axes.plot(scale * value, np.where(mean > 0.0, mean, np.nan), color=MODEL, lw=1.6)
        axes.axvline(scale * condition.bound, color=MARK, lw=0.9, ls="--")
        axes.set_yscale("log")
        axes.set_xlabel(literal(labelled(condition.metric, unit)))
        axes.set_ylabel("probability of " + ("more" if condition.above else "less"))
        figure.tight_layout()
    return figure


def exceedance(found: Found, response: Vector) -> Matrix:
    """Probability of at least each response, (replications, responses)."""
    rows = []
    for each in found.replications:
        curve, before = np.zeros(len(response)), 1.0
        for level in each.levels:
            before *= level.probability
            share = np.mean(level.response[:, None] >= response, axis=0)
            curve = np.where(response >= level.bound, before * share, curve)
        rows.append(curve)
    return np.array(rows)
