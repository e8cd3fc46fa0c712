"""Report of a campaign: distributions, percentiles, drivers and worst runs."""

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.campaigns import Campaign, Store
from gyrostat.campaigns.effects import LEAST_Q2
from gyrostat.core.errors import InputError
from gyrostat.reports import requirements
from gyrostat.reports.campaign_charts import histograms, scatter_plots, shown_metrics
from gyrostat.reports.campaign_content import (
    campaign_content,
    campaign_lines,
    driver_rows,
    percentile_lines,
    strongest,
    told_percentile,
)
from gyrostat.reports.campaign_run import run_page
from gyrostat.reports.fly import fly_content
from gyrostat.reports.fly_page import fly_page
from gyrostat.reports.kept_runs import kept_runs
from gyrostat.reports.mode_diagram import mode_diagram, percent_of
from gyrostat.reports.page_units import told
from gyrostat.reports.run_table import run_table
from gyrostat.reports.template import render
from gyrostat.runs.keep_out_times import flown_violations
from gyrostat.runs.slew_lines import blocked_turns
from gyrostat.scenario import Scenario, Window
from gyrostat.scenario.metrics.results import metrics_of

if TYPE_CHECKING:
    from gyrostat.core.types import Vector


FLY_PAGE = "fly.html"
"""Page of a campaign that flies its runs again."""


def write_campaign(
    folder: Path,
    *,
    command: str,
    say: Callable[[str], None],
    address: str | None = None,
    fly: bool = False,
    figures: str | None = None,
) -> str:
    """Write report.json and report.html of a finished campaign, and print a summary.

    Args:
        folder: Folder of the campaign.
        command: Command line that produced the report.
        say: Called with each line of the summary.
        address: Address of the folder for the reader, if the folder is a copy; None: its path.
        fly: Whether to write `FLY_PAGE` too.
        figures: Kind of a file of the figure for papers; None: there is none.

    Returns:
        Text of report.json.

    Raises:
        InputError: The folder has no finished campaign, or cannot be written; or `fly` is asked of
            a search.
    """
    store = Store(folder, say)
    campaign = store.known()
    if fly and campaign.search is not None:
        raise InputError(f"--fly: found a search in {folder}, expected a campaign")
    with store.locked():
        store.mend(campaign)
    shown = str(folder) if address is None else address
    if fly:
        flown = fly_page(store, campaign, command, say)
        with store.locked(), store.results(campaign) as scratch:
            (scratch / FLY_PAGE).write_text(flown, encoding="utf-8")
    # the report names the page that flies, if there is one
    content, page, lines = page_of(campaign)(folder, command, shown)
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    drawn = {}
    if figures is not None:
        from gyrostat.reports.campaign_figure import campaign_figure  # matplotlib is slow to import
        from gyrostat.reports.paper_figures import figure_files

        drawn = figure_files(figures, {"report": campaign_figure(store)})
    with store.locked(), store.results(campaign) as scratch:
        (scratch / "report.json").write_text(text + "\n", encoding="utf-8")
        (scratch / "report.html").write_text(page, encoding="utf-8")
        for name, picture in drawn.items():
            (scratch / name).write_bytes(picture)
    for line in lines:
        say(line)
    say(f"written: {folder / 'report.html'}, {folder / 'report.json'}, {store.table}")
    for name in [*([FLY_PAGE] if fly else []), *drawn]:
        say(f"written: {folder / name}")
    return text


def page_of(
    campaign: Campaign,
) -> "Callable[[Path, str, str], tuple[dict[str, Any], str, list[str]]]":
    """Function of folder, command and address that gives report.json, page and terminal lines."""
    if campaign.search is None:
        return _campaign_page
    from gyrostat.reports.error_budget import budget_page
    from gyrostat.reports.rare import rare_page
    from gyrostat.reports.tuning import tuning_page
    from gyrostat.reports.worst_case import worst_page
    from gyrostat.search.error_budget import BUDGET
    from gyrostat.search.rare import RARE
    from gyrostat.search.tuning import FREE
    from gyrostat.search.worst_case import WORST_CASE

    pages = {RARE: rare_page, WORST_CASE: worst_page, FREE: tuning_page, BUDGET: budget_page}
    return pages[next(iter(campaign.search))]


