"""Verb `recover`: simulate the slew to a feasible attitude after wheel failures."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Force, Json, Out


def recover(
    spacecraft: Annotated[Path, typer.Argument(help="Spacecraft file, spacecraft.toml.")],
    failed: Annotated[
        list[str],
        typer.Option(
            help="Failing wheel: NAME=seized, NAME=frozen (no torque, keeps its momentum) or "
            "NAME=rundown:60s (no torque, runs down)."
        ),
    ],
    wheels: Annotated[
        str, typer.Option(help="Wheel momenta at the failure, N·m·s, or speeds with units: A,B,...")
    ],
    out: Out,
    brake: Annotated[
        list[str] | None,
        typer.Option(
            help="Brake of a failed wheel: NAME=8s (time constant of its short-circuited motor) "
            "or NAME=20mN·m (torque with which the motor still brakes)."
        ),
    ] = None,
    attitude: Annotated[
        str | None, typer.Option(help="At the failure: quaternion Q0,Q1,Q2,Q3, scalar first.")
    ] = None,
    attitude_euler: Annotated[
        str | None, typer.Option(help="At the failure: 3-1-3 angles PHI,THETA,PSI, rad or units.")
    ] = None,
    rate: Annotated[str, typer.Option(help="Body rate at the failure: WX,WY,WZ, rad/s.")] = "0,0,0",
    target: Annotated[
        str | None, typer.Option(help="Target attitude: quaternion Q0,Q1,Q2,Q3, scalar first.")
    ] = None,
    euler: Annotated[
        str | None, typer.Option(help="Target attitude: 3-1-3 angles, rad or with units.")
    ] = None,
    duration: Annotated[str, typer.Option(help="Simulated time, s or with a unit.")] = "600",
    period: Annotated[str, typer.Option(help="Control period, s or with a unit.")] = "0.5",
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Simulate the slew to the nearest feasible attitude: recover.json, run.nc, report.html."""
    found = call(verbs.recover, locals(), command=command_line())
    if json_output:
        print_json(out / "recover.json")
    if found.settle is None:
        raise typer.Exit(1)
