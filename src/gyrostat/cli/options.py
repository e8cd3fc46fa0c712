"""Options shared by several verbs."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

Force = Annotated[
    bool,
    typer.Option("--force", help="Replace existing files that this command did not write."),
]
Out = Annotated[Path, typer.Option(help="Folder for the results.")]
ForceModel = Annotated[
    bool,
    typer.Option(
        "--force",
        help="Replace existing files that this command did not write; take a wheel model that is "
        "marked as impossible.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result's JSON and nothing else.")]


class MissingCells(StrEnum):
    """Treatment of cells without a finite number."""

    refuse = "refuse"
    drop = "drop"


UnsignedSpeed = Annotated[
    bool, typer.Option(help="The speed has no sign: it changes where the speed touches zero.")
]
Missing = Annotated[
    MissingCells, typer.Option(help="Cells without a number: an error, or their rows left out.")
]
