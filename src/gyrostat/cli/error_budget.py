"""Verb on the sources of pointing error: budget."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import ForceModel, Json, Out, Scheduler, Verify, Workers
from gyrostat.cli.progress import Progress


def budget(
    scenario: Annotated[Path, typer.Argument(help="Scenario file, scenario.toml.")],
    out: Out,
    runs: Annotated[
        int, typer.Option(min=1, help="Number of runs with each set of sources, at least 16.")
    ] = 128,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random draws.")] = 0,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            help="Metric of which the part that is missing without each source is given too; may "
            "be repeated."
        ),
    ] = None,
    orders: Annotated[
        int,
        typer.Option(
            min=0,
            help="Number of orders in which sources are switched on one after the other, even, "
            "for Shapley values; 0: each alone.",
        ),
    ] = 0,
    window: Annotated[
        list[str] | None,
        typer.Option(
            help="Window of the metrics, or run, of a scenario without requirements; may be "
            "repeated [default: all windows, or the run]."
        ),
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    force: ForceModel = False,
    verify: Verify = False,
    json_output: Json = False,
) -> None:
    """Split the pointing error by source; run again to resume after a stop."""
    options = {**locals(), "metric": metric or (), "window": window or ()}
    with Progress() as on_progress:
        result = call(verbs.budget, options, on_progress=on_progress, command=command_line())
    if json_output:
        print_json(out / "report.json")
    if result.doubts():
        raise typer.Exit(1)
