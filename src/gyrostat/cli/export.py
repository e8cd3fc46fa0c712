"""Verb `export`: flight C, FMU, Basilisk module or data sheet."""

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line
from gyrostat.cli.options import ForceModel, Json, Out
from gyrostat.verbs.flight_folder import PAGE
from gyrostat.verbs.format_kinds import FORMATS, OF_PARTS
from gyrostat.verbs.part_kinds import PARTS
from gyrostat.verbs.required_options import FURTHER

Text = str | None


def export(
    model: Annotated[Path, typer.Argument(help="model.toml of the wheel, or scenario.toml.")],
    out: Out,
    to: Annotated[
        str,
        typer.Option(
            metavar=f"[{'|'.join(FORMATS)}]",
            help=f"{'; '.join(f'{name}: {kind.about}' for name, kind in FORMATS.items())}.",
        ),
    ],
    what: Annotated[
        Text,
        typer.Option(
            metavar=f"[{'|'.join(PARTS)}]",
            help=f"Part to export; required with --to {OF_PARTS}, unless a scenario is exported. "
            f"Further required: {FURTHER}.",
        ),
    ] = None,
    precision: Annotated[
        Literal["double", "float"], typer.Option(help="Precision in C.")
    ] = "double",
    period: Annotated[
        Text, typer.Option(help="Control period, s or with a unit; required with --what.")
    ] = None,
    gains: Annotated[
        Text, typer.Option(help="Attitude law: KP,KI,KD in N·m/rad, N·m/(rad·s), N·m·s/rad.")
    ] = None,
    table_inertia: Annotated[
        Text, typer.Option(help="Inertia of the turned body without rotor, kg·m² or with a unit.")
    ] = None,
    speed_sigma: Annotated[
        Text, typer.Option(help="Noise of a tachometer sample, rad/s or with a unit.")
    ] = None,
    current_limit: Annotated[Text, typer.Option(help="Limit of the motor current, A.")] = None,
    delay: Annotated[
        int, typer.Option(min=0, max=1000, help="Control periods from a sample to its command.")
    ] = 0,
    scale_drift: Annotated[
        Text, typer.Option(help="Drift of the friction level, 1/√s, for the estimator.")
    ] = None,
    range_: Annotated[
        list[str] | None,
        typer.Option(
            "--range",
            help="Accepted values of an input, FIELD=LOWER:UPPER, SI or with units, such as "
            "rate=-2deg/s:2deg/s; once for each field.",
        ),
    ] = None,
    rate_limit: Annotated[
        list[str] | None,
        typer.Option(help="Largest accepted change of an input, FIELD=VALUE, its SI unit per s."),
    ] = None,
    on_bad: Annotated[
        Literal["hold", "zero"],
        typer.Option(help="Command after a rejected sample: last accepted one, or zero."),
    ] = "hold",
    name: Annotated[
        Text,
        typer.Option(
            help="Name of the flight module and prefix of its functions, instead of that of the "
            "part, such as wheel_x."
        ),
    ] = None,
    evidence: Annotated[
        bool, typer.Option("--evidence", help="Check the C code, as make evidence does.")
    ] = False,
    reasons: Annotated[
        Path | None,
        typer.Option(
            help="TOML file: why something in your own code cannot be shown by a test vector, and "
            "deviations from MISRA C:2012; with --evidence."
        ),
    ] = None,
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """Write flight code in C, a unit or module for other simulators, or a data sheet.

    The emitted code validates every input: finite, within its range and its rate limit.
    """
    paths = call(verbs.export, locals(), command=command_line())
    if json_output:
        print(json.dumps({"files": [path.relative_to(out).as_posix() for path in paths]}))
    if evidence:
        from gyrostat.exports import read_results

        folders = [path.parent for path in paths if path.name == PAGE]
        results = [result for folder in folders for result in read_results(folder)]
        if any(result.outcome == "failed" for result in results):
            raise typer.Exit(1)
