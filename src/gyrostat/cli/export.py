"""Verb `export`: flight C, FMU, Basilisk module or data sheet."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gyrostat.cli.arguments import command_line, refuse_given, say
from gyrostat.cli.measurement_limits import measurement_limits
from gyrostat.cli.options import ForceModel, Json, Out
from gyrostat.core.errors import InputError

if TYPE_CHECKING:
    from gyrostat.exports import Target
    from gyrostat.wheel import Wheel


class Format(StrEnum):
    """What is written."""

    c = "c"
    fmu = "fmu"
    basilisk = "basilisk"
    json = "json"


class What(StrEnum):
    """What flies."""

    compensated_wheel = "compensated-wheel"
    compensator = "compensator"
    controller = "controller"
    estimator = "estimator"
    wheel = "wheel"


class OnBad(StrEnum):
    """Safe command in place of one from a rejected sample."""

    hold = "hold"
    zero = "zero"


class Precision(StrEnum):
    """Of real numbers in C."""

    double = "double"
    float = "float"


Text = str | None


def export(
    model: Annotated[Path, typer.Argument(help="model.toml: the wheel.")],
    out: Out,
    to: Annotated[
        Format,
        typer.Option(
            help="C for flight, a co-simulation unit (FMI 2.0), a Python module for Basilisk, a "
            "data sheet."
        ),
    ],
    what: Annotated[What | None, typer.Option(help="With --to c and fmu: what flies.")] = None,
    precision: Annotated[Precision, typer.Option(help="Of the numbers in C.")] = Precision.double,
    period: Annotated[Text, typer.Option(help="Control period, s or with a unit.")] = None,
    gains: Annotated[
        Text, typer.Option(help="Of the attitude law: KP,KI,KD in N·m/rad, N·m/(rad·s), N·m·s/rad.")
    ] = None,
    table_inertia: Annotated[
        Text, typer.Option(help="Of what the wheel turns, without its rotor, kg·m² or a unit.")
    ] = None,
    speed_sigma: Annotated[
        Text, typer.Option(help="Noise of a tachometer sample, rad/s or with a unit.")
    ] = None,
    current_limit: Annotated[Text, typer.Option(help="Of the motor, A or with a unit.")] = None,
    delay: Annotated[
        int, typer.Option(min=0, max=1000, help="Control periods from a sample to its command.")
    ] = 0,
    scale_drift: Annotated[
        Text, typer.Option(help="Of the friction level, 1/√s, for the estimator.")
    ] = None,
    range_: Annotated[
        list[str] | None,
        typer.Option(
            "--range",
            help="Accepted values of an input, FIELD=LOWER:UPPER, SI or with units, as "
            "rate=-2deg/s:2deg/s; once for each field.",
        ),
    ] = None,
    rate_limit: Annotated[
        list[str] | None,
        typer.Option(help="Largest accepted change of an input, FIELD=VALUE, its SI unit per s."),
    ] = None,
    on_bad: Annotated[
        OnBad, typer.Option(help="Command in place of one from a rejected sample.")
    ] = OnBad.hold,
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """Write flight code in C, a unit or module for other simulators, or a data sheet.

    Every input that is emitted is validated: finite, within its range and its rate limit.
    """
    import json

    from gyrostat.core.files import check_writable
    from gyrostat.core.outputs import new_files
    from gyrostat.exports import basilisk, files, sheet, write_fmu
    from gyrostat.wheel import read_model

    check_writable(out)
    given = {
        "--gains": gains,
        "--table-inertia": table_inertia,
        "--speed-sigma": speed_sigma,
        "--current-limit": current_limit,
        "--delay": str(delay) if delay else None,
        "--scale-drift": scale_drift,
    }
    content, target = read_model(model, force=force), None
    if to is not Format.c:
        refuse_given({"--precision": precision is Precision.float}, f"--to {to}", "--to c")
    if to in (Format.json, Format.basilisk):
        guard = {
            "--range": range_,
            "--rate-limit": rate_limit,
            "--on-bad": on_bad is OnBad.zero,
        }
        refuse_given(
            {"--what": what, "--period": period, **given, **guard}, f"--to {to}", "--to c or fmu"
        )
        name = "wheel.json" if to is Format.json else "wheel_basilisk.py"
        texts = {name: sheet(content) if to is Format.json else basilisk(content)}
    elif what is None or period is None:
        missing = "--what" if what is None else "--period"
        raise InputError(f"--to {to}: found no {missing}, expected what flies and its period")
    else:
        limits = measurement_limits(what.value, range_ or [], rate_limit or [])
        if what is What.wheel:
            refuse_given({"--on-bad": on_bad is OnBad.zero}, f"--what {what}", "another --what")
        target = _target(what, content.wheel(), period, given, (limits, on_bad.value))
        texts = {}
        if to is Format.c:
            texts = files(target, precision.value, f"Made by `{command_line()}`.")
    with new_files(out, by="export", force=force) as folder:
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        names = list(texts)
        if target is not None and to is Format.fmu:
            names = [f"{target.name}.fmu"]
            if write_fmu(target, folder / names[0]) is None:
                say("found no C compiler: the unit holds its sources alone")
    say(f"written: {', '.join(str(out / name) for name in names)}")
    if json_output:
        print(json.dumps({"files": names}))


NEEDED = {
    What.compensated_wheel: ("--gains", "--table-inertia", "--speed-sigma"),
    What.compensator: ("--gains", "--table-inertia", "--speed-sigma"),
    What.controller: ("--gains",),
    What.estimator: ("--speed-sigma", "--scale-drift"),
    What.wheel: (),
}
TAKEN = {
    What.compensated_wheel: ("--current-limit", "--delay"),
    What.compensator: ("--current-limit", "--delay"),
    What.controller: ("--current-limit",),
}


def _target(
    what: What, wheel: "Wheel", period_text: str, given: dict[str, Text], guard: tuple[Any, str]
) -> "Target":
    """The flight piece that the options describe."""
    import math

    from gyrostat.cli.feasibility import numbers
    from gyrostat.control import AttitudePID, CurrentMode, EstimatingCompensator
    from gyrostat.core.units import parse_quantity
    from gyrostat.core.validation import LARGEST, check_parts, require, require_period
    from gyrostat.estimation import FrictionScaleFilter
    from gyrostat.exports import TARGETS, CompensatedWheel

    known = (*NEEDED[what], *TAKEN.get(what, ()))
    for option in NEEDED[what]:
        if given[option] is None:
            raise InputError(f"--what {what}: found no {option}, expected its value")
    others = {option: value for option, value in given.items() if option not in known}
    refuse_given(others, f"--what {what}", "what flies being another")
    period = parse_quantity(period_text, "time", "--period")
    require_period("--period", period)

    def quantity(option: str, dimension: str) -> float:
        return parse_quantity(str(given[option]), dimension, option)

    limit = math.inf
    if given["--current-limit"] is not None:
        limit = quantity("--current-limit", "current")
        require("--current-limit", limit, "A", positive=True)
    if what is What.wheel:
        return TARGETS[what](wheel, period)
    if what is What.estimator:
        drift = float(numbers(str(given["--scale-drift"]), 1, None, "--scale-drift")[0])
        piece = FrictionScaleFilter(wheel, quantity("--speed-sigma", "speed"), drift)
        check_parts(piece)
        return TARGETS[what](piece, period, *guard)
    law = AttitudePID(*map(float, numbers(str(given["--gains"]), 3, None, "--gains")))
    if not all(abs(g) <= LARGEST for g in (law.proportional, law.integral, law.derivative)):
        raise InputError(
            f"--gains: found {given['--gains']}, expected finite numbers of size below {LARGEST:g}"
        )
    if what is What.controller:
        return TARGETS[what](CurrentMode(law, wheel.motor_constant, limit), period, *guard)
    delay = int(given["--delay"] or 0)
    compensator = EstimatingCompensator.tuned(
        law,
        wheel,
        quantity("--table-inertia", "inertia"),
        quantity("--speed-sigma", "speed"),
        period,
        current_limit=limit,
        delay=delay,
    )
    check_parts(compensator)
    if what is What.compensated_wheel:
        return TARGETS[what](CompensatedWheel(compensator, wheel), period, *guard)
    return TARGETS[what](compensator, period, *guard)
