"""Verbs on one wheel: identify, validate, bench."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json
from gyrostat.cli.options import (
    Clock,
    Figures,
    Force,
    ForceModel,
    Free,
    Json,
    Missing,
    Out,
    Prior,
    Ripple,
    SpeedScale,
    UnsignedSpeed,
)
from gyrostat.core.errors import InputError

Hold = Literal["zero-order", "linear"]
Columns = Annotated[
    str | None,
    typer.Option(
        help="Columns by role, time=t,current=m1cur,speed=m1vel, or a .toml file of them."
    ),
]
Units = Annotated[
    str | None, typer.Option(help="Units by role, if the file has none: speed=rpm,time=ms.")
]
Unsigned = Annotated[
    bool, typer.Option(help="The current is a magnitude; its sign is that of setpoint or speed.")
]
CurrentHold = Annotated[Hold, typer.Option(help="Interpolation of the current.")]


def identify(
    records: Annotated[
        list[Path], typer.Argument(help="Records of one wheel: CSV, TDMS, HDF5, ...")
    ],
    out: Out,
    inertia: Annotated[
        str | None,
        typer.Option(help="Inertia of rotor and flywheel, kg·m² or with a unit; '1.5e-3 +- 1 %'."),
    ] = None,
    current_scale: Annotated[
        str | None, typer.Option(help="True divided by measured current: '1.01 +- 0.5 %'.")
    ] = None,
    speed_scale: SpeedScale = None,
    clock: Clock = None,
    ripple: Ripple = None,
    current_quantum: Annotated[
        str | None, typer.Option(help="Rounding of the current, A or '1 mA'; 0: none.")
    ] = None,
    speed_quantum: Annotated[
        str | None, typer.Option(help="Rounding of the speed, rad/s or '0.4 rpm'; 0: none.")
    ] = None,
    model: Annotated[
        str | None, typer.Option(help="Friction model; auto: by diagnosis [default: stribeck].")
    ] = None,
    method: Annotated[
        Literal["batch", "steady", "torque-step", "coast", "inverse"],
        typer.Option(help="Identification method; inverse: a drive in closed loop."),
    ] = "batch",
    hold: Annotated[
        list[str] | None, typer.Option(help="Hold a parameter: NAME=VALUE, or NAME at its default.")
    ] = None,
    free: Free = None,
    prior: Prior = None,
    start: Annotated[list[str] | None, typer.Option(help="Start value NAME=VALUE.")] = None,
    speed_sigma: Annotated[
        str | None,
        typer.Option(
            help="Noise of the speed, 1 sigma, rad/s or with a unit; A,B for two records."
        ),
    ] = None,
    loss: Annotated[
        str | None, typer.Option(help="Loss: quadratic, huber or student [default: quadratic].")
    ] = None,
    current_hold: Annotated[
        Hold | None, typer.Option(help="Interpolation of the current [default: zero-order].")
    ] = None,
    compare: Annotated[bool, typer.Option(help="Rank the other friction models too.")] = False,
    held_out: Annotated[
        list[Path] | None,
        typer.Option(help="Record for the ranking or torque error only, not for the fit."),
    ] = None,
    columns: Columns = None,
    units: Units = None,
    unsigned_current: Unsigned = False,
    unsigned_speed: UnsignedSpeed = False,
    missing: Missing = "refuse",
    edges: Annotated[
        Path | None, typer.Option(help="File of a tachometer's edge times, s, instead of speeds.")
    ] = None,
    pulses: Annotated[int, typer.Option(help="Edges per revolution, with --edges.")] = 1,
    speed_from: Annotated[
        Path | None, typer.Option(help="File of the speed, of a logger with its own clock.")
    ] = None,
    speed_columns: Annotated[
        str | None, typer.Option(help="Columns of the file of --speed-from, as --columns.")
    ] = None,
    posterior: Annotated[
        bool, typer.Option(help="Sample the posterior too (needs the package blackjax).")
    ] = False,
    loop: Annotated[
        str | None,
        typer.Option(help="Loop: open, closed, or a .toml file with the control law (inverse)."),
    ] = None,
    force: Force = False,
    figures: Figures = None,
    json_output: Json = False,
) -> None:
    """Identify a wheel: fit.json, model.toml and report.html from its bench records."""
    fit = call(verbs.identify, locals(), command=command_line())
    if json_output:
        print_json(out / "fit.json")
    unmixed = fit.posterior is not None and not fit.posterior.valid
    if not fit.converged or fit.impossible or unmixed:
        raise typer.Exit(1)


def validate(
    model: Annotated[Path, typer.Argument(help="model.toml of the wheel.")],
    record: Annotated[Path, typer.Argument(help="Record that the model was not fitted to.")],
    out: Out,
    sheet: Annotated[
        str | None,
        typer.Option(help="Data sheet with limits: a .toml file, or the name of one of gyrostat."),
    ] = None,
    hold: Annotated[
        list[str] | None,
        typer.Option(help="current_bias=VALUE: current offset of the drive, not in model.toml."),
    ] = None,
    current_hold: CurrentHold = "zero-order",
    columns: Columns = None,
    units: Units = None,
    unsigned_current: Unsigned = False,
    unsigned_speed: UnsignedSpeed = False,
    missing: Missing = "refuse",
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Validate a known wheel on an independent record: validation.json and validation.html."""
    result = call(verbs.validate, locals(), command=command_line())
    if json_output:
        print_json(out / "validation.json")
    rejected = result.acceptance is not None and result.acceptance.failed
    if rejected or not (result.converged and result.holds):
        raise typer.Exit(1)


