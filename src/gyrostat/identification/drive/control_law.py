"""Control law of a drive, as the files of `gyrostat.identification.drive.laws` define it."""

import abc
import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from gyrostat.core.arrays import Scalar
from gyrostat.core.classes_of import classes_of
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.toml_file import number, quantity, read_toml, refuse_unknown
from gyrostat.identification.drive import laws


class Command(NamedTuple):
    """Reference of a drive at a sample.

    Attributes:
        angle: Commanded angle, rad; its integral if the speed is commanded.
        speed: Commanded speed, rad/s; the difference of the angle if that is commanded.
        acceleration: Difference of the commanded speed, rad/s².
    """

    angle: Scalar
    speed: Scalar
    acceleration: Scalar


@dataclasses.dataclass(frozen=True)
class ControlLaw(abc.ABC):
    """Control law of a drive; its fields are the keys of `[loop]`, in SI units.

    Attributes:
        saturation: Largest current, A.
    """

    name: ClassVar[str]
    reference: ClassVar[str]
    """Column that the law follows: "reference" (an angle) or "setpoint" (a speed)."""

    saturation: float = float("inf")

    @abc.abstractmethod
    def demand(self, gains: Mapping[str, Scalar], command: Command, state: Any) -> Scalar:
        """Current without its limit, A.

        Args:
            gains: Field -> value.
            command: Reference.
            state: Angle, speed and integral of the control error, (3,), rad, rad/s.
        """

    @abc.abstractmethod
    def error(self, command: Command, state: Any) -> Scalar:
        """Control error that is integrated; see `demand`."""

    def step(self, gains: Mapping[str, Scalar], command: Command, state: Any, period: Scalar):
        """Current, A, and the integral of the control error after the period.

        The integral stops while the current is at its limit (conditional integration).
        """
        demand = self.demand(gains, command, state)
        current = jnp.clip(demand, -gains["saturation"], gains["saturation"])
        grown = state[2] + period * self.error(command, state)
        return current, jnp.where(current == demand, grown, state[2])

    def gains(self) -> dict[str, float]:
        """Field -> value, SI."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}


def control_laws() -> dict[str, type[ControlLaw]]:
    """Control laws by name."""
    return {law.name: law for law in classes_of(laws, ControlLaw)}


def read_control_law(path: Path) -> ControlLaw:
    """Read the control law of a drive from the table [loop] of a TOML file.

    Raises:
        InputError: The file has no such table, or a key or value is not one of a control law.
    """
    table = read_toml(path, "a file with a table [loop]").get("loop")
    if not isinstance(table, dict):
        raise InputError(f"{path}: found no table [loop], expected one with the control law")
    kinds = control_laws()
    law = kinds.get(str(table.get("law")))
    if law is None:
        raise InputError(
            f"{path}: key loop.law: found {table.get('law')!r}, expected one of {', '.join(kinds)}"
        )
    fields = [field.name for field in dataclasses.fields(law)]
    refuse_unknown(path, "loop.", table, ("law", *fields))
    values = {}
    for name in fields:
        if name not in table:
            continue
        key, value = f"loop.{name}", table[name]
        if name == "saturation":
            values[name] = quantity(path, key, value, "current", positive=True)
        else:
            values[name] = number(path, key, value, positive=False)
    result = law(**values)
    if not any(value for name, value in values.items() if name != "saturation"):
        raise InputError(f"{path}: loop: found no gain, expected one of {', '.join(fields)}")
    return result
