"""Failed wheels as the verbs on failures take them: one grammar for both.

NAME or NAME=seized: the rotor stops at once. NAME=frozen: no motor torque, the wheel keeps its
momentum. NAME=rundown or NAME=rundown:TIME: no motor torque, the wheel runs down. NAME=VALUE:
frozen with this momentum, or at this speed.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, in_si, is_number, named

if TYPE_CHECKING:
    from gyrostat.failures import Loss, Telemetry
    from gyrostat.spacecraft import SpacecraftFile

SAME = 0.01
"""Largest relative difference between a given momentum of a failed wheel and its telemetry."""
EXPECTED = "seized, frozen, rundown, rundown:TIME, a momentum or a speed with its unit"


@dataclass(frozen=True)
class FailedWheel:
    """Failure of a wheel as the user gives it.

    Attributes:
        kind: "seized", "frozen" or "rundown".
        time_constant: Time constant of running down, s; None if it is not given.
        momentum: Momentum that a frozen wheel keeps, N·m·s; None if it is not given.
    """

    kind: Literal["seized", "frozen", "rundown"]
    time_constant: float | None = None
    momentum: float | None = None


def failures_of(failed: Named, file: "SpacecraftFile") -> dict[int, FailedWheel]:
    """Number of each failed wheel -> its failure.

    Raises:
        InputError: An unknown wheel or failure, or a momentum above the limit of the wheel.
    """
    import numpy as np

    from gyrostat.wheel.array import LIMIT_TOLERANCE

    wheels = file.spacecraft.wheels
    limits = np.broadcast_to(wheels.momentum_limit, wheels.count)
    inertia = np.broadcast_to(np.asarray(wheels.inertia), wheels.count)
    failures: dict[int, FailedWheel] = {}
    for name, value in named(failed, "--failed", bare=True).items():
        number, where = file.wheel_number(name, "--failed"), f"--failed {name}"
        failures[number] = failure = _failure(value, where, float(inertia[number]))
        limit = float(limits[number])
        if abs(failure.momentum or 0.0) > limit * (1.0 + LIMIT_TOLERANCE):
            raise InputError(
                f"{where}: found {failure.momentum:g} N·m·s, expected at most the wheel's momentum "
                f"limit, {limit:g} N·m·s"
            )
    return failures


def _failure(value: Quantity | None, where: str, inertia: float) -> FailedWheel:
    """Failure from its text; a number is a momentum, N·m·s."""
    if value is None or value == "seized":
        return FailedWheel("seized")
    if value in ("frozen", "rundown"):
        return FailedWheel(value)
    kind, colon, constant = str(value).partition(":")
    if kind == "rundown" and colon:
        return FailedWheel("rundown", in_si(constant, "time", where))
    return FailedWheel("frozen", momentum=_momentum(value, where, inertia))


def _momentum(value: Quantity, where: str, inertia: float) -> float:
    """Momentum, N·m·s, from a momentum or a speed with its unit."""
    for dimension, factor in (("momentum", 1.0), ("speed", inertia)):
        try:
            return factor * in_si(value, dimension, where)
        except InputError:
            continue
    raise InputError(f"{where}: found {value!r}, expected {EXPECTED}")


def momenta_of(
    failures: Mapping[int, FailedWheel], file: "SpacecraftFile", telemetry: "Telemetry | None"
) -> dict[int, float]:
    """Number of each failed wheel -> the momentum that it keeps, N·m·s.

    A given momentum that agrees with the telemetry within `SAME` stands for the measured one.

    Raises:
        InputError: The momentum of a frozen wheel is not known.
    """
    measured = None if telemetry is None else telemetry.wheel_momentum(file.spacecraft)
    differences = differing(failures, file, telemetry)
    momenta: dict[int, float] = {}
    for number, failure in failures.items():
        name = file.wheel_names[number]
        if failure.kind != "frozen":
            momenta[number] = 0.0
        elif measured is not None and number not in differences:
            momenta[number] = float(measured[number])
        elif failure.momentum is not None:
            momenta[number] = failure.momentum
        else:
            raise InputError(
                f"--failed {name}: found frozen without the wheel speeds, expected telemetry "
                f"instead of --momentum, or its momentum or speed: {name}=0.3 or {name}=180rpm"
            )
    return momenta


def in_words(
    failures: Mapping[int, FailedWheel], file: "SpacecraftFile", kept: Mapping[int, float]
) -> dict[str, str]:
    """Name of each failed wheel -> its failure in words.

    Args:
        failures: Number of each failed wheel -> its failure.
        file: Spacecraft.
        kept: Number of each failed wheel -> the momentum that it keeps, N·m·s.
    """
    descriptions = {"seized": "seized: stopped, without momentum", "rundown": "runs down to rest"}
    texts = {}
    for number, failure in failures.items():
        text = descriptions.get(failure.kind, f"keeps {kept[number]:.4g} N·m·s")
        if failure.time_constant is not None:
            text += f" with the time constant {failure.time_constant:g} s"
        texts[file.wheel_names[number]] = text
    return texts


def differing(
    failures: Mapping[int, FailedWheel], file: "SpacecraftFile", telemetry: "Telemetry | None"
) -> dict[int, float]:
    """Number of each frozen wheel whose given momentum is not that of telemetry -> the latter.

    Returns:
        Momenta from telemetry, N·m·s.
    """
    if telemetry is None:
        return {}
    measured = telemetry.wheel_momentum(file.spacecraft)
    return {
        number: float(measured[number])
        for number, failure in failures.items()
        if failure.momentum is not None
        and abs(failure.momentum - measured[number])
        > SAME * max(abs(failure.momentum), abs(float(measured[number])))
    }


def losses_of(
    failures: Mapping[int, FailedWheel],
    file: "SpacecraftFile",
    telemetry: "Telemetry",
    brake: Named,
) -> "dict[int, Loss]":
    """Number of each failed wheel -> its failure for the simulation, and what brakes it.

    Raises:
        InputError: A given momentum is not that of telemetry, or a brake of an unknown kind or on a
            wheel that works.
    """
    from gyrostat.failures import Loss

    for number, measured in differing(failures, file, telemetry).items():
        raise InputError(
            f"--failed {file.wheel_names[number]}: found {failures[number].momentum:g} N·m·s, "
            f"expected {measured:g} N·m·s as in the telemetry, where the simulation starts, or "
            "frozen"
        )
    losses: dict[int, Loss] = {}
    for number, failure in failures.items():
        constant = failure.time_constant
        losses[number] = Loss(failure.kind) if constant is None else Loss(failure.kind, constant)
    for name, value in named(brake, "--brake").items():
        number = file.wheel_number(name, "--brake")
        if number not in losses:
            raise InputError(f"--brake {name}: found a wheel that works, expected a failed one")
        losses[number] = replace(losses[number], **_brake(value, f"--brake {name}"))
    return losses


def _brake(value: str, where: str) -> dict[str, float]:
    """What slows a failed wheel down, as an attribute of its failure."""
    for name, dimension in (("brake_time", "time"), ("brake_torque", "torque")):
        try:
            amount = in_si(value, dimension, where)
        except InputError:
            continue
        if amount > 0.0 and not is_number(value):
            return {name: amount}
    raise InputError(
        f"{where}: found {value!r}, expected the time constant of the short-circuited motor "
        "('8 s') or the torque of the motor ('20 mN·m')"
    )
