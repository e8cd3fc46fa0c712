"""Options shared by several verbs."""

from pathlib import Path
from typing import Annotated, Literal

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
        help="Replace existing files that this command did not write; accept a wheel model that "
        "is marked as impossible.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print only the result, as JSON.")]


UnsignedSpeed = Annotated[
    bool, typer.Option(help="The speed is a magnitude; its sign changes where it touches zero.")
]
Missing = Annotated[
    Literal["refuse", "drop"],
    typer.Option(help="Cells without a number: report an error, or drop their rows."),
]
