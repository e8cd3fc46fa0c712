"""Verb on telemetry of wheels in flight: monitor."""

from pathlib import Path
from typing import Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import Force, Json, Out, Scheduler


def monitor(
    out: Out,
    wheels: Annotated[Path, typer.Option(help="What is known of the wheels: wheels.toml.")],
    telemetry: Annotated[
        list[Path] | None,
        typer.Argument(help="Telemetry: Parquet, CSV, MATLAB; many files. None with --rehearse."),
    ] = None,
    spacecraft: Annotated[
        Path | None, typer.Option(help="Axes of the wheels and inertia of the body: sat.toml.")
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(help="Columns by role, or a .toml file, also of several logs."),
    ] = None,
    units: Annotated[str | None, typer.Option(help="Units by role, if the file has none.")] = None,
    window: Annotated[str, typer.Option(help="Length of a window.")] = "1d",
    false_alarms: Annotated[
        float, typer.Option(help="Highest expected number of false alarms per wheel-year.")
    ] = 0.32,
    fault_rates: Annotated[
        str | None,
        typer.Option(help="Assumed faults per wheel-year by class, such as 'stiction=0.02'."),
    ] = None,
    friction_limit: Annotated[
        str | None, typer.Option(help="Friction torque whose day is forecast, such as '3 mN·m'.")
    ] = None,
    restart: Annotated[
        bool, typer.Option("--restart", help="Forget the telemetry of earlier calls.")
    ] = False,
    columns_template: Annotated[
        bool,
        typer.Option(
            "--columns-template", help="Write only columns.toml, to fill in for --columns."
        ),
    ] = False,
    rehearse: Annotated[
        Path | None,
        typer.Option(
            help="Simulate flights of this spacecraft, sat.toml, and monitor them: rehearsal.json."
        ),
    ] = None,
    period: Annotated[str, typer.Option(help="With --rehearse: time between rows.")] = "1s",
    flights: Annotated[
        int, typer.Option(help="With --rehearse: flights of each fault, and healthy ones.")
    ] = 3,
    scheduler: Scheduler = None,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Friction and motor of wheels in flight, per day: health.json, windows.parquet."""
    result = call(verbs.monitor, locals(), command=command_line())
    if columns_template:
        return
    if json_output:
        print_json(out / ("health.json" if rehearse is None else "rehearsal.json"))
    if rehearse is None and (result.alarms or not result.windows["valid"].any()):
        raise typer.Exit(1)
