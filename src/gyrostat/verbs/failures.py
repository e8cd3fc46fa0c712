"""Verbs on failed wheels: attitudes that remain feasible, and the slew to one."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import (
    AXES,
    Named,
    Quantity,
    Say,
    direction,
    in_si,
    in_si_or_none,
    named,
    numbers,
    one_attitude,
    silent,
)
from gyrostat.verbs.failed_wheels import losses_of, momenta_of, speeds_of

if TYPE_CHECKING:
    from gyrostat.core.types import Vector
    from gyrostat.failures import Holdable, Recovery
    from gyrostat.spacecraft import Spacecraft, SpacecraftFile


def feasible(
    spacecraft: "SpacecraftFile | Spacecraft | str | Path",
    momentum: str | Iterable[Quantity],
    out: "str | Path | None" = None,
    *,
    failed: Named = None,
    target: str | Iterable[float] | None = None,
    euler: str | Iterable[Quantity] | None = None,
    boresight: str | Iterable[float] | None = None,
    towards: str | Iterable[float] | None = None,
    tolerance: Quantity | None = None,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.feasible",
) -> "Holdable":
    """Find the attitudes that a spacecraft can still hold at rest after wheel failures.

    The target is given by one of `target`, `euler`, or `boresight` with `towards`.

    Args:
        spacecraft: Content or path of spacecraft.toml, or a spacecraft, whose wheels are named
            "0", "1" and so on.
        momentum: Total angular momentum in inertial axes, (3,), N·m·s.
        out: Folder for holdable.json and report.html; None writes no file.
        failed: Wheel -> its remaining momentum, N·m·s, or speed with a unit; zero for None or
            "seized".
        target: Target attitude, quaternion (4,), scalar first.
        euler: Target attitude, 3-1-3 angles (3,), rad.
        boresight: Direction in body axes, (3,) or "x", "-z", ....
        towards: Wanted direction of the boresight in inertial axes, (3,); the roll is free.
        tolerance: Pointing tolerance for the dwell time, rad.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.

    Raises:
        InputError: A spacecraft, wheel or direction cannot be used, or existing files would be
            replaced.
    """
    import numpy as np

    from gyrostat.core.outputs import check_outputs
    from gyrostat.failures import holdable, holdable_sky
    from gyrostat.reports.feasibility import FILES, Drawn, Question, write_holdable

    if out is not None:
        check_outputs(Path(out), FILES, by="holdable", force=force)
    file = _spacecraft(spacecraft)
    wanted = {"--target": target, "--euler": euler, "--boresight with --towards": towards}
    question = Question(
        file=file,
        momentum=numbers(momentum, 3, "momentum", "--momentum"),
        failed=momenta_of(failed, file),
        target=one_attitude("what to hold", wanted),
        towards=None if towards is None else direction(towards, "--towards"),
        tolerance=in_si_or_none(tolerance, "angle", "--tolerance"),
    )
    body = None if boresight is None else direction(boresight, "--boresight")
    if question.towards is not None and body is None:
        raise InputError("--towards: found no --boresight, expected the body direction to point")
    answer = holdable(
        file.spacecraft,
        question.momentum,
        failed=question.failed,
        target=question.target,
        boresight=None if question.towards is None or body is None else (body, question.towards),
        tolerance=question.tolerance,
    )
    if out is None:
        return answer
    if answer.sky is not None:
        maps = [Drawn(answer.sky, question.towards, answer.direction)]
    else:
        shown = [np.array(axis) for axis in AXES.values()] if body is None else [body]
        maps = [
            Drawn(
                holdable_sky(
                    file.spacecraft, question.momentum, failed=question.failed, boresight=axis
                ),
                _turned(question.target, axis),
                _turned(answer.attitude, axis),
            )
            for axis in shown
        ]
    write_holdable(question, answer, maps, Path(out), command=command, say=say, force=force)
    return answer


def recover(
    spacecraft: "SpacecraftFile | Spacecraft | str | Path",
    failed: Named,
    wheels: str | Iterable[Quantity],
    out: "str | Path | None" = None,
    *,
    brake: Named = None,
    attitude: str | Iterable[float] | None = None,
    attitude_euler: str | Iterable[Quantity] | None = None,
    rate: str | Iterable[Quantity] = (0.0, 0.0, 0.0),
    target: str | Iterable[float] | None = None,
    euler: str | Iterable[Quantity] | None = None,
    duration: Quantity = 600.0,
    period: Quantity = 0.5,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.recover",
) -> "Recovery":
    """Simulate the slew to the nearest feasible attitude after wheel failures.

    Args:
        spacecraft: Content or path of spacecraft.toml, or a spacecraft, whose wheels are named
            "0", "1" and so on.
        failed: Wheel -> "seized", "frozen" (no torque, constant momentum) or "rundown:TIME".
        wheels: Momentum of every wheel at the failure, N·m·s, or speed with a unit.
        out: Folder for recover.json, run.nc and report.html; None writes no file.
        brake: Failed wheel -> what brakes it: the time constant of its short-circuited motor, s, or
            the torque with which the motor still brakes, N·m; as text with a unit.
        attitude: Attitude at the failure, quaternion (4,), scalar first. Give this or the next one.
        attitude_euler: Attitude at the failure, 3-1-3 angles (3,), rad.
        rate: Body rate at the failure, body axes, (3,), rad/s.
        target: Target attitude, quaternion (4,), scalar first. Give this or the next one.
        euler: Target attitude, 3-1-3 angles (3,), rad.
        duration: Duration of the simulation, s.
        period: Control period, s.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.

    Returns:
        The recovery; `settle` is None if the spacecraft did not settle, and `reason` says why.

    Raises:
        InputError: A spacecraft, wheel or state cannot be used, or existing files would be
            replaced.
    """
    import numpy as np

    from gyrostat.core.outputs import check_outputs
    from gyrostat.failures import recover as simulate
    from gyrostat.failures import state_of
    from gyrostat.reports.recovery import FILES, write_recovery
    from gyrostat.simulation.labelled import Signal

    if out is not None:
        check_outputs(Path(out), FILES, by="recover", force=force)
    file = _spacecraft(spacecraft)
    wanted = one_attitude("what to hold", {"--target": target, "--euler": euler})
    given = named(failed, "--failed", bare=True)
    losses = losses_of(given, file, named(brake, "--brake"))
    now = one_attitude(
        "attitude at the failure", {"--attitude": attitude, "--attitude-euler": attitude_euler}
    )
    start = state_of(
        file.spacecraft,
        np.asarray(now),
        numbers(rate, 3, "speed", "--rate"),
        speeds_of(wheels, file),
    )
    if not all(np.all(np.isfinite(part)) for part in start if part is not None):
        raise InputError(
            "--attitude, --rate, --wheels: found a value that is not finite, expected numbers"
        )
    lost = ", ".join(f"{name}={how}" for name, how in given.items())
    say(f"simulating {file.name or _source(spacecraft)} from the failure of {lost}")
    found = simulate(
        file.spacecraft,
        start,
        losses,
        target=np.asarray(wanted),
        duration=in_si(duration, "time", "--duration"),
        control_period=in_si(period, "time", "--period"),
    )
    flown = found.histories
    if flown is not None:
        names = Signal(("wheel",), np.array(file.wheel_names))
        flown = replace(flown, coordinates={**flown.coordinates, "wheel": names})
        found = replace(found, histories=flown)
    if out is not None:
        write_recovery(file, found, losses, Path(out), command=command, say=say, force=force)
    return found


def _spacecraft(spacecraft: "SpacecraftFile | Spacecraft | str | Path") -> "SpacecraftFile":
    """Read spacecraft.toml; the wheels of a spacecraft object are named by their numbers."""
    from gyrostat.spacecraft import Spacecraft, SpacecraftFile, read_spacecraft

    if isinstance(spacecraft, Spacecraft):
        spacecraft.check()
        names = tuple(str(k) for k in range(spacecraft.wheels.count))
        return SpacecraftFile("", names, spacecraft, ({},) * len(names))
    return read_spacecraft(spacecraft) if isinstance(spacecraft, str | Path) else spacecraft


def _source(spacecraft: object) -> str:
    """Path of a spacecraft, or its type if it has none, for a message."""
    return str(spacecraft) if isinstance(spacecraft, str | Path) else "the spacecraft"


def _turned(attitude: "Vector | None", body: "Vector") -> "Vector | None":
    """Direction in inertial axes, from body axes."""
    from gyrostat.failures.attitudes import matrix_of

    return None if attitude is None else matrix_of(attitude) @ body
