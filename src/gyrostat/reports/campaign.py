"""Report of a campaign: distributions, percentiles, drivers and worst runs."""

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat.campaigns import Campaign, Scenario, Store, Window, worst_runs
from gyrostat.campaigns.blocks import columns_of
from gyrostat.campaigns.drivers import find_drivers
from gyrostat.campaigns.metrics.results import metrics_of, percentile_name
from gyrostat.campaigns.pointing.text import angle_text
from gyrostat.campaigns.summary import percentile_of
from gyrostat.core.text import or_none
from gyrostat.reports import requirements
from gyrostat.reports.campaign_run import IN_DEGREES, run_page, told
from gyrostat.reports.drawing import MARK, MODEL, STYLE, literal, svg
from gyrostat.reports.template import render
from gyrostat.simulation import Status

if TYPE_CHECKING:
    from gyrostat.core.types import Vector

PERCENTILES = (50.0, 95.0, 99.7)
"""Percentiles of the runs in the report."""
SHOWN = 5
"""Number of drivers per metric in the table, and of worst runs."""


def write_campaign(folder: Path, *, command: str, say: Callable[[str], None]) -> str:
    """Write report.json and report.html of a finished campaign, and print a summary.

    Args:
        folder: Folder of the campaign.
        command: Command line that produced the report.
        say: Called with each line of the summary.

    Returns:
        Text of report.json.

    Raises:
        InputError: The folder has no finished campaign, or cannot be written.
    """
    store = Store(folder, say)
    known = store.known()
    with store.locked():
        store.mend(known)
    content, page, lines = _page_of(known)(folder, command)
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    with store.locked(), store.results(known) as scratch:
        (scratch / "report.json").write_text(text + "\n", encoding="utf-8")
        (scratch / "report.html").write_text(page, encoding="utf-8")
    for line in lines:
        say(line)
    say(f"written: {folder / 'report.html'}, {folder / 'report.json'}, {store.table}")
    return text


def _page_of(known: Campaign) -> "Callable[[Path, str], tuple[dict[str, Any], str, list[str]]]":
    """Function of folder and command that gives report.json, page and lines for a terminal."""
    if known.search is None:
        return _campaign_page
    from gyrostat.campaigns.search.rare import RARE
    from gyrostat.campaigns.search.tuning import FREE
    from gyrostat.campaigns.search.worst_case import WORST_CASE
    from gyrostat.reports.rare import rare_page
    from gyrostat.reports.tuning import tuning_page
    from gyrostat.reports.worst_case import worst_page

    return {RARE: rare_page, WORST_CASE: worst_page, FREE: tuning_page}[next(iter(known.search))]


def _campaign_page(folder: Path, command: str) -> tuple[dict[str, Any], str, list[str]]:
    """Content of report.json, page, and lines for a terminal, of a finished campaign."""
    store = Store(folder)
    known = store.known()
    scenario, columns = Scenario.from_text(known.scenario), columns_of(store.read_table())
    content = _content(scenario, known, columns, store)
    page = render(
        "campaign.html",
        scenario=scenario,
        known=known,
        content=content,
        parts=_parts(scenario, columns),
        over_time=_over_time(scenario, store),
        angle=angle_text,
        metrics=metrics_of(scenario),
        told=told,
        told_percentile=told_percentile,
        folder=folder,
        command=command,
    )
    return content, page, _lines(scenario, content)


def _over_time(scenario: Scenario, store: Store) -> str | None:
    """Figure of the errors over time."""
    figure = requirements.over_time_figure(scenario, store)
    return None if figure is None else svg(figure)


def _parts(scenario: Scenario, columns: "dict[str, Vector]") -> list[dict[str, Any]]:
    """Sections of the page: the whole run, and each window."""
    metrics = metrics_of(scenario)
    parts = []
    for window in (None, *scenario.windows):
        own = None if window is None else window.name
        names = [name for name, metric in metrics.items() if metric.window == own]
        parts.append(
            {
                "window": own,
                "text": None if window is None else window_text(scenario, window),
                "names": names,
                "figure": svg(distribution_figure(scenario, columns, names)),
            }
        )
    return parts


def window_text(scenario: Scenario, window: Window) -> str:
    """Times and boresight of a window as a sentence."""
    begin, end = (scenario.values[f"window.{window.name}.{key}"] for key in ("from", "until"))
    after = default = ""
    if window.event is not None:
        after, default = f" after {window.event}", "the next slew or "
    if window.mode is not None:
        after, default = f" after the start of mode {window.mode}", "its end or "
    default += "the end of the run"
    text = f"From {begin:g} s to {f'{end:g} s' if end < math.inf else default}{after}"
    boresight = window.boresight or scenario.boresight
    if boresight is None:
        return f"{text}; full attitude error."
    return f"{text}; boresight {', '.join(f'{part:.4g}' for part in boresight)} in body axes."


