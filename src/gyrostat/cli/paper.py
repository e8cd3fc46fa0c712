"""The verb that rebuilds a paper."""

import json
from typing import Annotated

import typer

from gyrostat.arguments import command_line, say
from gyrostat.cli.options import Json, Out


def reproduce(
    paper: Annotated[
        str,
        typer.Argument(
            help="carrara-kuga, moreira-lopes-kuga, carvalho-fenili or endo-sekiguchi-nonaka"
        ),
    ],
    out: Out,
    quick: Annotated[bool, typer.Option(help="Fewer seeds, within two minutes.")] = False,
    json_output: Json = False,
) -> None:
    """Rebuild a paper's experiment and judge each of its claims: claims.json and report.html."""
    from gyrostat.files import check_writable, write_whole
    from gyrostat.papers import paper_named

    experiment = paper_named(paper)
    check_writable(out)
    result = experiment.reproduce(quick=quick, say=say)
    text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(out / "report.html", result.page(command=command_line()))
    write_whole(out / "claims.json", text + "\n")
    for line in result.lines():
        say(line)
    if json_output:
        print(text)
