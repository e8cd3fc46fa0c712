"""Verb on rate gyros: allan."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Force, Json, Out


def allan(
    record: Annotated[Path, typer.Argument(help="Record of a gyro at rest: CSV, HDF5, ....")],
    out: Out,
    columns: Annotated[
        str | None,
        typer.Option(help="Columns by role, rate_x=gx,rate_y=gy, or a .toml file of them."),
    ] = None,
    units: Annotated[
        str | None, typer.Option(help="Units by role, if the file has none: rate_x=deg/s.")
    ] = None,
    interval: Annotated[
        str | None, typer.Option(help="Time between samples of a record without times: 10ms.")
    ] = None,
    shortest: Annotated[
        str | None,
        typer.Option(help="Shortest averaging time of the fit [default: that of a sample]."),
    ] = None,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Noise of a rate gyro from a record at rest: allan.json, allan.svg, sensors.toml."""
    call(verbs.allan, locals(), command=command_line())
    if json_output:
        print_json(out / "allan.json")
