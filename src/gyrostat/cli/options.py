"""Options shared by several verbs."""

from pathlib import Path
from typing import Annotated, Literal

import typer

Force = Annotated[
    bool, typer.Option("--force", help="Replace existing files that this command did not write.")
]
Out = Annotated[Path, typer.Option(help="Folder for the results.")]
ForceModel = Annotated[
    bool,
    typer.Option(
        "--force",
        help="Replace existing files that this command did not write; accept a wheel model that "
        "is marked as impossible.",
    ),
]
Figures = Annotated[
    str | None,
    typer.Option(help="Write the figures for papers too: pdf, svg or png."),
]
Json = Annotated[bool, typer.Option("--json", help="Print only the result, as JSON.")]
Scheduler = Annotated[str | None, typer.Option(help="Address of a Dask scheduler with workers.")]
Workers = Annotated[
    int | None,
    typer.Option(
        min=1, max=100_000, help="Processes [default: one per core, threads for a small campaign]."
    ),
]
Verify = Annotated[
    bool,
    typer.Option("--verify", help="Compile the program again and compare it with the stored one."),
]

SpeedScale = Annotated[str | None, typer.Option(help="True divided by measured speed.")]
Clock = Annotated[str | None, typer.Option(help="True divided by recorded time.")]
Ripple = Annotated[
    float | None, typer.Option(help="Torque ripple, rms over the dry friction torque.")
]
Free = Annotated[list[str] | None, typer.Option(help="NAME to estimate too.")]
Prior = Annotated[list[str] | None, typer.Option(help="Prior: NAME=MEAN:SIGMA.")]
UnsignedSpeed = Annotated[
    bool, typer.Option(help="The speed is a magnitude; its sign changes where it touches zero.")
]
Missing = Annotated[
    Literal["refuse", "drop"],
    typer.Option(help="Cells without a number: report an error, or drop their rows."),
]

FAILED = typer.Option(
    help="Failed wheel: NAME or NAME=seized (stops at once), NAME=frozen (no torque, keeps its "
    "momentum), NAME=rundown or NAME=rundown:60s (no torque, runs down), NAME=0.3 or "
    "NAME=1500rpm (frozen at this momentum, N·m·s, or speed)."
)
Attitude = Annotated[
    str | None, typer.Option(help="At the failure: quaternion Q0,Q1,Q2,Q3, scalar first.")
]
AttitudeEuler = Annotated[
    str | None, typer.Option(help="At the failure: 3-1-3 angles PHI,THETA,PSI, rad or units.")
]
Rate = Annotated[
    str | None,
    typer.Option(help="Body rate at the failure: WX,WY,WZ, rad/s or with units [default: 0,0,0]."),
]
Wheels = Annotated[
    str | None,
    typer.Option(help="Wheel momenta at the failure, N·m·s, or speeds with units: A,B,..."),
]
Telemetry = Annotated[
    Path | None,
    typer.Option(
        help="TOML file with attitude (or attitude_euler), rate, and wheel_speed (or "
        "wheel_momentum), in place of the options above."
    ),
]
ScalarLast = Annotated[
    bool,
    typer.Option(
        "--scalar-last",
        help="Quaternions are Q1,Q2,Q3,Q0; for a telemetry file, its key scalar_last.",
    ),
]
