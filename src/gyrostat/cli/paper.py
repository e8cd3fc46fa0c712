"""Verb `reproduce`: reproduce a paper and test its claims."""

from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Figures, Force, Json, Out, Scheduler


def reproduce(
    paper: Annotated[
        str,
        typer.Argument(
            help="carrara-kuga, moreira-lopes-kuga, carvalho-fenili, endo-sekiguchi-nonaka or "
            "ecss-e-st-60-10c."
        ),
    ],
    out: Out,
    quick: Annotated[bool, typer.Option(help="Fewer seeds; takes less than two minutes.")] = False,
    scheduler: Scheduler = None,
    force: Force = False,
    figures: Figures = None,
    json_output: Json = False,
) -> None:
    """Reproduce a paper's experiments and test each of its claims: claims.json and report.html."""
    call(verbs.reproduce, locals(), command=command_line())
    if json_output:
        print_json(out / "claims.json")
