"""Verb `reproduce`: rebuild a paper and judge its claims."""

import json
from typing import Annotated

import typer

from gyrostat.cli.arguments import command_line, say
from gyrostat.cli.options import Force, Json, Out


def reproduce(
    paper: Annotated[
        str,
        typer.Argument(
            help="carrara-kuga, moreira-lopes-kuga, carvalho-fenili or endo-sekiguchi-nonaka"
        ),
    ],
    out: Out,
    quick: Annotated[bool, typer.Option(help="Fewer seeds, within two minutes.")] = False,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Rebuild a paper's experiment and judge each of its claims: claims.json and report.html."""
    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.papers import paper_named

    experiment = paper_named(paper)
    check_outputs(out, ("claims.json", "report.html"), by="reproduce", force=force)
    result = experiment.reproduce(quick=quick, say=say)
    text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    page = result.page(command=command_line())
    with new_files(out, by="reproduce", force=force) as folder:
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "claims.json").write_text(text + "\n", encoding="utf-8")
    for line in result.lines():
        say(line)
    if json_output:
        print(text)
