"""Data sheets of commercial wheels: published values with their sources.

A sheet is a TOML file with `name` and one table for each quantity. The table has the `value`, a
number in SI units or a text with a unit, and the `source` of the value or the reason for it:

name = "Maker, type"

[momentum_limit]
value = "15 mN·m·s"
source = "data sheet, 2019"
...

With `coulomb` and `viscous`, the wheel has viscous and Coulomb friction; with `static` and
`stribeck_speed` in addition, it has Stribeck friction. `torque_limit`, `motor_constant`,
`static_imbalance` and `dynamic_imbalance` are optional.
"""

import difflib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import number, quantity, read_toml, refuse_unknown
from gyrostat.wheel.array import WheelArray
from gyrostat.wheel.friction import Friction, Stribeck, ViscousCoulomb

FOLDER = Path(__file__).with_name("data_sheets")
SAME = 0.01
"""Largest relative difference between the inertia and momentum over speed."""
_NEEDED = {
    "momentum_limit": "momentum",
    "speed_limit": "speed",
    "inertia": "inertia",
    "coulomb": "torque",
    "viscous": "viscous",
}
_OPTIONAL = {
    "torque_limit": "torque",
    "static": "torque",
    "stribeck_speed": "speed",
    "motor_constant": None,
    "static_imbalance": None,
    "dynamic_imbalance": None,
}
_MAY_BE_ZERO = ("coulomb", "viscous", "static", "static_imbalance", "dynamic_imbalance")


@dataclass(frozen=True)
class WheelSheet:
    """Content of a wheel data sheet.

    Attributes:
        name: Maker and type.
        values: Quantity -> value in SI units, see the module. Imbalances are in kg·m and kg·m², the
            motor constant in N·m/A.
        sources: Quantity -> source of the value.
    """

    name: str
    values: Mapping[str, float]
    sources: Mapping[str, str]

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
        each = np.ones(np.shape(axes)[1])
        friction = self.friction()
        return WheelArray(
            axes=axes,
            inertia=each * self.values["inertia"],
            torque_limit=each * self.values.get("torque_limit", np.inf),
            momentum_limit=each * self.values["momentum_limit"],
            friction=type(friction)(**{n: each * v for n, v in friction.parameters().items()}),
        )


def wheel_sheets() -> tuple[str, ...]:
    """Names of the data sheets in the package, for `read_wheel_sheet`."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def read_wheel_sheet(name: str | os.PathLike[str]) -> WheelSheet:
    """Read a data sheet.

    Args:
        name: Name of a sheet of the package, or path of a file whose name ends in .toml.

    Raises:
        InputError: The sheet does not exist or cannot be read; a key is unknown or missing; or a
            value is not possible for a wheel.
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
    refuse_unknown(path, "", table, ("name", *_NEEDED, *_OPTIONAL))
    title = table.pop("name", None)
    if not isinstance(title, str):
        raise InputError(f"{path}: key name: found {title!r}, expected a text")
    for key in _NEEDED:
        if key not in table:
            raise InputError(f"{path}: key {key}: found none, expected a table with its value")
    values, sources = {}, {}
    for key, entry in table.items():
        values[key], sources[key] = _entry(path, key, entry)
    if ("static" in values) != ("stribeck_speed" in values):
        raise InputError(f"{path}: keys static, stribeck_speed: found one, expected both or none")
    implied = values["momentum_limit"] / values["speed_limit"]
    if abs(values["inertia"] - implied) > SAME * implied:
        raise InputError(
            f"{path}: key inertia: found {values['inertia']:g} kg·m², expected {implied:g} kg·m², "
            "momentum over speed"
        )
    return WheelSheet(title, values, sources)


def _entry(path: Path, key: str, entry: object) -> tuple[float, str]:
    """Value and source of a quantity."""
    if not isinstance(entry, dict):
        raise InputError(f"{path}: key {key}: found {entry!r}, expected a table [{key}]")
    refuse_unknown(path, f"{key}.", entry, ("value", "source"))
    source = entry.get("source")
    if not isinstance(source, str) or not source:
        raise InputError(f"{path}: key {key}.source: found {source!r}, expected the source as text")
    dimension = {**_NEEDED, **_OPTIONAL}[key]
    where, positive = f"{key}.value", key not in _MAY_BE_ZERO
    if dimension is None:
        value = number(path, where, entry.get("value"), positive=positive)
    else:
        value = quantity(path, where, entry.get("value"), dimension, positive=positive)
    if value < 0.0:
        raise InputError(f"{path}: key {where}: found {value:g}, expected 0 or more")
    return value, source
