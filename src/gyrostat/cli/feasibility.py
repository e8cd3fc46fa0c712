"""Verb `feasible`: attitudes that remain feasible after wheel failures."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Force, Json, Out


def feasible(
    spacecraft: Annotated[Path, typer.Argument(help="Spacecraft file, spacecraft.toml.")],
    momentum: Annotated[
        str, typer.Option(help="Total momentum, inertial axes: HX,HY,HZ, N·m·s or with units.")
    ],
    out: Out,
    failed: Annotated[
        list[str] | None,
        typer.Option(
            help="Failed wheel: NAME or NAME=seized (no momentum), NAME=0.3 (N·m·s), NAME=1500rpm."
        ),
    ] = None,
    target: Annotated[
        str | None, typer.Option(help="Attitude to hold: quaternion Q0,Q1,Q2,Q3, scalar first.")
    ] = None,
    euler: Annotated[
        str | None,
        typer.Option(help="Attitude to hold: 3-1-3 angles PHI,THETA,PSI, rad or with units."),
    ] = None,
    boresight: Annotated[
        str | None, typer.Option(help="Body direction X,Y,Z or x, -z, ... for map and --towards.")
    ] = None,
    towards: Annotated[
        str | None, typer.Option(help="Inertial direction for --boresight; the roll is free.")
    ] = None,
    tolerance: Annotated[
        str | None, typer.Option(help="Pointing tolerance for the dwell time, rad or with a unit.")
    ] = None,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Find the attitudes that remain feasible after wheel failures: holdable.json, report.html."""
    call(verbs.feasible, locals(), command=command_line())
    if json_output:
        print_json(out / "holdable.json")
