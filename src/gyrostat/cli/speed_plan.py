"""Verb on wheel speeds in science windows: plan-speeds."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import ForceModel, Json, Out


def plan_speeds(
    scenario: Annotated[Path, typer.Argument(help="Scenario file, scenario.toml.")],
    out: Out,
    window: Annotated[
        list[str] | None,
        typer.Option(
            help="Science window among those of the metrics; may be repeated [default: all]."
        ),
    ] = None,
    clearance: Annotated[
        str, typer.Option(help="Least distance of wheel speeds from zero, bands and limits.")
    ] = "50 rpm",
    runs: Annotated[
        int, typer.Option(min=0, help="Number of dispersed runs for the probability; 0: none.")
    ] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random draws.")] = 0,
    sight: Annotated[
        Path | None,
        typer.Option(help="Wheels on a structure, TOML, as for jitter: its bands are avoided too."),
    ] = None,
    engine: Annotated[str, typer.Option(help="native, jax or auto.")] = "auto",
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """Plan wheel speeds without crossings in science windows: plan.toml, plan.json, report.html."""
    result = call(verbs.plan_speeds, locals(), command=command_line())
    if json_output:
        print_json(out / "plan.json")
    if result.answer != "found":
        raise typer.Exit(1)
