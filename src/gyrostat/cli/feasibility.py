"""Verb `feasible`: attitudes that remain feasible after wheel failures."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import (
    FAILED,
    Attitude,
    AttitudeEuler,
    Force,
    Json,
    Out,
    Rate,
    ScalarLast,
    Telemetry,
    Wheels,
)


def feasible(
    spacecraft: Annotated[Path, typer.Argument(help="Spacecraft file, spacecraft.toml.")],
    out: Out,
    failed: Annotated[list[str] | None, FAILED] = None,
    momentum: Annotated[
        str | None,
        typer.Option(
            help="Total momentum, inertial axes: HX,HY,HZ, N·m·s or with units. Required: this, or "
            "--attitude and --wheels, or --telemetry."
        ),
    ] = None,
    attitude: Attitude = None,
    attitude_euler: AttitudeEuler = None,
    rate: Rate = None,
    wheels: Wheels = None,
    telemetry: Telemetry = None,
    target: Annotated[
        str | None,
        typer.Option(
            help="Attitude to hold: quaternion Q0,Q1,Q2,Q3, scalar first. Required: this, --euler, "
            "or --boresight with --towards."
        ),
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
    fly: Annotated[
        bool,
        typer.Option(
            "--fly",
            help="A map in report.html on which target and momentum are dragged and wheels fail; "
            "with --boresight and --towards. It needs clang with lld and wasi-libc, or zig.",
        ),
    ] = False,
    scalar_last: ScalarLast = False,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Find the attitudes that remain feasible after wheel failures: holdable.json, report.html."""
    call(verbs.feasible, locals(), command=command_line())
    if json_output:
        print_json(out / "holdable.json")
