"""Report of one run of a scenario."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from gyrostat.campaigns.metrics.results import metrics_of
from gyrostat.campaigns.pointing.text import required_errors
from gyrostat.campaigns.scenario import Scenario
from gyrostat.core.outputs import new_files
from gyrostat.core.text import plain
from gyrostat.core.units import RPM
from gyrostat.reports.drawing import MARK, STYLE, literal, svg
from gyrostat.reports.replay import replay_data
from gyrostat.reports.template import render
from gyrostat.simulation import Status

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.campaigns.engine import Flown

LEAST_SHOWN = 1e-5
"""Smallest value drawn, deg; smaller ones are rounding errors."""

IN_DEGREES = {"rad": "deg", "rad/s": "deg/s"}
"""Unit of a metric -> unit in which reports show it."""


def write_run(
    scenario: Scenario,
    flown: "Flown",
    out: Path,
    *,
    command: str,
    say: Callable[[str], None],
    force: bool = False,
) -> None:
    """Write the histories of a run and its HTML page beside them, and print a summary.

    Args:
        scenario: Scenario of the run.
        flown: One run with its histories.
        out: netCDF file; the page has the same name with the suffix .html.
        command: Command line that produced the run.
        say: Called with each line of the summary.
        force: Whether to replace files that `simulate` did not write; see `gyrostat.core.outputs`.

    Raises:
        InputError: A file of the user is in the way, or a file cannot be written.
    """
    values = {name: column[0].item() for name, column in flown.columns.items()}
    assert flown.histories is not None
    history = flown.histories.isel(run=0)
    page = out.with_suffix(".html")
    text = run_page(scenario, values, history, scenario.name, command)
    with new_files(out.parent, by="simulate", force=force) as folder:
        history.to_netcdf(folder / out.name, engine="h5netcdf")
        (folder / page.name).write_text(text, encoding="utf-8")
    say(_verdict(values))
    for name, entry in metric_rows(scenario, values):
        say(f"  {name}: {entry}")
    say(f"written: {out}, {page}")


def run_page(
    scenario: Scenario, values: Mapping[str, Any], history: "xr.Dataset", title: str, command: str
) -> str:
    """HTML page of a run.

    Args:
        scenario: Scenario of the run.
        values: Row of the run in the table of runs.
        history: Histories of the run.
        title: Title of the page.
        command: Command line that produced the run.
    """
    return render(
        "campaign_run.html",
        title=title,
        verdict=_verdict(values),
        fine=values["status"] == 0,
        rows=metric_rows(scenario, values),
        drawn=[(key, f"{values[key]:.9g}") for key in scenario.dispersed],
        figure=svg(run_figure(scenario, history)),
        motion=replay_data(scenario, values, history),
        command=command,
    )


def _verdict(values: Mapping[str, Any]) -> str:
    status = Status(values["status"])
    if status == Status.COMPLETE:
        return f"complete, {values['ended']:g} s"
    return f"NOT complete: {status.name.lower().replace('_', ' ')} after {values['ended']:g} s"


def told(value: float | None, unit: str, digits: int = 4) -> str:
    """Format a value with a number of significant digits; angles and rates in degrees."""
    if value is None or not math.isfinite(value):
        return "none"
    if unit in IN_DEGREES:
        value, unit = math.degrees(value), IN_DEGREES[unit]
    return plain(value, digits) if unit == "1" else f"{plain(value, digits)} {unit}"


def metric_rows(scenario: Scenario, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Metrics as pairs of name and entry."""
    metrics = metrics_of(scenario)
    return [(name, told(float(values[name]), each.unit)) for name, each in metrics.items()]


def run_figure(scenario: Scenario, history: "xr.Dataset") -> Figure:
    """Plot pointing error, body rate, wheel speeds and motor torques over time, with the events.

    Args:
        scenario: Scenario of the run.
        history: Histories of the run.
    """
    time = history.time.values
    every = slice(None, None, max(1, len(time) // 6000))
    time = time[every]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 7.4))
        figure.subplots_adjust(left=0.1, right=0.98, bottom=0.065, top=0.985, hspace=0.14)
        rows = figure.subplots(4, 1, sharex=True, height_ratios=[1.3, 1.0, 1.4, 1.0])
        error = np.maximum(np.degrees(history.error.values[every]), LEAST_SHOWN)
        rate = np.degrees(np.linalg.norm(history.rate.values[every], axis=1))
        rows[0].semilogy(time, error, lw=1.2)
        for value in required_errors(scenario):
            rows[0].axhline(math.degrees(value), color="black", lw=0.9, ls="--")
        rows[1].semilogy(time, np.maximum(rate, LEAST_SHOWN), lw=1.2)
        for k, name in enumerate(map(literal, scenario.wheels)):
            rows[2].plot(time, history.wheel_speed.values[every, k] / RPM, lw=1.2, label=name)
            rows[3].step(time, history.torque.values[every, k] * 1e3, where="post", lw=0.8)
        rows[2].axhline(0.0, lw=0.6, color="#6b7077")
        rows[2].legend(loc="upper right", ncols=len(scenario.wheels), title="wheel")
        for axes in rows[:2]:
            axes.yaxis.set_minor_locator(NullLocator())  # a third of the time of the figure
        labels = ("pointing error (deg)", "body rate (deg/s)", "wheel speed (rpm)", "torque (mN·m)")
        for axes, label in zip(rows, labels, strict=True):
            axes.set_ylabel(label)
            for event in scenario.events:
                axes.axvline(
                    scenario.values[f"event.{event.name}.time"], color=MARK, lw=0.9, ls=":"
                )
        for event in scenario.events:
            at = scenario.values[f"event.{event.name}.time"]
            place = (at, 0.97), ("data", "axes fraction")
            name = f" {literal(event.name)}"
            rows[0].annotate(name, place[0], xycoords=place[1], color=MARK, va="top")
        rows[3].set_xlabel("time (s)")
        figure.align_ylabels(rows)
    return figure
