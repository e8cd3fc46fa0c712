"""Verb `export`: flight C, FMU, Basilisk module or data sheet."""

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import (
    Named,
    Quantity,
    Say,
    in_si,
    numbers,
    one_of,
    refuse_given,
    silent,
)
from gyrostat.verbs.measurement_limits import measurement_limits
from gyrostat.verbs.wheel_arguments import wheel_model

if TYPE_CHECKING:
    from gyrostat.campaigns import Scenario
    from gyrostat.exports import Part
    from gyrostat.identification import Fit
    from gyrostat.wheel import Wheel, WheelModel

LONGEST_DELAY = 1000
"""Control periods."""
FORMATS = ("c", "fmu", "basilisk", "json")
NEEDED = {
    "compensated-wheel": ("--gains", "--table-inertia", "--speed-sigma"),
    "compensator": ("--gains", "--table-inertia", "--speed-sigma"),
    "controller": ("--gains",),
    "estimator": ("--speed-sigma", "--scale-drift"),
    "wheel": (),
}
"""Part to design -> required options."""
TAKEN = {
    "compensated-wheel": ("--current-limit", "--delay"),
    "compensator": ("--current-limit", "--delay"),
    "controller": ("--current-limit",),
}
"""Part to design -> optional options."""


def export(
    model: "Part | WheelModel | Wheel | Fit | Scenario | str | Path",
    out: "str | Path",
    to: str,
    *,
    what: str | None = None,
    precision: str = "double",
    period: Quantity | None = None,
    gains: str | Iterable[float] | None = None,
    table_inertia: Quantity | None = None,
    speed_sigma: Quantity | None = None,
    current_limit: Quantity | None = None,
    delay: int = 0,
    scale_drift: Quantity | None = None,
    range_: Named = None,
    rate_limit: Named = None,
    on_bad: str = "hold",
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.export",
) -> tuple[Path, ...]:
    """Write flight code in C, a unit or module for other simulators, or a data sheet.

    A complete part, such as an `EstimatingCompensator`, is exported as it is. For a wheel, its
    model or an identification, the part is designed from `what` and the options. Of a scenario, the
    controller is exported with its estimator, compensator and [guard], own parts included; the
    control period is that of the scenario.

    The emitted code validates every input: finite, within its range and its rate limit.

    Args:
        model: Part, wheel, wheel model, identification, scenario, or path of model.toml or
            scenario.toml.
        out: Folder for the files.
        to: "c" for flight, "fmu" (co-simulation unit, FMI 2.0), "basilisk" (Python module) or
            "json" (data sheet).
        what: Part to design, with "c" and "fmu" unless `model` is a part: "compensated-wheel",
            "compensator", "controller", "estimator" or "wheel".
        precision: Precision of real numbers in C: "double" or "float".
        period: Control period, s.
        gains: Gains of the attitude law, (3,), N·m/rad, N·m/(rad·s), N·m·s/rad.
        table_inertia: Inertia of the body that the wheel turns, without the rotor, kg·m².
        speed_sigma: Standard deviation of a tachometer sample, rad/s.
        current_limit: Limit of the motor current, A.
        delay: Delay from a sample to its command, control periods.
        scale_drift: Drift of the friction level assumed by the estimator, 1/√s.
        range_: Accepted values of inputs: field -> (lower, upper).
        rate_limit: Largest accepted change of inputs: field -> SI unit per second.
        on_bad: Command after a rejected sample: "hold" (last accepted) or "zero".
        force: Whether to replace files that gyrostat did not write, and to take a wheel that is
            marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the README of the C code names as its origin.

    Returns:
        The files written.

    Raises:
        InputError: A part, model or option cannot be used, or existing files would be replaced.
    """
    from gyrostat.core.files import check_writable
    from gyrostat.core.outputs import new_files
    from gyrostat.exports import basilisk, files, part_kind, scenario_controller, sheet, write_fmu

    folder = Path(out)
    check_writable(folder)
    one_of(to, FORMATS, "--to")
    one_of(precision, ("double", "float"), "--precision")
    one_of(on_bad, ("hold", "zero"), "--on-bad")
    if not 0 <= delay <= LONGEST_DELAY:
        raise InputError(f"--delay: found {delay}, expected 0 to {LONGEST_DELAY} control periods")
    given = {
        "--gains": gains,
        "--table-inertia": table_inertia,
        "--speed-sigma": speed_sigma,
        "--current-limit": current_limit,
        "--delay": delay or None,
        "--scale-drift": scale_drift,
    }
    scenario = _scenario_of(model, force=force)
    kind = part_kind(model) if scenario is None else "controller"
    target, texts = None, {}
    content = None if kind is not None else wheel_model(model, force=force)  # pyright: ignore[reportArgumentType]
    if to != "c":
        refuse_given({"--precision": precision == "float"}, f"--to {to}", "--to c")
    if scenario is not None:
        if to != "c":
            raise InputError(f"--to {to}: found {_name(scenario)}, expected --to c")
        _what(model, kind, what)
        limits = {"--range": range_, "--rate-limit": rate_limit}
        fixed = {"--on-bad": on_bad == "zero" and scenario.guard is not None}
        refuse_given(
            {"--period": period, **given, **limits, **fixed},
            "a scenario",
            "a part or model.toml, and the scenario's values",
        )
        target = scenario_controller(scenario, on_bad)
        texts = files(target, precision, f"Made by `{command}`.")  # pyright: ignore[reportArgumentType]
    elif to in ("json", "basilisk"):
        if content is None:
            raise InputError(f"--to {to}: found {_name(model)}, expected a wheel or its model")
        guard = {"--range": range_, "--rate-limit": rate_limit, "--on-bad": on_bad == "zero"}
        design = {"--what": what, "--period": period, **given}
        refuse_given({**design, **guard}, f"--to {to}", "--to c or fmu")
        name = "wheel.json" if to == "json" else "wheel_basilisk.py"
        texts = {name: sheet(content) if to == "json" else basilisk(content)}
    else:
        what = _what(model, kind, what)
        if what is None or period is None:
            missing = "--what" if what is None else "--period"
            raise InputError(
                f"--to {to}: found no {missing}, expected the part and its control period"
            )
        limits = measurement_limits(one_of(what, NEEDED, "--what"), range_, rate_limit)
        if what == "wheel":
            refuse_given({"--on-bad": on_bad == "zero"}, f"--what {what}", "another --what")
        target = _target(model, content, what, period, given, limits, on_bad)
        if to == "c":
            texts = files(target, precision, f"Made by `{command}`.")  # pyright: ignore[reportArgumentType]
    names = [*texts] if target is None or to == "c" else [f"{target.name}.fmu"]
    with new_files(folder, by="export", force=force) as scratch:
        for name, text in texts.items():
            (scratch / name).write_text(text, encoding="utf-8")
        if target is not None and to == "fmu" and write_fmu(target, scratch / names[0]) is None:
            say("found no C compiler: the unit contains its sources only")
    written = tuple(folder / name for name in names)
    say(f"written: {', '.join(map(str, written))}")
    return written


