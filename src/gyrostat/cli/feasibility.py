"""Verb `holdable`: attitudes that remain feasible after wheel failures."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyrostat.cli import arguments as words
from gyrostat.cli.arguments import command_line, say
from gyrostat.cli.options import Force, Json, Out
from gyrostat.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gyrostat.core.types import Vector
    from gyrostat.spacecraft import SpacecraftFile

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def holdable(
    spacecraft: Annotated[Path, typer.Argument(help="spacecraft.toml: body and wheels.")],
    momentum: Annotated[
        str, typer.Option(help="Total, inertial axes: HX,HY,HZ, N·m·s or with units.")
    ],
    out: Out,
    failed: Annotated[
        list[str] | None,
        typer.Option(
            help="A wheel that failed: NAME or NAME=seized (no momentum), NAME=0.3 (N·m·s), "
            "NAME=1500rpm."
        ),
    ] = None,
    target: Annotated[
        str | None, typer.Option(help="Attitude to hold: quaternion Q0,Q1,Q2,Q3, scalar first.")
    ] = None,
    euler: Annotated[
        str | None,
        typer.Option(help="Attitude to hold: 3-1-3 angles PHI,THETA,PSI, rad or with units."),
    ] = None,
    boresight: Annotated[
        str | None, typer.Option(help="Body direction X,Y,Z or x, -z, ...; for the map, or:")
    ] = None,
    towards: Annotated[
        str | None, typer.Option(help="Inertial direction that it should point at, any roll.")
    ] = None,
    tolerance: Annotated[
        str | None, typer.Option(help="Of pointing, rad or with a unit: for the dwell time.")
    ] = None,
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Say what can still be held at rest after wheels failed: holdable.json and report.html."""
    import numpy as np

    from gyrostat.core.outputs import check_outputs
    from gyrostat.core.units import parse_quantity
    from gyrostat.failures import holdable as ask
    from gyrostat.failures import holdable_sky
    from gyrostat.reports.feasibility import FILES, Drawn, Question, write_holdable
    from gyrostat.spacecraft import read_spacecraft

    check_outputs(out, FILES, by="holdable", force=force)
    file = read_spacecraft(spacecraft)
    question = Question(
        file=file,
        momentum=numbers(momentum, 3, "momentum", "--momentum"),
        failed=_failed(failed or [], file),
        target=attitude(
            "what to hold",
            {"--target": target, "--euler": euler, "--boresight with --towards": towards},
        ),
        towards=None if towards is None else _direction(towards, "--towards"),
        tolerance=None if tolerance is None else parse_quantity(tolerance, "angle", "--tolerance"),
    )
    known = {"failed": question.failed}
    body = None if boresight is None else _direction(boresight, "--boresight")
    if question.towards is not None and body is None:
        raise InputError("--towards: found no --boresight, expected the body direction to point")
    pointing = None if question.towards is None or body is None else (body, question.towards)
    answer = ask(
        file.spacecraft,
        question.momentum,
        target=question.target,
        boresight=pointing,
        tolerance=question.tolerance,
        **known,
    )
    if answer.sky is not None:
        maps = [Drawn(answer.sky, question.towards, answer.direction)]
    else:
        shown = [np.array(axis) for axis in AXES.values()] if body is None else [body]
        maps = [
            Drawn(
                holdable_sky(file.spacecraft, question.momentum, boresight=axis, **known),
                _turned(question.target, axis),
                _turned(answer.attitude, axis),
            )
            for axis in shown
        ]
    text = write_holdable(question, answer, maps, out, command=command_line(), say=say, force=force)
    if json_output:
        print(text)


def numbers(text: str, count: int, dimension: str | None, option: str) -> "Vector":
    """So many values separated by commas, SI; plain numbers without a dimension."""
    import numpy as np

    parts = text.split(",")
    if len(parts) != count:
        raise InputError(f"{option}: found {text!r}, expected {count} values with commas between")
    if dimension is not None:
        return np.array(words.quantities(text, dimension, option))
    try:
        return np.array([float(part) for part in parts])
    except ValueError:
        raise InputError(f"{option}: found {text!r}, expected {count} numbers") from None


def _direction(text: str, option: str) -> "Vector":
    """A unit vector: X,Y,Z of any length, or the name of an axis."""
    import numpy as np

    from gyrostat.failures.query import unit_vector

    name, sign = text.strip().lstrip("+-"), -1.0 if text.strip().startswith("-") else 1.0
    if name in AXES:
        return sign * np.array(AXES[name])
    return unit_vector(numbers(text, 3, None, option), 3, option)


def attitude(what: str, options: "Mapping[str, str | None]") -> "Vector | None":
    """The attitude that one of some options gives, as a quaternion (4,), or None for another.

    Args:
        what: it is, for the message.
        options: option -> its value; a name with "euler" in it means 3-1-3 angles, one with
            "boresight" no attitude.

    Raises:
        InputError: none is given, or several are.
    """
    import numpy as np

    given = [option for option, value in options.items() if value is not None]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        raise InputError(f"{what}: found {found}, expected one of {', '.join(options)}")
    name, text = given[0], str(options[given[0]])
    if "boresight" in name:
        return None
    if "euler" not in name:
        return numbers(text, 4, None, name)
    from scipy.spatial.transform import Rotation

    angles = numbers(text, 3, "angle", name)
    return Rotation.from_euler("ZXZ", angles).as_quat(scalar_first=True) + np.zeros(4)


def _failed(items: list[str], file: "SpacecraftFile") -> dict[int, float]:
    """Number of each failed wheel -> its momentum, N·m·s."""
    import numpy as np

    from gyrostat.core.units import parse_quantity
    from gyrostat.wheel.array import LIMIT_TOLERANCE

    wheels = file.spacecraft.wheels
    found: dict[int, float] = {}
    for item in (part.strip() for entry in items for part in entry.split(",")):
        name, _, value = (part.strip() for part in item.partition("="))
        number = file.wheel_number(name, "--failed")
        if number in found:
            raise InputError(f"--failed: found {name} twice, expected it once")
        if value in ("", "seized"):
            found[number] = 0.0
            continue
        where = f"--failed {name}"
        try:
            momentum = parse_quantity(value, "momentum", where)
        except InputError as error:
            try:
                speed = parse_quantity(value, "speed", where)
            except InputError:
                raise error from None
            momentum = float(file.spacecraft.wheels.inertia[number]) * speed
        most = float(np.broadcast_to(wheels.momentum_limit, wheels.count)[number])
        if abs(momentum) > most * (1.0 + LIMIT_TOLERANCE):
            raise InputError(
                f"{where}: found {momentum:g} N·m·s, expected at most the wheel's momentum limit, "
                f"{most:g} N·m·s"
            )
        found[number] = momentum
    return found


def _turned(attitude: "Vector | None", body: "Vector") -> "Vector | None":
    """A body direction in inertial axes."""
    from scipy.spatial.transform import Rotation

    if attitude is None:
        return None
    return Rotation.from_quat(attitude, scalar_first=True).apply(body)
