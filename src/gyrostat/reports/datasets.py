"""Text and pictures of the datasets that `simulate`, `replay` and `campaign` return."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from gyrostat.campaigns import Campaign, Store
from gyrostat.core.errors import InputError
from gyrostat.core.pictured_datasets import SCENARIO, VALUES, Run, Runs, is_whole
from gyrostat.reports.campaign import page_of
from gyrostat.reports.campaign_content import campaign_content, campaign_lines
from gyrostat.reports.campaign_figure import campaign_figure
from gyrostat.reports.campaign_run import metric_rows, run_verdict
from gyrostat.reports.chart_figure import figure_of
from gyrostat.reports.run_charts import run_charts
from gyrostat.scenario import Scenario

if TYPE_CHECKING:
    from gyrostat.campaigns.flown import Flown


def run_figure(run: Run) -> Figure:
    """Draw error, rate, wheel speeds, torques and modes of a run over time, with its events.

    Args:
        run: Histories as `simulate` returns them, or a part of their time.

    Raises:
        InputError: The dataset lacks its scenario, histories or wheels.
    """
    scenario = _scenario(run)
    names = ("time", "error", "rate", "torque", "wheel_speed")
    lacking = [name for name in names if name not in run.variables or not _is_over_time(run[name])]
    if lacking:
        raise InputError(f"plot: found no {lacking[0]} over time, expected all histories of a run")
    wheels = [str(name) for name in np.atleast_1d(run["wheel"].values)]
    if wheels != [*scenario.wheels]:
        raise InputError(
            f"plot: found the wheels {', '.join(wheels)}, expected {', '.join(scenario.wheels)}"
        )
    history = {str(name): run[name].to_numpy() for name in run.variables}
    return figure_of(run_charts(scenario, _values(run), history))


def _is_over_time(history: xr.DataArray) -> bool:
    return history.dims[:1] == ("time",) and history.size > 0


def flown_figure(scenario: Scenario, flown: "Flown") -> Figure:
    """Draw the first run of a simulation, as `run_figure` does."""
    values = {name: column[0].item() for name, column in flown.columns.items()}
    assert flown.histories is not None
    history = flown.histories.of_run(values["run"]).arrays()
    return figure_of(run_charts(scenario, values, history))


def run_lines(run: Run) -> list[str]:
    """Verdict and metrics of a run, as `gyrostat simulate` prints them."""
    scenario, values = _scenario(run), {**_values(run), "status": int(run["status"])}
    return [
        f"{scenario.name}: {run_verdict(values)}",
        *(f"  {name}: {entry}" for name, entry in metric_rows(scenario, values)),
    ]


def _scenario(run: Run) -> Scenario:
    scenario = run.encoding.get(SCENARIO)
    if scenario is None:
        raise InputError("found a dataset without its scenario, expected one as simulate gives it")
    return scenario


def _values(run: Run) -> dict[str, Any]:
    """Row of the run in a table of runs, apart from its status."""
    return {**run.attrs, **run.encoding.get(VALUES, {})}


def runs_figure(runs: Runs) -> Figure:
    """Draw the distributions of the metrics with limits; the picture of the page for a search.

    Args:
        runs: Table as `campaign` returns it, with its attribute `folder`.

    Raises:
        InputError: It is a part of the table, or lacks its folder.
    """
    return campaign_figure(_store(runs)[0])


def runs_lines(runs: Runs) -> list[str]:
    """Summary of a campaign or search, as the command line prints it."""
    store, campaign = _store(runs)
    if campaign.search is not None:
        return page_of(campaign)(Path(store.folder), "", str(store.folder))[2]
    scenario = Scenario.from_text(campaign.scenario)
    content = campaign_content(scenario, campaign, store.columns(), store)
    return campaign_lines(scenario, content)


def _store(runs: Runs) -> tuple[Store, Campaign]:
    folder = runs.attrs.get("folder")
    if folder is None:
        raise InputError("found a dataset without its folder, expected one as campaign gives it")
    if not is_whole(runs):
        raise InputError("plot: found a part of a campaign, expected all of its runs and columns")
    store = Store(Path(folder))
    return store, store.known()
