"""Verbs on microvibration: waterfall, jitter."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Force, Json, Out


def waterfall(
    record: Annotated[Path, typer.Argument(help="Waterfall of a wheel: CSV, HDF5 or UFF58.")],
    out: Out,
    quantity: Annotated[
        Literal["density", "amplitude", "rms"], typer.Option(help="What the numbers are.")
    ] = "density",
    window: Annotated[str, typer.Option(help="Window of the spectra, by its name.")] = "hann",
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Loads of a wheel: disturbance.json, disturbance.toml and waterfall.html."""
    result = call(verbs.waterfall, locals(), command=command_line())
    if json_output:
        print_json(out / "disturbance.json")
    if not result.valid:
        raise typer.Exit(1)


def jitter(
    structure: Annotated[Path, typer.Argument(help="Wheels on a structure, TOML.")],
    out: Out,
    count: Annotated[int, typer.Option(help="Number of speeds.")] = 10_000,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Line of sight over wheel speed: jitter.json, bands.toml and jitter.html."""
    call(verbs.jitter, locals(), command=command_line())
    if json_output:
        print_json(out / "jitter.json")
