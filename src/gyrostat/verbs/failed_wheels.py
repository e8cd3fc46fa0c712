"""Failed wheels and wheel speeds as the verbs on failures take them."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, in_si, named, numbers

if TYPE_CHECKING:
    from gyrostat.core.types import Vector
    from gyrostat.failures import Loss
    from gyrostat.spacecraft import SpacecraftFile


def momenta_of(failed: Named, file: "SpacecraftFile") -> dict[int, float]:
    """Number of each failed wheel -> its momentum, N·m·s."""
    import numpy as np

    from gyrostat.wheel.array import LIMIT_TOLERANCE

    wheels = file.spacecraft.wheels
    limits = np.broadcast_to(wheels.momentum_limit, wheels.count)
    inertia = np.broadcast_to(np.asarray(wheels.inertia), wheels.count)
    found: dict[int, float] = {}
    for name, value in named(failed, "--failed", bare=True).items():
        number, where = file.wheel_number(name, "--failed"), f"--failed {name}"
        momentum = 0.0
        if value is not None and value != "seized":
            momentum = _momentum(value, where, float(inertia[number]))
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


def losses_of(
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


def speeds_of(values: str | Iterable[Quantity], file: "SpacecraftFile") -> "Vector":
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
