"""Content of the report of a campaign: report.json, and the lines for a terminal."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.campaigns import Campaign, Store, worst_runs
from gyrostat.campaigns.run_table import RunTable
from gyrostat.core.source_digest import source_digest
from gyrostat.core.text import or_none
from gyrostat.reports import requirements
from gyrostat.reports.metric_statistics import STATISTICS_BY, metric_statistics, stored_statistics
from gyrostat.reports.mode_diagram import modes_content
from gyrostat.reports.page_units import told
from gyrostat.runs.blind_windows import blind_windows
from gyrostat.scenario import Scenario
from gyrostat.scenario.metrics.results import percentile_name
from gyrostat.scenario.mode_graph import edges
from gyrostat.scenario.timeline import branches
from gyrostat.scenario.unlikely import unlikely_numbers
from gyrostat.simulation import Status

SHOWN = 5
"""Number of worst runs, and of drivers of a metric."""
LEAST_SHOWN = 0.01
"""Total index below which an input is not named."""


def campaign_content(
    scenario: Scenario, known: Campaign, columns: RunTable, store: Store
) -> dict[str, Any]:
    """Content of report.json, SI units."""
    status = columns["status"]
    ended = {
        kind.name.lower(): int(np.sum(status == kind)) for kind in Status if np.any(status == kind)
    }
    incomplete = np.flatnonzero(status != Status.COMPLETE)
    by = source_digest()
    metrics = stored_statistics(store, known, by) if columns.is_large else None
    metrics = metrics or metric_statistics(scenario, known, columns)
    ranked = percentile_name(scenario.percentiles[-1])
    histories = store.histories(known)

    def worst(metric: str) -> dict[str, Any]:
        runs = [
            {"run": run, "value": or_none(float(columns[metric][run])), "kept": run in histories}
            for run in worst_runs(store, SHOWN, metric)
        ]
        return {"worst_by": metric, "worst": runs}

    return {
        "scenario": scenario.name,
        "headline": headline(scenario),
        "digest": known.digest,
        "seed": known.seed,
        "runs": known.runs,
        "ended": ended,
        "unlikely": unlikely_numbers(scenario),
        "blind_windows": blind_windows(scenario, columns),
        "changes_never_taken": never_taken(scenario, columns),
        "modes": modes_content(scenario, columns),
        "not_complete": [
            {
                "run": int(k),
                "status": Status(status[k]).name.lower(),
                "ended": float(columns["ended"][k]),
            }
            for k in incomplete[:100]
        ],
        "requirements": [
            requirements.content(each) for each in requirements.verdicts(scenario, columns, store)
        ],
        "chance_level": metrics[ranked]["chance_level"],
        "metrics": metrics,
        **worst(ranked),
        "windows": {w.name: worst(f"{w.name}.{ranked}") for w in scenario.windows},
        "engine": dict(known.engine),
        **({STATISTICS_BY: by} if columns.is_large else {}),
    }


def headline(scenario: Scenario) -> list[str]:
    """Metrics that are shown first: those of the requirements, or the errors in the windows.

    The error of the whole run contains the acquisition; it comes first only without either.
    """
    if scenario.requirements:
        return [each.metric for each in scenario.requirements]
    ranked = percentile_name(scenario.percentiles[-1])
    return [f"{window.name}.{ranked}" for window in scenario.windows] or [ranked]


def strongest(metric: dict[str, Any]) -> list[str]:
    """Drivers of a metric, the strongest first: by total index, or else by rank correlation.

    Args:
        metric: Entry of a metric in report.json.
    """
    keys = [driver["key"] for driver in metric["drivers"] if driver["beyond_chance"]]
    inputs = named_inputs(metric)
    if not inputs:
        return keys
    # of values that are drawn together, the one with the largest rank correlation
    order = [driver["key"] for driver in metric["drivers"]]
    return [min(each["keys"], key=order.index) for each in inputs]


def named_inputs(metric: dict[str, Any]) -> list[dict[str, Any]]:
    """Inputs of a metric whose total index is at least 1 %, with confidence above zero.

    Args:
        metric: Entry of a metric in report.json.
    """
    return [
        each
        for each in metric["effects"].get("inputs", [])
        if each["total"]["value"] >= LEAST_SHOWN and each["total"]["low"] > 0.0
    ]


def driver_rows(metric: dict[str, Any]) -> list[dict[str, Any]]:
    """Rows of the table of drivers of a metric: the strongest first, at most five.

    Each has the keys, the rank correlation of a single key, and the first-order and total index, or
    None where there are none.

    Args:
        metric: Entry of a metric in report.json.
    """
    rho = {each["key"]: each["rank_correlation"] for each in metric["drivers"]}
    indices = {tuple(each["keys"]): each for each in metric["effects"].get("inputs", [])}
    input_keys = [each["keys"] for each in named_inputs(metric)]
    listed = {key for keys in input_keys for key in keys}
    beyond = [each["key"] for each in metric["drivers"] if each["beyond_chance"]]
    rows = []
    for keys in [*input_keys, *([key] for key in beyond if key not in listed)][:SHOWN]:
        driver = indices.get(tuple(keys))
        rows.append(
            {
                "keys": keys,
                "rank_correlation": rho.get(keys[0]) if len(keys) == 1 else None,
                "beyond_chance": keys[0] in beyond,
                "first": driver and driver["first"],
                "total": driver and driver["total"],
            }
        )
    return rows


def told_effect(each: dict[str, Any]) -> str:
    """Input with its first-order and total index, %.

    Args:
        each: Input of a metric in report.json.
    """
    first, total = (round(100.0 * each[name]["value"]) for name in ("first", "total"))
    return f"{' + '.join(each['keys'])} {first} %" + (f" ({total} %)" if total != first else "")


def told_percentile(entry: dict[str, Any], unit: str) -> tuple[str, ...]:
    """Format value and confidence limits, with enough digits to distinguish unequal ones.

    Args:
        entry: Percentile as in report.json.
        unit: Unit of the metric.
    """
    names = ("value", "low", "high")
    parts = [float("nan" if entry[name] is None else entry[name]) for name in names]
    different = len({part for part in parts if np.isfinite(part)})

    def texts(digits: int) -> tuple[str, ...]:
        return tuple(told(part, unit, digits) for part in parts)

    enough = (d for d in range(4, 17) if len({*texts(d)} - {"none"}) == different)
    return texts(next(enough, 17))


def never_taken(scenario: Scenario, columns: Mapping[str, Any]) -> list[str]:
    """Changes of mode that the scenario has and no run took."""
    if not branches(scenario.parts):
        return []
    names = dict.fromkeys(edge.name for edge in edges(scenario))
    return [name for name in names if not np.nansum(np.asarray(columns[f"change.{name}"]))]


def campaign_lines(scenario: Scenario, content: dict[str, Any]) -> list[str]:
    """The outcome as lines for a terminal."""
    ended = ", ".join(
        f"{count} {kind.replace('_', ' ')}" for kind, count in content["ended"].items()
    )
    lines = [f"{content['runs']} runs of {scenario.name}: {ended}"]
    lines += [f"  {line}" for line in content["blind_windows"]]
    if content.get("changes_never_taken"):
        lines.append(f"  changes of mode never taken: {', '.join(content['changes_never_taken'])}")
    lines += [requirements.line(entry) for entry in content["requirements"]]
    for name in content["headline"]:
        if not content["requirements"]:
            lines += percentile_lines(content, name)
        lines += _driver_lines(content, name)
    if content["worst_by"] not in content["headline"]:
        line = percentile_lines(content, content["worst_by"])[-1]
        lines.append(f"{line}; whole run, with the acquisition")
    return lines + _effect_lines(content)


def percentile_lines(content: dict[str, Any], name: str) -> list[str]:
    """Percentiles of a metric over the runs, a line for each.

    Args:
        content: Content of report.json.
        name: Name of the metric.
    """
    metric, lines = content["metrics"][name], []
    for entry in metric["percentiles"]:
        value, low, high = told_percentile(entry, metric["unit"])
        lines.append(
            f"  {name}: {entry['percent']:g} % of the runs stay below {value} (95 % confidence: "
            f"{low} to {high})"
        )
    return lines


def _driver_lines(content: dict[str, Any], name: str) -> list[str]:
    """A line with the drivers of a metric; none without any."""
    drivers = [each for each in content["metrics"][name]["drivers"] if each["beyond_chance"]]
    if not drivers:
        return []
    texts = ", ".join(f"{d['key']} ({d['rank_correlation']:+.2f})" for d in drivers[:3])
    return [f"  {name}: driven by {texts}, by rank correlation"]


def _effect_lines(content: dict[str, Any]) -> list[str]:
    """A line for each metric with Sobol indices, and one for those without."""
    lines, unexplained = [], []
    for name, metric in content["metrics"].items():
        inputs, effects = named_inputs(metric), metric["effects"]
        if effects["why"] is None:
            text = ", ".join(map(told_effect, inputs[:3])) or "no value has 1 % or more"
            lines.append(f"  variance of {name}: {text}; Q² {effects['q2']:.2f}")
        elif name in content["headline"]:
            lines.append(f"  variance of {name}: {effects['why']}")
        else:
            unexplained.append(name)
    if lines:
        lines.insert(0, "  shares of the variance by each value alone (with its interactions):")
    if unexplained:
        lines.append(f"  no shares for {len(unexplained)} other metrics: see the report")
    return lines
