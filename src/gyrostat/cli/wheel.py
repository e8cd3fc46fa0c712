"""Verbs on one wheel: identify, validate, bench."""

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gyrostat.cli import arguments as words
from gyrostat.cli.arguments import command_line, load, say
from gyrostat.cli.options import (
    Force,
    ForceModel,
    Json,
    Missing,
    MissingCells,
    Out,
    UnsignedSpeed,
)

if TYPE_CHECKING:
    from gyrostat.identification import Fit
    from gyrostat.telemetry import Record


class Method(StrEnum):
    """How a wheel is identified."""

    batch = "batch"
    steady = "steady"
    torque_step = "torque-step"
    coast = "coast"


class Hold(StrEnum):
    """How the current runs between samples."""

    zero_order = "zero-order"
    linear = "linear"


Columns = Annotated[
    str | None,
    typer.Option(help="Columns by role: time=t,current=m1cur,speed=m1vel (also temperature, ...)."),
]
Units = Annotated[
    str | None, typer.Option(help="Units by role where the file has none: speed=rpm,time=ms.")
]
Unsigned = Annotated[
    bool, typer.Option(help="The current has no sign: take it from setpoint, or from speed.")
]
CurrentHold = Annotated[Hold, typer.Option(help="The current between samples.")]


def identify(
    records: Annotated[list[Path], typer.Argument(help="Records of one wheel: CSV, Parquet, MAT.")],
    out: Out,
    inertia: Annotated[
        str | None,
        typer.Option(help="Of rotor and flywheel, kg·m² or with a unit; '1.5e-3 +- 1 %'."),
    ] = None,
    current_scale: Annotated[
        str | None, typer.Option(help="True over measured current: '+- 1 %', '1.01 +- 0.5 %'.")
    ] = None,
    speed_scale: Annotated[str | None, typer.Option(help="True over measured speed.")] = None,
    clock: Annotated[str | None, typer.Option(help="True over recorded time.")] = None,
    model: Annotated[
        str | None, typer.Option(help="Friction model, or auto [default: stribeck].")
    ] = None,
    method: Annotated[Method, typer.Option(help="How to identify.")] = Method.batch,
    hold: Annotated[
        list[str] | None, typer.Option(help="NAME=VALUE held, or NAME at its default.")
    ] = None,
    free: Annotated[list[str] | None, typer.Option(help="NAME estimated as well.")] = None,
    prior: Annotated[list[str] | None, typer.Option(help="NAME=MEAN:SIGMA known before.")] = None,
    start: Annotated[list[str] | None, typer.Option(help="NAME=VALUE to start from.")] = None,
    speed_sigma: Annotated[
        str | None,
        typer.Option(
            help="Noise of the speed, 1 sigma, rad/s or with a unit; A,B for two records."
        ),
    ] = None,
    loss: Annotated[
        str | None, typer.Option(help="quadratic, huber or student [default: quadratic].")
    ] = None,
    current_hold: Annotated[
        Hold | None, typer.Option(help="The current between samples [default: zero-order].")
    ] = None,
    compare: Annotated[bool, typer.Option(help="Rank the other friction models too.")] = False,
    held_out: Annotated[
        list[Path] | None, typer.Option(help="Record for the ranking only, never fitted.")
    ] = None,
    columns: Columns = None,
    units: Units = None,
    unsigned_current: Unsigned = False,
    unsigned_speed: UnsignedSpeed = False,
    missing: Missing = MissingCells.refuse,
    edges: Annotated[
        Path | None, typer.Option(help="Times of a tachometer's edges, s, in place of a speed.")
    ] = None,
    pulses: Annotated[int, typer.Option(help="Edges a turn, with --edges.")] = 1,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Identify a wheel: fit.json, model.toml and report.html from its bench records."""
    from gyrostat.core.outputs import check_outputs
    from gyrostat.reports.write import FILES

    check_outputs(out, FILES, by="identify", force=force)
    name = model or "stribeck"
    named = "stribeck" if name == "auto" else name
    value, tolerance = words.inertia(inertia)
    factors, shares = words.scales(
        {"current_scale": current_scale, "speed_scale": speed_scale, "clock": clock}
    )
    tolerance |= shares
    common: dict[str, Any] = {
        "inertia": value,
        "hold": words.held(hold or [], named),
    }
    sigmas = words.quantities(speed_sigma, "speed", "--speed-sigma")
    batch_only = {
        "--free": free,
        "--prior": prior,
        "--start": start,
        "--loss": loss,
        "--current-hold": current_hold,
        "--compare": compare,
        "--held-out": held_out,
        "more than one --speed-sigma": sigmas[1:],
    }

    def measured(path: Path) -> "Record":
        record = load(
            path,
            columns,
            units,
            unsigned_current,
            drop=missing is MissingCells.drop,
            unsigned_speed=unsigned_speed,
            edges=edges,
            pulses=pulses,
        )
        return record.scaled(**factors)

    loaded = [measured(path) for path in records]
    if method is not Method.batch:
        from gyrostat.identification import identify_dedicated

        words.refuse_given(batch_only, f"--method {method.value}", "--method batch")
        common["speed_sigma"] = sigmas[0] if sigmas else None
        fit = identify_dedicated(method.value, loaded, model=model, tolerance=tolerance, **common)
        _finish(fit, out, json_output, force=force)
        return
    from gyrostat import identification as stage
    from gyrostat.identification.prediction import friction_model

    friction_model(named)
    say(f"identifying {name} friction from {', '.join(r.name for r in loaded)}")
    options: dict[str, Any] = {
        **common,
        "free": free or [],
        "prior": words.priors(prior or [], named),
        "start": words.starts(start or [], named),
        "speed_sigma": sigmas or None,
        "loss": loss or "quadratic",
        "current_hold": (current_hold or Hold.zero_order).value,
    }
    fit = stage.identify(
        loaded, model=name, on_progress=words.progress, tolerance=tolerance, **options
    )
    trends = stage.temperature_trends(loaded, model=fit.model.name, on_left_out=say, **options)
    rows = []
    if compare or held_out:
        others = [measured(path) for path in held_out or []]
        say("ranking the other friction models")
        rows = stage.compare(loaded, others, known=fit, **options)
    _finish(fit, out, json_output, force=force, comparison=rows, temperatures=trends)


def _finish(fit: "Fit", out: Path, json_output: bool, **options: Any) -> None:
    from gyrostat.reports.write import write_fit

    text = write_fit(fit, out, command=command_line(), say=say, **options)
    if json_output:
        print(text)
    if not fit.converged or fit.impossible:
        raise typer.Exit(1)


def validate(
    model: Annotated[Path, typer.Argument(help="model.toml of the wheel.")],
    record: Annotated[Path, typer.Argument(help="A record that it was not fitted to.")],
    out: Out,
    hold: Annotated[
        list[str] | None,
        typer.Option(help="current_bias=VALUE, offset of the drive, which no model.toml has."),
    ] = None,
    current_hold: CurrentHold = Hold.zero_order,
    columns: Columns = None,
    units: Units = None,
    unsigned_current: Unsigned = False,
    unsigned_speed: UnsignedSpeed = False,
    missing: Missing = MissingCells.refuse,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Predict a record with a known wheel: validation.json and validation.html."""
    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.core.units import RPM
    from gyrostat.identification import validate as predict
    from gyrostat.reports.page import validation_page
    from gyrostat.wheel import read_model

    check_outputs(out, ("validation.html", "validation.json"), by="validate", force=force)
    # a prediction is what shows whether the mark is right
    wheel = read_model(model, force=True)
    wheel.wheel()
    values = {**wheel.values, **words.drive(hold or [], wheel.friction.name)}
    drop, lost = missing is MissingCells.drop, unsigned_speed
    measured = load(record, columns, units, unsigned_current, drop=drop, unsigned_speed=lost)
    result = predict(
        wheel.friction,
        values,
        measured,
        current_hold=current_hold.value,
        covariance=wheel.covariance(),
    )
    text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    page = validation_page(result, command=command_line())
    with new_files(out, by="validate", force=force) as folder:
        (folder / "validation.html").write_text(page, encoding="utf-8")
        (folder / "validation.json").write_text(text + "\n", encoding="utf-8")
    say(
        f"residual {result.rms_speed:.4g} rad/s rms ({result.rms_speed / RPM:.4g} rpm), tachometer "
        f"noise {result.noise:.4g} rad/s, over {result.samples} samples and {result.crossings} "
        "zero crossings"
    )
    say(result.verdict)
    if json_output:
        print(text)
    if not result.converged:
        say("no valid result: found no initial speed that fits the record best")
    if not (result.converged and result.holds):
        raise typer.Exit(1)


def bench(
    model: Annotated[Path, typer.Argument(help="model.toml of the wheel.")],
    out: Annotated[Path, typer.Option(help="Record to write, .csv or .parquet.")],
    profile: Annotated[str, typer.Option(help="steps, sines or ramps.")] = "steps",
    duration: Annotated[str, typer.Option(help="s or with a unit.")] = "300",
    rate: Annotated[float, typer.Option(help="Samples per second.")] = 10.0,
    low: Annotated[str | None, typer.Option(help="Smallest current amplitude, A.")] = None,
    high: Annotated[str | None, typer.Option(help="Largest current amplitude, A.")] = None,
    period: Annotated[str | None, typer.Option(help="Of one step, cycle or ramp, s.")] = None,
    initial_speed: Annotated[str, typer.Option(help="rad/s or with a unit.")] = "0",
    speed_sigma: Annotated[str, typer.Option(help="Tachometer noise, rad/s or unit.")] = "0",
    speed_quantum: Annotated[str, typer.Option(help="Tachometer step, rad/s or unit.")] = "0",
    jitter: Annotated[float, typer.Option(help="Of sample times, share of interval.")] = 0.0,
    dropouts: Annotated[float, typer.Option(help="Share of missing speeds.")] = 0.0,
    seed: Annotated[int, typer.Option(help="Same seed, same record.")] = 0,
    force: ForceModel = False,
) -> None:
    """Make the record that a test bench would have taken of a known wheel."""
    from gyrostat.core.files import check_writable
    from gyrostat.core.outputs import new_files
    from gyrostat.core.units import parse_quantity
    from gyrostat.simulation import CurrentRange, Telemetry, bench_record, default_range
    from gyrostat.telemetry import write_record
    from gyrostat.wheel import read_model

    check_writable(out.parent)
    wheel = read_model(model, force=force).wheel()
    usual = default_range(wheel)
    record = bench_record(
        wheel,
        profile,
        duration=parse_quantity(duration, "time", "--duration"),
        telemetry=Telemetry(
            rate=rate,
            speed_sigma=parse_quantity(speed_sigma, "speed", "--speed-sigma"),
            speed_quantum=parse_quantity(speed_quantum, "speed", "--speed-quantum"),
            jitter=jitter,
            dropouts=dropouts,
        ),
        amplitudes=CurrentRange(
            parse_quantity(low, "current", "--low") if low else usual.low,
            parse_quantity(high, "current", "--high") if high else usual.high,
        ),
        initial_speed=parse_quantity(initial_speed, "speed", "--initial-speed"),
        period=parse_quantity(period, "time", "--period") if period else None,
        seed=seed,
        name=out.name,
    )
    with new_files(out.parent, by="bench", force=force) as folder:
        write_record(record, folder / out.name)
    say(f"written: {out}, {len(record.time)} samples, wheel of {model}")