def bench(
    model: Annotated[
        Path,
        typer.Argument(
            help="model.toml of the wheel; with --design also fit.json; with --tests or --verdict "
            "a spec sheet."
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(help="Record to write, .csv or .parquet; with --tests or --verdict a folder."),
    ],
    profile: Annotated[str, typer.Option(help="Current profile: steps, sines or ramps.")] = "steps",
    duration: Annotated[str, typer.Option(help="Duration, s or with a unit.")] = "300",
    rate: Annotated[float, typer.Option(help="Sampling rate, Hz.")] = 10.0,
    low: Annotated[str | None, typer.Option(help="Smallest current amplitude, A.")] = None,
    high: Annotated[str | None, typer.Option(help="Largest current amplitude, A.")] = None,
    period: Annotated[str | None, typer.Option(help="Period of a step, cycle or ramp, s.")] = None,
    initial_speed: Annotated[str, typer.Option(help="Initial speed, rad/s or with a unit.")] = "0",
    speed_sigma: Annotated[str, typer.Option(help="Tachometer noise, rad/s or with a unit.")] = "0",
    speed_quantum: Annotated[str, typer.Option(help="Speed quantisation step, rad/s.")] = "0",
    jitter: Annotated[float, typer.Option(help="Time jitter, fraction of the interval.")] = 0.0,
    dropouts: Annotated[float, typer.Option(help="Fraction of missing speeds.")] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of currents and noise.")] = 0,
    design: Annotated[
        list[str] | None,
        typer.Option(help="Parameter or difference to determine, such as static-coulomb."),
    ] = None,
    target_sigma: Annotated[
        str | None, typer.Option(help="Wanted sigma of --design, with or without unit; A,B.")
    ] = None,
    max_speed: Annotated[
        str | None, typer.Option(help="Largest speed of a designed record, rad/s.")
    ] = None,
    slew: Annotated[
        float | None, typer.Option(help="Largest rate of the designed current, A/s.")
    ] = None,
    ripple: Ripple = None,
    drift: Annotated[
        list[str] | None,
        typer.Option(help="Drift of friction in a designed record: viscous=SHARE,dry=SHARE."),
    ] = None,
    tests: Annotated[
        list[str] | None, typer.Option(help="Bench tests to plan or judge: all, or names; A,B.")
    ] = None,
    verdict: Annotated[
        Path | None, typer.Option(help="Folder with the records of bench tests, to judge them.")
    ] = None,
    simulate: Annotated[
        int, typer.Option(help="Simulated records of each bench test or design.")
    ] = 0,
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """Simulate a bench record; --design the next one; plan --tests; judge their records.

    --verdict writes the acceptance report.
    """
    planned = bool(tests) or verdict is not None
    if json_output and not (design or planned):
        raise InputError("--json: found without --design, expected with it: a record is no JSON")
    given = {**locals(), "design": design or None, "tests": tests or None, "drift": drift or None}
    del given["planned"]
    result = call(verbs.bench, given, command=command_line())
    if json_output:
        names = "plan.json" if verdict is None else "acceptance.json"
        print_json(out / names if planned else out.with_suffix(".json"))
    if verdict is not None and result.acceptance.failed:
        raise typer.Exit(1)
