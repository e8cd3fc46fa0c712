"""Data sheets of wheels: values with their sources, and acceptance limits.

A sheet is a TOML file with `name` and one table for each quantity. The table has the `value`, a
number in SI units or a text with a unit, and the `source` of the value or the reason for it:

name = "Maker, type"

[momentum_limit]
value = "15 mN·m·s"
source = "data sheet, 2019"
...

With `coulomb` and `viscous`, the wheel has viscous and Coulomb friction; with `static` and
`stribeck_speed` in addition, it has Stribeck friction. `torque_limit`, `motor_constant`,
`static_imbalance` and `dynamic_imbalance` are optional. An acceptance test needs only the
quantities to be judged, and has limits; see `gyrostat.wheel.sheet_limits`.
"""

import difflib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.toml_file import read_toml, refuse_unknown
from gyrostat.wheel.array import WheelArray
from gyrostat.wheel.friction import Friction, Stribeck, ViscousCoulomb
from gyrostat.wheel.sheet_limits import QUANTITIES, Limit, read_limit

FOLDER = Path(__file__).with_name("data_sheets")
SAME = 0.01
"""Largest relative difference between the inertia and momentum over speed."""
_NEEDED = ("momentum_limit", "speed_limit", "inertia", "coulomb", "viscous")
"""Quantities of a wheel that can be simulated."""


@dataclass(frozen=True)
class WheelSheet(Described):
    """Content of a wheel data sheet.

    Attributes:
        name: Maker and type.
        values: Quantity -> value in SI units, see the module. Imbalances are in kg·m and kg·m², the
            motor constant in N·m/A.
        sources: Quantity -> source of the value.
        limits: Quantities with their acceptance limits, in the order of the file.
    """

    name: str
    values: Mapping[str, float]
    sources: Mapping[str, str]
    limits: tuple[Limit, ...] = ()

    def friction(self) -> Friction:
        """Friction model of the bearing."""
        names = ("viscous", "coulomb", "static", "stribeck_speed")
        kind = Stribeck if "static" in self.values else ViscousCoulomb
        return kind(**{n: self.values[n] for n in names if n in self.values})

    def array(self, axes: Float[Array, "3 wheels"] | np.ndarray) -> WheelArray:
        """Wheel array with wheels of this kind.

        Args:
            axes: Spin axes in body axes, unit length, (3, wheels).
        """
        ones = np.ones(np.shape(axes)[1])
        friction = self.friction()
        return WheelArray(
            axes=axes,
            inertia=ones * self.values["inertia"],
            torque_limit=ones * self.values.get("torque_limit", np.inf),
            momentum_limit=ones * self.values["momentum_limit"],
            friction=type(friction)(**{n: ones * v for n, v in friction.parameters().items()}),
        )


def wheel_sheets() -> tuple[str, ...]:
    """Names of the data sheets in the package, for `read_wheel_sheet`."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def read_wheel_sheet(
    name: str | os.PathLike[str], *, partial: bool = False, other: tuple[str, ...] = ()
) -> WheelSheet:
    """Read a data sheet.

    Args:
        name: Name of a sheet of the package, or path of a file whose name ends in .toml.
        partial: Whether quantities that a simulated wheel needs may be missing, as in a sheet for
            an acceptance test.
        other: Further tables of the file, which are not read here.

    Raises:
        InputError: The sheet does not exist or cannot be read; a key is unknown or missing; a value
            is not possible for a wheel; or limits contradict each other.
    """
    path = Path(name)
    if path.suffix != ".toml":
        if str(name) not in wheel_sheets():
            near = difflib.get_close_matches(str(name), wheel_sheets(), n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise InputError(
                f"wheel data sheet: found {str(name)!r}{hint}, expected one of "
                f"{', '.join(wheel_sheets())}, or a .toml file"
            )
        path = FOLDER / f"{name}.toml"
    table = read_toml(path, "a data sheet of a wheel")
    refuse_unknown(path, "", table, ("name", *QUANTITIES, *other))
    table = {key: entry for key, entry in table.items() if key not in other}
    title = table.pop("name", None)
    if not isinstance(title, str):
        raise InputError(f"{path}: key name: found {title!r}, expected a text")
    limits = [limit for key, entry in table.items() for limit in _limits(path, key, entry)]
    stated = [limit for limit in limits if limit.value is not None and not limit.conditions]
    values = {limit.quantity: float(limit.value) for limit in stated if limit.value is not None}
    if partial and not limits:
        raise InputError(f"{path}: found no quantity, expected one of {', '.join(QUANTITIES)}")
    if not partial:
        _check_complete(path, values)
    sources = {limit.quantity: limit.source for limit in stated}
    return WheelSheet(title, values, sources, tuple(limits))


def _check_complete(path: Path, values: Mapping[str, float]) -> None:
    """Refuse a sheet that does not describe a wheel that can be simulated."""
    for key in _NEEDED:
        if key not in values:
            raise InputError(f"{path}: key {key}: found none, expected a table with its value")
    if ("static" in values) != ("stribeck_speed" in values):
        raise InputError(f"{path}: keys static, stribeck_speed: found one, expected both or none")
    implied = values["momentum_limit"] / values["speed_limit"]
    if abs(values["inertia"] - implied) > SAME * implied:
        raise InputError(
            f"{path}: key inertia: found {values['inertia']:g} kg·m², expected {implied:g} kg·m², "
            "momentum over speed"
        )


def _limits(path: Path, key: str, entry: Any) -> list[Limit]:
    """Limits in a table [key], or in several tables [[key]] with different conditions."""
    if not isinstance(entry, list):
        return [read_limit(path, key, key, entry)]
    if not QUANTITIES[key].conditions:
        raise InputError(f"{path}: key {key}: found several tables [[{key}]], expected one [{key}]")
    return [read_limit(path, f"{key}[{k}]", key, each) for k, each in enumerate(entry)]
