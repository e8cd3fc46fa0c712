"""Verb on the records of one wheel: pool."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Clock, ForceModel, Free, Json, Out, Prior, Ripple, SpeedScale


def pool(
    records: Annotated[
        list[Path],
        typer.Argument(help="Records of one wheel, fit.json of each, or folders of fits."),
    ],
    out: Out,
    temperature: Annotated[
        str | None, typer.Option(help="Temperature of the prediction, °C [default: mean].")
    ] = None,
    date: Annotated[
        str | None, typer.Option(help="Date of the prediction [default: last record].")
    ] = None,
    oil: Annotated[
        str | None,
        typer.Option(
            help="Oil: °C and mm²/s at two temperatures, 40:108,100:14.6; or B and C of Vogel's "
            "equation, vogel:845,110."
        ),
    ] = None,
    serial: Annotated[
        str | None, typer.Option(help="Serial number of the wheel: others are left out.")
    ] = None,
    dates: Annotated[
        str | None, typer.Option(help="Date of each record, with commas between.")
    ] = None,
    temperatures: Annotated[
        str | None, typer.Option(help="Temperature of each record, °C, with commas between.")
    ] = None,
    same_bench: Annotated[
        bool, typer.Option(help="All records are from one bench: its scale errors are common.")
    ] = False,
    inertia: Annotated[
        str | None, typer.Option(help="As for identify, as all options that follow.")
    ] = None,
    current_scale: Annotated[
        str | None, typer.Option(help="True divided by measured current.")
    ] = None,
    speed_scale: SpeedScale = None,
    clock: Clock = None,
    ripple: Ripple = None,
    model: Annotated[str | None, typer.Option(help="Friction model [default: stribeck].")] = None,
    hold: Annotated[
        list[str] | None, typer.Option(help="Hold a parameter: NAME=VALUE, or NAME.")
    ] = None,
    free: Free = None,
    prior: Prior = None,
    speed_sigma: Annotated[str | None, typer.Option(help="Noise of the speed, 1 sigma.")] = None,
    columns: Annotated[
        str | None, typer.Option(help="Columns by role, or a .toml file of them.")
    ] = None,
    units: Annotated[str | None, typer.Option(help="Units by role, if the file has none.")] = None,
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """One model from the records of a wheel over dates and temperatures: pool.json, model.toml."""
    call(verbs.pool, locals(), command=command_line())
    if json_output:
        print_json(out / "pool.json")
