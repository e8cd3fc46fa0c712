"""Verb `recover`: simulate the slew to a feasible attitude after wheel failures."""

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


def recover(
    spacecraft: Annotated[Path, typer.Argument(help="Spacecraft file, spacecraft.toml.")],
    failed: Annotated[list[str], FAILED],
    out: Out,
    brake: Annotated[
        list[str] | None,
        typer.Option(
            help="Brake of a failed wheel: NAME=8s (time constant of its short-circuited motor) "
            "or NAME=20mN·m (torque with which the motor still brakes)."
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
            help="Target attitude: quaternion Q0,Q1,Q2,Q3, scalar first. Required: this or --euler."
        ),
    ] = None,
    euler: Annotated[
        str | None, typer.Option(help="Target attitude: 3-1-3 angles, rad or with units.")
    ] = None,
    duration: Annotated[str, typer.Option(help="Simulated time, s or with a unit.")] = "600",
    period: Annotated[str, typer.Option(help="Control period, s or with a unit.")] = "0.5",
    external_torque: Annotated[
        str | None,
        typer.Option(help="Constant external torque X,Y,Z, body axes, N·m or with units."),
    ] = None,
    scalar_last: ScalarLast = False,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Simulate the slew to the nearest feasible attitude: recover.json, run.nc, report.html.

    Required: --attitude or --attitude-euler, and --wheels; or --telemetry.
    """
    recovery = call(verbs.recover, locals(), command=command_line())
    if json_output:
        print_json(out / "recover.json")
    if recovery.settle is None:
        raise typer.Exit(1)
