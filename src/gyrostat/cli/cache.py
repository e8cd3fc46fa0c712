"""Verb `cache`: show and clear the compiled programs that are kept."""

import json
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call
from gyrostat.cli.options import Json


def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Remove all entries.")] = False,
    json_output: Json = False,
) -> None:
    """Show the cache of compiled programs: folder, size and limit."""
    content = call(verbs.cache, locals())
    if json_output:
        print(json.dumps(content, indent=1, ensure_ascii=False))