def _scenario_of(model: Any, *, force: bool) -> "Scenario | None":
    """Scenario, or that of a scenario file; None for anything else."""
    from gyrostat.campaigns.scenario import Scenario

    if isinstance(model, Scenario):
        return model
    if not isinstance(model, str | Path):
        return None
    from gyrostat.core.toml_file import read_toml

    path = Path(model)
    if path.suffix != ".toml" or "spacecraft" not in read_toml(path, "a model file"):
        return None
    from gyrostat.campaigns.reading.scenario_file import read_scenario

    return read_scenario(path, force=force)


def _name(model: Any) -> str:
    return f"an object of {type(model).__name__}"


def _what(model: Any, kind: str | None, what: str | None) -> str | None:
    """Kind of part to export: that of the part, or the option."""
    if kind is not None and what not in (None, kind):
        raise InputError(f"--what {what}: found {_name(model)}, expected {kind}, or no --what")
    return kind or what


def _target(
    part: Any,
    model: "WheelModel | None",
    what: str,
    period_given: Quantity,
    given: dict[str, Any],
    limits: Any,
    on_bad: str,
) -> Any:
    """Flight module of a part, or of one designed from a wheel model and the options."""
    from gyrostat.core.validation import check_parts, require_period
    from gyrostat.exports import TARGETS

    if model is None:
        refuse_given(given, _name(part), "a wheel or its model")
    else:
        known = (*NEEDED[what], *TAKEN.get(what, ()))
        for option in NEEDED[what]:
            if given[option] is None:
                raise InputError(f"--what {what}: found no {option}, expected its value")
        others = {option: value for option, value in given.items() if option not in known}
        refuse_given(others, f"--what {what}", "another --what")
    period = in_si(period_given, "time", "--period")
    require_period("--period", period)
    if model is not None:
        part = _designed(model.wheel(), what, period, given)
    if what == "wheel":
        return TARGETS[what](part, period)
    check_parts(part)
    return TARGETS[what](part, period, limits, on_bad)


def _designed(wheel: "Wheel", what: str, period: float, given: dict[str, Any]) -> Any:
    """Part designed from the options: option -> value, or None if it is not given."""
    from gyrostat.control import AttitudePID, CurrentMode, EstimatingCompensator
    from gyrostat.core.validation import LARGEST, check_parts, require
    from gyrostat.estimation import FrictionScaleFilter
    from gyrostat.exports import CompensatedWheel

    def si(option: str, dimension: str) -> float:
        return in_si(given[option], dimension, option)

    limit = math.inf
    if given["--current-limit"] is not None:
        limit = si("--current-limit", "current")
        require("--current-limit", limit, "A", positive=True)
    if what == "wheel":
        return wheel
    if what == "estimator":
        drift = float(numbers(given["--scale-drift"], 1, None, "--scale-drift")[0])
        return FrictionScaleFilter(wheel, si("--speed-sigma", "speed"), drift)
    law = AttitudePID(*map(float, numbers(given["--gains"], 3, None, "--gains")))
    if not all(abs(g) <= LARGEST for g in (law.proportional, law.integral, law.derivative)):
        raise InputError(
            f"--gains: found {given['--gains']}, expected finite numbers of size below {LARGEST:g}"
        )
    if what == "controller":
        return CurrentMode(law, wheel.motor_constant, limit)
    compensator = EstimatingCompensator.tuned(
        law,
        wheel,
        si("--table-inertia", "inertia"),
        si("--speed-sigma", "speed"),
        period,
        current_limit=limit,
        delay=int(given["--delay"] or 0),
    )
    check_parts(compensator)
    return compensator if what == "compensator" else CompensatedWheel(compensator, wheel)
