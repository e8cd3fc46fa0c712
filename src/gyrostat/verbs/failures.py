"""Verbs on failed wheels: attitudes that remain feasible, and the slew to one."""

from collections.abc import Iterable, Mapping
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

if TYPE_CHECKING:
    from gyrostat.core.types import Vector
    from gyrostat.failures import Holdable, Loss, Recovery
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
        failed=_momenta(failed, file),
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

    from gyrostat.core.jax64 import jnp
    from gyrostat.core.outputs import check_outputs
    from gyrostat.failures import recover as simulate
    from gyrostat.reports.recovery import FILES, write_recovery
    from gyrostat.spacecraft import Gyrostat

    if out is not None:
        check_outputs(Path(out), FILES, by="recover", force=force)
    file = _spacecraft(spacecraft)
    wanted = one_attitude("what to hold", {"--target": target, "--euler": euler})
    given = named(failed, "--failed", bare=True)
    losses = _losses(given, file, named(brake, "--brake"))
    now = one_attitude(
        "attitude at the failure", {"--attitude": attitude, "--attitude-euler": attitude_euler}
    )
    start = Gyrostat(file.spacecraft).start(
        attitude=now, rate=numbers(rate, 3, "speed", "--rate"), wheel_speed=_speeds(wheels, file)
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
        target=jnp.asarray(wanted),
        duration=in_si(duration, "time", "--duration"),
        control_period=in_si(period, "time", "--period"),
    )
    if found.flight is not None:
        names = [*file.wheel_names]
        found = replace(found, flight=found.flight.assign_coords(wheel=names))
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


def _momenta(failed: Named, file: "SpacecraftFile") -> dict[int, float]:
    """Number of each failed wheel -> its momentum, N·m·s."""
    import numpy as np

    from gyrostat.wheel.array import LIMIT_TOLERANCE

    wheels = file.spacecraft.wheels
    limits = np.broadcast_to(wheels.momentum_limit, wheels.count)
    found: dict[int, float] = {}
    for name, value in named(failed, "--failed", bare=True).items():
        number, where = file.wheel_number(name, "--failed"), f"--failed {name}"
        momentum = 0.0
        if value is not None and value != "seized":
            momentum = _momentum(value, where, float(wheels.inertia[number]))
        most = float(limits[number])
        if abs(momentum) > most * (1.0 + LIMIT_TOLERANCE):
            raise InputError(
                f"{where}: found {momentum:g} N·m·s, expected at most the wheel's momentum limit, "
                f"{most:g} N·m·s"
            )
        found[number] = momentum
    return found


def _momentum(value: Quantity, where: str, inertia: float) -> float:
    """Momentum, N·m·s, from a momentum or a speed with its unit."""
    try:
        return in_si(value, "momentum", where)
    except InputError as error:
        try:
            return inertia * in_si(value, "speed", where)
        except InputError:
            raise error from None


def _turned(attitude: "Vector | None", body: "Vector") -> "Vector | None":
    """Direction in inertial axes, from body axes."""
    from scipy.spatial.transform import Rotation

    if attitude is None:
        return None
    return Rotation.from_quat(attitude, scalar_first=True).apply(body)


def _losses(
    failed: Mapping[str, str | None], file: "SpacecraftFile", brakes: Mapping[str, str]
) -> "dict[int, Loss]":
    """Number of each failed wheel -> kind of failure, and what brakes it."""
    from gyrostat.failures import Loss

    found: dict[int, Loss] = {}
    for name, value in failed.items():
        number = file.wheel_number(name, "--failed")
        kind, _, constant = (value or "").partition(":")
        if kind == "rundown" and constant:
            found[number] = Loss(kind, in_si(constant, "time", f"--failed {name}"))
        elif kind in ("seized", "frozen", "rundown") and not constant:
            found[number] = Loss(kind)  # pyright: ignore[reportArgumentType]
        else:
            raise InputError(
                f"--failed {name}: found {value or ''!r}, expected seized, frozen or rundown:TIME"
            )
    for name, value in brakes.items():
        number = file.wheel_number(name, "--brake")
        if number not in found:
            raise InputError(f"--brake {name}: found a wheel that works, expected a failed one")
        found[number] = replace(found[number], **_brake(value, f"--brake {name}"))
    return found


def _brake(value: str, where: str) -> dict[str, float]:
    """What slows a failed wheel down, as an attribute of its failure."""
    for name, dimension in (("brake_time", "time"), ("brake_torque", "torque")):
        try:
            amount = in_si(value, dimension, where)
        except InputError:
            continue
        if amount > 0.0 and not _is_number(value):
            return {name: amount}
    raise InputError(
        f"{where}: found {value!r}, expected the time constant of the short-circuited motor "
        "('8 s') or the torque of the motor ('20 mN·m')"
    )


def _is_number(value: object) -> bool:
    """Whether a value has no unit."""
    try:
        float(str(value))
    except ValueError:
        return False
    return True


def _speeds(values: str | Iterable[Quantity], file: "SpacecraftFile") -> "Vector":
    """Wheel speeds relative to the body, rad/s, from momenta or speeds."""
    import numpy as np

    count = len(file.wheel_names)
    try:
        momentum = numbers(values, count, "momentum", "--wheels")
    except InputError as error:
        try:
            return numbers(values, count, "speed", "--wheels")
        except InputError:
            raise error from None
    inertia = np.broadcast_to(np.asarray(file.spacecraft.wheels.inertia), (count,))
    return momentum / inertia
