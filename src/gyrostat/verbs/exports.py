"""Verb `export`: flight C, FMU, Basilisk module or data sheet."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, Say, one_of, refuse_given, silent
from gyrostat.verbs.export_format import CodeFormat, ModuleFormat, WheelFormat
from gyrostat.verbs.exported_parts import Choice, code_texts, flight_target, name_of, named
from gyrostat.verbs.flight_folder import PAGE, complete, flight_folder
from gyrostat.verbs.format_kinds import CODE, FORMATS, OF_PARTS
from gyrostat.verbs.part_kinds import PARTS, part_kind
from gyrostat.verbs.required_options import missing_of_part, names_scenario, require_given
from gyrostat.verbs.scenario_check import say_unlikely
from gyrostat.verbs.wheel_arguments import wheel_model

if TYPE_CHECKING:
    from gyrostat.exports import Part, Search
    from gyrostat.identification import Fit
    from gyrostat.scenario import Scenario
    from gyrostat.wheel import Wheel, WheelModel

LONGEST_DELAY = 1000
"""Control periods."""


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
    name: str | None = None,
    evidence: bool = False,
    reasons: "str | Path | None" = None,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.export",
) -> tuple[Path, ...]:
    """Write flight code in C, a unit or module for other simulators, or a data sheet.

    A complete part, such as an `EstimatingCompensator`, is exported as it is. For a wheel, its
    model or an identification, the part is designed from `what` and the options. Of a scenario, the
    controller is exported with its estimator, compensator and [guard], including user-defined
    parts; the control period is that of the scenario.

    The emitted code validates every input: finite, within its range and its rate limit.

    Args:
        model: Part, wheel, wheel model, identification, scenario, or path of model.toml or
            scenario.toml.
        out: Folder for the files.
        to: "c" for flight, "cfs" (application for NASA's core Flight System), "fprime" (component
            for F Prime), "fmu" (co-simulation unit, FMI 2.0), "basilisk" (Python module) or "json"
            (data sheet).
        what: Part to design, with "c", "cfs", "fprime" and "fmu" unless `model` is a part:
            "compensated-wheel", "compensator", "controller", "estimator" or "wheel".
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
        name: Name of the flight module and prefix of its functions, with "c", "cfs", "fprime" and
            "fmu"; by default "compensator", "controller" and so on.
        evidence: Whether to seek test vectors that show every condition of the C code, and to check
            it with the tools that are installed, as `make evidence` in the folder does. Each
            outcome is said; `gyrostat.exports.read_results` reads them.
        reasons: Path of a TOML file with reasons for what no test vector can show of your own code,
            and for deviations from MISRA C:2012; with `evidence`.
        force: Whether to replace files that gyrostat did not write, and to take a wheel that is
            marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the README of the C code names as its origin.

    Returns:
        The files written.

    Raises:
        InputError: A part, model or option cannot be used, or existing files would be replaced.
    """
    from gyrostat.core.files import check_writable, write_texts
    from gyrostat.core.outputs import new_files

    folder = Path(out)
    check_writable(folder)
    form = FORMATS[one_of(to, FORMATS, "--to")]
    if what is not None:
        one_of(what, PARTS, "--what")
    one_of(precision, ("double", "float"), "--precision")
    one_of(on_bad, ("hold", "zero"), "--on-bad")
    if name is not None and re.fullmatch(r"[a-z][a-z0-9_]*", name) is None:
        raise InputError(f"--name: found {name!r}, expected lower-case letters, digits and _")
    if not 0 <= delay <= LONGEST_DELAY:
        raise InputError(f"--delay: found {delay}, expected 0 to {LONGEST_DELAY} control periods")
    search = _search(say, reasons, evidence=evidence)
    design_options = {
        "--gains": gains,
        "--table-inertia": table_inertia,
        "--speed-sigma": speed_sigma,
        "--current-limit": current_limit,
        "--delay": delay or None,
        "--scale-drift": scale_drift,
    }
    every = {"--period": period, **design_options, "--range": range_, "--rate-limit": rate_limit}
    scenario = _scenario_of(model, force=force)
    kind = _kind_of(model) if scenario is None else "controller"
    target, texts, origin = None, {}, f"Made by `{command}`."
    content = None if kind is not None else wheel_model(model, force=force)  # pyright: ignore[reportArgumentType]
    if not issubclass(form, CodeFormat):
        code_options: dict[str, object] = {"--precision": precision == "float"}
        code_options |= {"--evidence": evidence, "--reasons": reasons}
        refuse_given(code_options, f"--to {to}", f"--to {CODE}")
    if scenario is not None:
        if not issubclass(form, CodeFormat):
            raise InputError(f"--to {to}: found {name_of(scenario)}, expected --to {CODE}")
        from gyrostat.exports import scenario_controller

        say_unlikely(scenario, say)
        _part_to_export(model, kind, what)
        refuse_given(
            {**every, "--on-bad": on_bad == "zero" and scenario.guard is not None},
            "a scenario",
            "a part or model.toml, and the scenario's values",
        )
        module = named(scenario_controller(scenario, on_bad), name)
        texts = form.texts(module, precision, origin, search)
    elif issubclass(form, WheelFormat):
        if content is None:
            raise InputError(f"--to {to}: found {name_of(model)}, expected a wheel or its model")
        part_options = {"--what": what, **every, "--on-bad": on_bad == "zero", "--name": name}
        refuse_given(part_options, f"--to {to}", f"--to {OF_PARTS}")
        texts = form.texts(content)
    else:
        what = _part_to_export(model, kind, what)
        options = {"period": period, "gains": gains, "table_inertia": table_inertia}
        options |= {"speed_sigma": speed_sigma, "scale_drift": scale_drift}
        where = f"--to {to}" if what is None else f"--what {what}"
        require_given(where, missing_of_part(what, options, is_designed=content is not None))
        assert what is not None
        assert period is not None
        choice = Choice(what, period, design_options, range_, rate_limit, on_bad, name)
        if issubclass(form, CodeFormat):
            texts = code_texts(form, model, content, choice, precision, origin, search)
        else:
            target = flight_target(model, content, choice)
    names, results = [*texts], {}
    place = flight_folder(texts)
    with new_files(folder, by="export", force=force) as scratch:
        write_texts(scratch, texts)
        if issubclass(form, CodeFormat):
            outcome = {"evidence": evidence, "command": command, "say": say}
            results = complete(scratch / place, folder / place, **outcome)
            names.append((place / PAGE).as_posix())
        if target is not None and issubclass(form, ModuleFormat):
            names = form.write(target, scratch, say)
    write_texts(folder / place, results)
    paths = tuple(folder / file for file in names)
    proofs = folder / place / "evidence"
    listed = [str(path) for path in paths if proofs not in path.parents]
    if len(listed) < len(paths):
        listed.append(f"{len(paths) - len(listed)} files in {proofs}")
    say(f"written: {', '.join(listed)}")
    return paths


def _search(say: Say, reasons: "str | Path | None", *, evidence: bool) -> "Search | None":
    """Search for test vectors, with the reasons of the user; None without evidence."""
    if not evidence:
        if reasons is not None:
            raise InputError("--reasons: found without --evidence, expected with it")
        return None
    from gyrostat.exports import Search, read_reasons

    return Search(say) if reasons is None else Search(say, read_reasons(Path(reasons)))


def _scenario_of(model: Any, *, force: bool) -> "Scenario | None":
    """Scenario, or that of a scenario file; None for anything else."""
    from gyrostat.scenario.scenario import Scenario

    if isinstance(model, Scenario):
        return model
    if not isinstance(model, str | Path):
        return None
    from gyrostat.scenario_files.shipped import path_of

    path = path_of(Path(model))
    if not names_scenario(path):
        return None
    from gyrostat.scenario_files.scenario_file import read_scenario

    return read_scenario(path, force=force)


def _kind_of(model: Any) -> str | None:
    """Kind of a part; None for a wheel, its model or a path."""
    if isinstance(model, str | Path):
        return None
    return part_kind(model)


def _part_to_export(model: Any, kind: str | None, choice: str | None) -> str | None:
    """Kind of part to export: that of the part, or the option."""
    if kind is not None and choice not in (None, kind):
        raise InputError(f"--what {choice}: found {name_of(model)}, expected {kind}, or no --what")
    return kind or choice
