"""Verb on several fits: compare."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import ForceModel, Json, Out


def compare(
    fits: Annotated[
        list[Path], typer.Argument(help="fit.json or model.toml of each, or its folder.")
    ],
    out: Out,
    wheels: Annotated[
        Literal["same", "different"] | None,
        typer.Option(help="One wheel over dates, or a batch [default: by serial number]."),
    ] = None,
    same_bench: Annotated[
        bool, typer.Option(help="All records are from one bench: its scale errors are common.")
    ] = False,
    dates: Annotated[
        str | None, typer.Option(help="Date of each fit, with commas between.")
    ] = None,
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """Compare fits of one wheel over dates, or of a batch: comparison.json and comparison.html."""
    call(verbs.compare, locals(), command=command_line())
    if json_output:
        print_json(out / "comparison.json")