def _content(
    scenario: Scenario, known: Campaign, columns: "dict[str, Vector]", store: Store
) -> dict[str, Any]:
    """Content of report.json, SI units."""
    status, keys = columns["status"], scenario.dispersed
    drawn = np.stack([columns[key] for key in keys], axis=1)
    ended = {
        kind.name.lower(): int(np.sum(status == kind)) for kind in Status if np.any(status == kind)
    }
    bad = np.flatnonzero(status != Status.COMPLETE)
    known_metrics = metrics_of(scenario)
    driving = find_drivers(drawn, np.stack([columns[name] for name in known_metrics], axis=1))
    metrics: dict[str, Any] = {}
    for (name, metric), rho, level in zip(
        known_metrics.items(), driving.rank_correlation.T, driving.chance_level, strict=True
    ):
        found = [percentile_of(columns[name], percent) for percent in PERCENTILES]
        order = [k for k in np.argsort(-np.abs(rho)) if np.isfinite(rho[k])]
        metrics[name] = {
            "unit": metric.unit,
            "window": metric.window,
            "runs": int(np.sum(np.isfinite(columns[name]))),
            "percentiles": [{k: or_none(v) for k, v in vars(p).items()} for p in found],
            "chance_level": or_none(float(level)),
            "drivers": [
                {
                    "key": keys[k],
                    "rank_correlation": float(rho[k]),
                    "beyond_chance": bool(abs(rho[k]) > level),
                }
                for k in order
            ],
        }
    ranked = percentile_name(scenario.percentiles[-1])
    kept = store.histories(known)

    def worst(metric: str) -> dict[str, Any]:
        runs = [
            {"run": run, "value": or_none(float(columns[metric][run])), "kept": run in kept}
            for run in worst_runs(store, SHOWN, metric)
        ]
        return {"worst_by": metric, "worst": runs}

    return {
        "scenario": scenario.name,
        "digest": known.digest,
        "seed": known.seed,
        "runs": known.runs,
        "ended": ended,
        "not_complete": [
            {
                "run": int(k),
                "status": Status(status[k]).name.lower(),
                "ended": float(columns["ended"][k]),
            }
            for k in bad[:100]
        ],
        "requirements": [
            requirements.content(each) for each in requirements.verdicts(scenario, columns, store)
        ],
        "chance_level": metrics[ranked]["chance_level"],
        "metrics": metrics,
        **worst(ranked),
        "windows": {w.name: worst(f"{w.name}.{ranked}") for w in scenario.windows},
        "engine": dict(known.engine),
    }


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


def _lines(scenario: Scenario, content: dict[str, Any]) -> list[str]:
    """The outcome as lines for a terminal."""
    ended = ", ".join(
        f"{count} {kind.replace('_', ' ')}" for kind, count in content["ended"].items()
    )
    lines = [f"{content['runs']} runs of {scenario.name}: {ended}"]
    own = content["metrics"][content["worst_by"]]
    for entry in own["percentiles"]:
        value, low, high = told_percentile(entry, own["unit"])
        lines.append(
            f"  {content['worst_by']}: {entry['percent']:g} % of the runs stay below {value} "
            f"(95 % confidence: {low} to {high})"
        )
    driving = [driver for driver in own["drivers"] if driver["beyond_chance"]]
    if driving:
        told_of = ", ".join(f"{d['key']} ({d['rank_correlation']:+.2f})" for d in driving[:3])
        lines.append(f"  driven by {told_of}, by rank correlation")
    return lines + [requirements.line(entry) for entry in content["requirements"]]


def distribution_figure(
    scenario: Scenario, columns: "dict[str, Vector]", names: Sequence[str]
) -> Figure:
    """Plot a histogram of every metric that differs between runs, with its 99.7 % percentile.

    Args:
        scenario: Scenario of the campaign.
        columns: Columns of the table of runs.
        names: Names of the metrics.
    """
    metrics = metrics_of(scenario)
    finite = {name: columns[name][np.isfinite(columns[name])] for name in names}
    shown = [name for name, values in finite.items() if len(values) and np.ptp(values) > 0.0]
    count = max(len(shown), 1)
    with mpl.rc_context(STYLE):
        height = -(-count // 3)
        figure = Figure(figsize=(9.0, 1.9 * height + 0.2))
        grid = np.atleast_1d(figure.subplots(height, 3)).ravel()
        for axes, name in zip(grid, shown, strict=False):
            unit = metrics[name].unit
            values = np.degrees(finite[name]) if unit in IN_DEGREES else finite[name]
            axes.stairs(
                *np.histogram(values, bins=min(50, 5 + len(values) // 10)), fill=True, color=MODEL
            )
            requirements.mark_required(axes, scenario, name)
            mark = percentile_of(values, PERCENTILES[-1]).value
            axes.axvline(mark, color=MARK, lw=0.9, ls="--")
            unit = IN_DEGREES.get(unit, unit)
            axes.set_xlabel(literal(name if unit == "1" else f"{name} ({unit})"))
            # long numbers would overlap
            axes.locator_params(axis="x", nbins=5)
            axes.ticklabel_format(axis="x", scilimits=(-2, 5))
        for axes in grid[len(shown) :]:
            axes.set_visible(False)
        figure.tight_layout()
    return figure


def write_replay(
    known: Campaign, path: Path, run: int, *, command: str, say: Callable[[str], None]
) -> None:
    """Write the HTML page of a replayed run beside its history.

    Args:
        known: The campaign.
        path: File of the history.
        run: Number of the run.
        command: Command line that produced it.
        say: Called with each line of the summary.

    Raises:
        InputError: The page cannot be written.
    """
    import xarray as xr

    scenario = Scenario.from_text(known.scenario)
    store = Store(path.parents[1], say)
    table = store.read_table()
    values = {name: table[name][run].as_py() for name in table.column_names}
    with xr.open_dataset(path, engine="h5netcdf") as history:
        page = run_page(scenario, values, history, f"{scenario.name}, run {run}", command)
    with store.locked(), store.results(known) as scratch:
        (scratch / "runs" / path.with_suffix(".html").name).write_text(page, encoding="utf-8")
    say(f"run {run} replayed: all numbers equal those of the table of runs, bit for bit")
    say(f"written: {path}, {path.with_suffix('.html')}")