def _campaign_page(
    folder: Path, command: str, address: str
) -> tuple[dict[str, Any], str, list[str]]:
    """Content of report.json, page, and lines for a terminal, of a finished campaign."""
    store = Store(folder)
    campaign = store.known()
    scenario, columns = Scenario.from_text(campaign.scenario), store.columns()
    content = campaign_content(scenario, campaign, columns, store)
    names = shown_metrics(scenario, columns)
    strong = {name: strongest(content["metrics"][name]) for name in names}
    runs = [entry["run"] for entry in content["worst"] if entry["kept"]]
    runs += sorted(store.histories(campaign) - set(runs))
    run_sections = kept_runs(scenario, columns, store, runs, content["headline"][0])
    table = run_table(scenario, columns, names, scenario.dispersed)
    page = render(
        "campaign.html",
        scenario=scenario,
        known=campaign,
        content=content,
        parts=_parts(scenario, columns, names, strong),
        scatter=scatter_plots(scenario, columns, strong),
        headline=[
            line.strip() for name in content["headline"] for line in percentile_lines(content, name)
        ],
        diagram=mode_diagram(scenario, content["modes"]) if content["modes"] else None,
        over_time=requirements.over_time_charts(scenario, store),
        kept=run_sections,
        shown_runs={each["run"] for each in run_sections},
        table={**table, "folder": address},
        required=requirements,
        metrics=metrics_of(scenario),
        told=told,
        told_percentile=told_percentile,
        driver_rows=driver_rows,
        percent_of=percent_of,
        least_q2=LEAST_Q2,
        folder=address,
        fly=FLY_PAGE if (folder / FLY_PAGE).exists() else None,
        command=command,
    )
    return content, page, campaign_lines(scenario, content)


def _parts(
    scenario: Scenario,
    columns: "Mapping[str, Vector]",
    shown_names: list[str],
    strong: dict[str, list[str]],
) -> list[dict[str, Any]]:
    """Sections of the page: the whole run, and each window."""
    metrics = metrics_of(scenario)
    parts = []
    for window in (None, *scenario.windows):
        window_name = None if window is None else window.name
        names = [name for name, metric in metrics.items() if metric.window == window_name]
        drivers = {name: strong[name] for name in shown_names if name in names}
        parts.append(
            {
                "window": window_name,
                "text": None if window is None else window_text(scenario, window),
                "names": names,
                "charts": histograms(scenario, columns, drivers),
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


def write_replay(
    known: Campaign,
    path: Path,
    run: int,
    *,
    command: str,
    say: Callable[[str], None],
    fly: bool = False,
) -> None:
    """Write the HTML page of a replayed run beside its history.

    Args:
        known: The campaign.
        path: File of the history.
        run: Number of the run.
        command: Command line that produced it.
        say: Called with each line of the summary.
        fly: Whether the page has the compiled program.

    Raises:
        InputError: The page cannot be written.
    """
    import h5netcdf

    scenario = Scenario.from_text(known.scenario)
    store = Store(path.parents[1], say)
    values = store.columns().row(run)
    with h5netcdf.File(path) as history:
        flown = None
        if fly:
            own = np.array([values[key] for key in scenario.dispersed])
            runs = {f"run {run}": (run, own), "nominal": (0, None)}
            flown = fly_content(scenario, known.seed, runs, say)
        page = run_page(scenario, values, history, f"{scenario.name}, run {run}", command, flown)
        signals = {name: np.asarray(variable[...]) for name, variable in history.variables.items()}
    with store.locked(), store.results(known) as scratch:
        (scratch / "runs" / path.with_suffix(".html").name).write_text(page, encoding="utf-8")
    say(f"run {run} replayed: all numbers equal those of the table of runs, bit for bit")
    say(f"written: {path}, {path.with_suffix('.html')}")
    drawn = {key: float(values[key]) for key in scenario.dispersed}
    for line in (*blocked_turns(scenario, signals), *flown_violations(scenario, signals, drawn)):
        say(line)
