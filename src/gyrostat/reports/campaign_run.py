"""Report of one run of a scenario."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.outputs import new_files
from gyrostat.reports.page_units import page_unit, told, told_in
from gyrostat.reports.replay import replay_data
from gyrostat.reports.run_charts import run_charts
from gyrostat.reports.template import render
from gyrostat.runs.blind_windows import blind_windows
from gyrostat.scenario.kinds.orbits import planned_orbit
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.unlikely import unlikely_numbers
from gyrostat.simulation import Status

if TYPE_CHECKING:
    from gyrostat.campaigns.flown import Flown


def write_run(
    scenario: Scenario,
    flown: "Flown",
    out: Path,
    *,
    command: str,
    say: Callable[[str], None],
    force: bool = False,
    fly: Mapping[str, Any] | None = None,
) -> None:
    """Write the histories of a run and its HTML page beside them, and print a summary.

    Args:
        scenario: Scenario of the run.
        flown: One run with its histories.
        out: netCDF file; the page has the same name with the suffix .html.
        command: Command line that produced the run.
        say: Called with each line of the summary.
        force: Whether to replace files that `simulate` did not write; see `gyrostat.core.outputs`.
        fly: See `run_page`.

    Raises:
        InputError: A file of the user is in the way, or a file cannot be written.
    """
    values = {name: column[0].item() for name, column in flown.columns.items()}
    assert flown.histories is not None
    history = flown.histories.of_run(values["run"])
    page = out.with_suffix(".html")
    text = run_page(scenario, values, history.arrays(), scenario.name, command, fly)
    with new_files(out.parent, by="simulate", force=force) as folder:
        history.write(folder / out.name)
        (folder / page.name).write_text(text, encoding="utf-8")
    say(run_verdict(values))
    for name, entry in metric_rows(scenario, values):
        say(f"  {name}: {entry}")
    say(f"written: {out}, {page}")


def run_page(
    scenario: Scenario,
    values: Mapping[str, Any],
    history: Mapping[Any, Any],
    title: str,
    command: str,
    fly: Mapping[str, Any] | None = None,
) -> str:
    """HTML page of a run.

    Args:
        scenario: Scenario of the run.
        values: Row of the run in the table of runs.
        history: Histories of the run: name -> array, or what can be converted to one.
        title: Title of the page.
        command: Command line that produced the run.
        fly: What the page needs to fly the run again, see `gyrostat.reports.fly.fly_content`;
            None: it does not.
    """
    return render(
        "campaign_run.html",
        title=title,
        scenario=scenario,
        doubts=[*unlikely_numbers(scenario), *blind_windows(scenario, values)],
        verdict=run_verdict(values),
        fine=values["status"] == 0,
        rows=metric_rows(scenario, values),
        metrics=metrics_of(scenario),
        drawn=drawn_rows(scenario, values),
        charts=run_charts(scenario, values, history),
        motion=replay_data(scenario, values, history, planned_orbit(scenario)),
        command=command,
        fly=fly,
    )


def run_verdict(values: Mapping[str, Any]) -> str:
    """Whether a run reached its end, and when it ended.

    Args:
        values: Row of the run in the table of runs.
    """
    status = Status(values["status"])
    if status == Status.COMPLETE:
        return f"complete, {values['ended']:g} s"
    return f"NOT complete: {status.name.lower().replace('_', ' ')} after {values['ended']:g} s"


def drawn_rows(scenario: Scenario, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Dispersed values of a run as pairs of key and entry."""
    numbers = numbers_of(scenario)
    return [
        (key, told_in(values[key], *page_unit(key, numbers[key].unit), 9))
        for key in scenario.values
        if key in values
    ]


def metric_rows(scenario: Scenario, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Metrics as pairs of name and entry."""
    metrics = metrics_of(scenario)
    return [(name, told(float(values[name]), each.unit)) for name, each in metrics.items()]
