"""Verb on the wheels of a lot: lot."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import ForceModel, Json, Out


def lot(
    fits: Annotated[
        list[Path], typer.Argument(help="Folder with the folders of the fits, or each fit.json.")
    ],
    out: Out,
    shape: Annotated[
        Literal["unknown", "normal", "log-normal"],
        typer.Option(help="What is known of the distribution of the wheels."),
    ] = "unknown",
    content: Annotated[
        str, typer.Option(help="Share of the wheels inside the tolerance limits.")
    ] = "0.95",
    confidence: Annotated[str, typer.Option(help="Confidence of the tolerance limits.")] = "0.95",
    best: Annotated[
        str,
        typer.Option(
            help="Criterion of the best set: lowest, highest or matched, and a parameter, as in "
            "'matched motor_constant' [its default: coulomb, or the first parameter]."
        ),
    ] = "lowest",
    set_size: Annotated[int, typer.Option(help="Number of wheels of the best set.")] = 4,
    manifest: Annotated[
        Path | None, typer.Option(help="CSV file with columns serial and date.")
    ] = None,
    same_bench: Annotated[
        bool, typer.Option(help="All records are from one bench: its scale errors are common.")
    ] = False,
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """Distribution and tolerance limits of a lot of wheels: lot.json, lot.toml and lot.html."""
    call(verbs.lot, locals(), command=command_line())
    if json_output:
        print_json(out / "lot.json")
