"""Verb on what is mounted on the body: place."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Force, Json, Out


def place(
    scenario: Annotated[Path, typer.Argument(help="Scenario file, scenario.toml.")],
    out: Out,
    heads: Annotated[int, typer.Option(help="Largest number of star tracker heads, 1 to 3.")] = 2,
    sun: Annotated[
        str | None,
        typer.Option(
            help="Least angle between boresight and Sun [default: that of the scenario's first "
            "head, as of the next three]."
        ),
    ] = None,
    earth: Annotated[
        str | None, typer.Option(help="Least angle between boresight and limb of the Earth.")
    ] = None,
    moon: Annotated[
        str | None, typer.Option(help="Least angle between boresight and Moon.")
    ] = None,
    rate: Annotated[
        str | None, typer.Option(help="Largest body rate at which a head sees.")
    ] = None,
    apart: Annotated[str, typer.Option(help="Least angle between two heads.")] = "60 deg",
    blocked: Annotated[
        list[str] | None,
        typer.Option(
            help="Directions that the body blocks: DIRECTION:HALF_ANGLE, such as -z:30deg or "
            "1,0,1:20deg; repeat for several."
        ),
    ] = None,
    window: Annotated[
        list[str] | None,
        typer.Option(
            help="Window of the metrics whose time counts, or run; repeat for several [default: "
            "the windows of the scenario, or the whole run].",
        ),
    ] = None,
    absorptance: Annotated[
        float, typer.Option(help="Absorptance of the radiator for sunlight.")
    ] = 0.1,
    emittance: Annotated[float, typer.Option(help="Its emittance in the infrared.")] = 0.85,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Best directions of star tracker heads, radiator and panel: place.json, report.html."""
    call(verbs.place, locals(), command=command_line())
    if json_output:
        print_json(out / "place.json")
