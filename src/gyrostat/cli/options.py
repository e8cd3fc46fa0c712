"""Options that several verbs take."""

from pathlib import Path
from typing import Annotated

import typer

Out = Annotated[Path, typer.Option(help="Folder for the results.")]
Force = Annotated[
    bool, typer.Option("--force", help="Take a wheel model that is marked as impossible.")
]
Json = Annotated[bool, typer.Option("--json", help="Print the result's JSON and nothing else.")]
