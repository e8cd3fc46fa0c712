"""Verb `recover`: fly a spacecraft to a feasible attitude after wheel failures."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyrostat.cli.arguments import command_line, say
from gyrostat.cli.feasibility import attitude, numbers
from gyrostat.cli.options import Force, Json, Out
from gyrostat.core.errors import InputError

if TYPE_CHECKING:
    from gyrostat.core.types import Vector
    from gyrostat.failures import Loss
    from gyrostat.spacecraft import SpacecraftFile


def recover(
    spacecraft: Annotated[Path, typer.Argument(help="spacecraft.toml: body and wheels.")],
    failed: Annotated[
        list[str],
        typer.Option(
            help="A wheel that fails: NAME=seized, NAME=frozen (no torque, keeps its momentum) or "
            "NAME=rundown:60s (no torque, runs down)."
        ),
    ],
    wheels: Annotated[
        str, typer.Option(help="Momentum of every wheel then, N·m·s, or speed with a unit: A,B,...")
    ],
    out: Out,
    attitude_now: Annotated[
        str | None, typer.Option("--attitude", help="Then: quaternion Q0,Q1,Q2,Q3, scalar first.")
    ] = None,
    attitude_euler: Annotated[
        str | None, typer.Option(help="Then: 3-1-3 angles PHI,THETA,PSI, rad or with units.")
    ] = None,
    rate: Annotated[str, typer.Option(help="Of the body then: WX,WY,WZ, rad/s.")] = "0,0,0",
    target: Annotated[
        str | None, typer.Option(help="Attitude wanted: quaternion, scalar first.")
    ] = None,
    euler: Annotated[
        str | None, typer.Option(help="Attitude wanted: 3-1-3 angles, rad or with units.")
    ] = None,
    duration: Annotated[str, typer.Option(help="Of the flight, s or with a unit.")] = "600",
    period: Annotated[str, typer.Option(help="Control period, s or with a unit.")] = "0.5",
    force: Force = False,
    json_output: Json = False,
) -> None:
    """Fly to the nearest attitude that can be held: recover.json, run.nc and report.html."""
    import numpy as np

    from gyrostat.core.jax64 import jnp
    from gyrostat.core.outputs import check_outputs
    from gyrostat.core.units import parse_quantity
    from gyrostat.failures import recover as fly
    from gyrostat.reports.recovery import FILES, write_recovery
    from gyrostat.spacecraft import Gyrostat, read_spacecraft

    check_outputs(out, FILES, by="recover", force=force)
    file = read_spacecraft(spacecraft)
    wanted = attitude("what to hold", {"--target": target, "--euler": euler})
    losses = _losses(failed, file)
    now = attitude(
        "attitude at the failure",
        {"--attitude": attitude_now, "--attitude-euler": attitude_euler},
    )
    start = Gyrostat(file.spacecraft).start(
        attitude=now, rate=numbers(rate, 3, "speed", "--rate"), wheel_speed=_speeds(wheels, file)
    )
    if not all(np.all(np.isfinite(part)) for part in start if part is not None):
        raise InputError("--attitude, --rate, --wheels: found no finite state, expected numbers")
    say(f"flying {file.name or spacecraft} from the failure of {', '.join(failed)}")
    found = fly(
        file.spacecraft,
        start,
        losses,
        target=jnp.asarray(wanted),
        duration=parse_quantity(duration, "time", "--duration"),
        control_period=parse_quantity(period, "time", "--period"),
    )
    text = write_recovery(file, found, losses, out, command=command_line(), say=say, force=force)
    if json_output:
        print(text)
    if found.settle is None:
        raise typer.Exit(1)


def _losses(items: list[str], file: "SpacecraftFile") -> "dict[int, Loss]":
    """Number of each failed wheel -> how it failed."""
    from gyrostat.core.units import parse_quantity
    from gyrostat.failures import Loss

    found: dict[int, Loss] = {}
    for item in (part.strip() for entry in items for part in entry.split(",")):
        name, _, value = (part.strip() for part in item.partition("="))
        number = file.wheel_number(name, "--failed")
        if number in found:
            raise InputError(f"--failed: found {name} twice, expected it once")
        kind, _, constant = value.partition(":")
        if kind == "rundown" and constant:
            found[number] = Loss(kind, parse_quantity(constant, "time", f"--failed {name}"))
        elif kind in ("seized", "frozen", "rundown") and not constant:
            found[number] = Loss(kind)  # pyright: ignore[reportArgumentType]
        else:
            raise InputError(
                f"--failed {name}: found {value!r}, expected seized, frozen or rundown:TIME"
            )
    return found


def _speeds(text: str, file: "SpacecraftFile") -> "Vector":
    """Wheel speeds relative to the body, rad/s, from momenta or speeds."""
    import numpy as np

    count = len(file.wheel_names)
    try:
        momentum = numbers(text, count, "momentum", "--wheels")
    except InputError as error:
        try:
            return numbers(text, count, "speed", "--wheels")
        except InputError:
            raise error from None
    inertia = np.broadcast_to(np.asarray(file.spacecraft.wheels.inertia), (count,))
    return momentum / inertia
