"""Verb `feasible`: attitudes that remain feasible after wheel failures."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import (
    Named,
    Quantity,
    Say,
    direction,
    in_si_or_none,
    named,
    numbers,
    one_attitude,
    silent,
    spacecraft_file,
)
from gyrostat.verbs.doubts import target_doubts
from gyrostat.verbs.failed_wheels import differing, failures_of, in_words, momenta_of
from gyrostat.verbs.required_options import require_options
from gyrostat.verbs.telemetry import TelemetryOptions

if TYPE_CHECKING:
    from gyrostat.failures import Holdable
    from gyrostat.spacecraft import Spacecraft, SpacecraftFile


def feasible(
    spacecraft: "SpacecraftFile | Spacecraft | str | Path",
    momentum: str | Iterable[Quantity] | None = None,
    out: "str | Path | None" = None,
    *,
    failed: Named = None,
    attitude: str | Iterable[float] | None = None,
    attitude_euler: str | Iterable[Quantity] | None = None,
    rate: str | Iterable[Quantity] | None = None,
    wheels: str | Iterable[Quantity] | None = None,
    telemetry: "str | Path | None" = None,
    target: str | Iterable[float] | None = None,
    euler: str | Iterable[Quantity] | None = None,
    boresight: str | Iterable[float] | None = None,
    towards: str | Iterable[float] | None = None,
    tolerance: Quantity | None = None,
    scalar_last: bool = False,
    fly: bool = False,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.feasible",
) -> "Holdable":
    """Find the attitudes that a spacecraft can still hold at rest after wheel failures.

    The total momentum is given by `momentum`, or follows from the telemetry: attitude, body rate
    and wheel speeds. The target is given by one of `target`, `euler`, or `boresight` with
    `towards`.

    Args:
        spacecraft: Content or path of spacecraft.toml, or a spacecraft, whose wheels are named
            "0", "1" and so on.
        momentum: Total angular momentum in inertial axes, (3,), N·m·s; None with telemetry.
        out: Folder for holdable.json and report.html; None writes no file.
        failed: Wheel -> None or "seized" (it stops), "frozen" (it keeps the momentum of the
            telemetry), "rundown" or "rundown:TIME", or the momentum that it keeps, N·m·s, or speed
            with a unit.
        attitude: Attitude at the failure, quaternion (4,), scalar first.
        attitude_euler: Attitude at the failure, 3-1-3 angles (3,), rad.
        rate: Body rate at the failure, body axes, (3,), rad/s; zero by default.
        wheels: Momentum of every wheel at the failure, N·m·s, or speed with a unit.
        telemetry: Path of a file with attitude, rate and wheel speeds; see
            `gyrostat.verbs.telemetry`.
        target: Target attitude, quaternion (4,), scalar first.
        euler: Target attitude, 3-1-3 angles (3,), rad.
        boresight: Direction in body axes, (3,) or "x", "-z", ....
        towards: Wanted direction of the boresight in inertial axes, (3,); the roll is free.
        tolerance: Pointing tolerance for the dwell time, rad.
        scalar_last: Whether quaternions have their scalar part last.
        fly: Whether report.html has a sky map on which target and momentum can be dragged and
            wheels fail; with `boresight`, `towards` and `out`.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.

    Raises:
        InputError: A spacecraft, wheel or direction cannot be used, or existing files would be
            replaced.
    """
    from gyrostat.core.outputs import check_outputs
    from gyrostat.failures import holdable
    from gyrostat.failures.query import unit_quaternion
    from gyrostat.reports.failure_inputs import Inputs
    from gyrostat.reports.feasibility import FILES, Question, write_holdable
    from gyrostat.scenario.unlikely import unlikely_spacecraft

    arguments = dict(locals())
    if out is not None:
        check_outputs(Path(out), FILES, by="holdable", force=force)
    require_options("feasible", arguments)
    file = spacecraft_file(spacecraft)
    source = TelemetryOptions(attitude, attitude_euler, rate, wheels, telemetry, scalar_last)
    if momentum is not None and source.is_given:
        raise InputError("--momentum: found it beside telemetry, expected one of them")
    failures, attitudes = failures_of(failed, file), {"--target": target, "--euler": euler}
    options = {**attitudes, "--boresight with --towards": towards}
    aim = one_attitude("what to hold", options, scalar_last=scalar_last)
    if aim is not None:
        aim = unit_quaternion(aim, "target")
    body = None if boresight is None else direction(boresight, "--boresight")
    inertial = None if towards is None else direction(towards, "--towards")
    if inertial is not None and body is None:
        raise InputError("--towards: found no --boresight, expected the body direction to point")
    pointing = None if inertial is None or body is None else (body, inertial)
    state, doubts = source.read(file) if source.is_given else (None, [])
    differences = differing(failures, file, state)
    doubts += target_doubts(target, euler, scalar_last=scalar_last)
    doubts += unlikely_spacecraft(file)
    doubts += _momentum_remarks(differences, failures, file)
    if state is not None:
        total = state.total_momentum(file.spacecraft)
    else:
        total = numbers(() if momentum is None else momentum, 3, "momentum", "--momentum")
    momenta = momenta_of(failures, file, state)
    question = Question(
        file=file,
        momentum=total,
        failed=momenta,
        target=aim,
        towards=inertial,
        boresight=body,
        tolerance=in_si_or_none(tolerance, "angle", "--tolerance"),
        inputs=Inputs(
            file.wheel_names, in_words(failures, file, momenta), aim, pointing, state, doubts
        ),
    )
    draggable = None
    if fly:
        from gyrostat.reports.sky_fly import check_sky_fly

        draggable = check_sky_fly(question, body)
    answer = holdable(
        file.spacecraft,
        total,
        failed=momenta,
        target=aim,
        boresight=pointing,
        tolerance=question.tolerance,
    )
    answer = replace(answer, question=question)
    if out is None:
        return answer
    steps = []
    if isinstance(spacecraft, str | Path):
        from gyrostat.verbs.next_steps import Query, after_feasible

        options = {**attitudes, "--boresight": pointing and boresight, "--towards": towards}
        wheel_failures = named(failed, "--failed", bare=True)
        query = Query(spacecraft, wheel_failures, source, options, Path(out))
        names = file.wheel_names
        by_name = {names[k]: value for k, value in momenta.items()}
        steps = after_feasible(query, answer, total, by_name, [names[k] for k in differences])
    content = None
    if draggable is not None:
        from gyrostat.reports.sky_fly import sky_fly_content

        path = str(spacecraft) if isinstance(spacecraft, str | Path) else "spacecraft.toml"
        content = sky_fly_content(question, draggable, path, say)
    write_holdable(
        answer, Path(out), steps=steps, fly=content, command=command, say=say, force=force
    )
    return answer


def _momentum_remarks(
    measured: Mapping[int, float], failures: Mapping[int, Any], file: "SpacecraftFile"
) -> list[str]:
    """Remarks on failed wheels whose given momentum is not that of telemetry."""
    return [
        f"wheel {file.wheel_names[k]}: {failures[k].momentum:.4g} N·m·s after the failure, but "
        f"{value:.4g} N·m·s in the telemetry"
        for k, value in measured.items()
    ]
