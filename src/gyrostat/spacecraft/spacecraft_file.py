"""Read spacecraft files, spacecraft.toml.

[body]
name = "cube"                     # optional
inertia = [12.0, 12.0, 12.0]      # kg·m²: principal values, or three rows of the matrix
mass = "40 kg"                    # with the wheels; optional
centre_of_mass = ["1 mm", 0, 0]   # m, from the origin of the body axes; optional, default there

[[wheel]]                         # one for each wheel
name = "x"
axis = [1.0, 0.0, 0.0]            # of any length
inertia = "0.015 kg·m²"           # of the rotor; optional if the model or the sheet has it
torque_limit = 0.1                # N·m, optional
momentum_limit = "3 N·m·s"        # optional
model = "x/model.toml"            # friction, from `gyrostat identify`; optional
friction = { kind = "stribeck", ... }  # friction in this file instead; or python = "mine.py:MyLaw"
sheet = "bct-rwp015"              # data sheet for the values omitted above; optional

Surfaces ([box], [[panel]], [[facet]]) are optional; see `gyrostat.spacecraft.surfaces_file`.
So are flexible appendages and propellant ([[flexible]], [[hinged_panel]], [[slosh]]); see
`gyrostat.spacecraft.flexible_file`.
"""

import difflib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError, placed
from gyrostat.core.jax64 import jax
from gyrostat.core.pictured import Described
from gyrostat.core.toml_file import (
    described,
    direction,
    inertia_matrix,
    name_text,
    quantity,
    read_toml,
    refuse_unknown,
    three,
)
from gyrostat.core.units import si_unit
from gyrostat.spacecraft.flexible.appendages import APPENDAGES
from gyrostat.spacecraft.flexible.modes import FlexibleModes
from gyrostat.spacecraft.flexible_file import Appendage, modes_of, read_appendages
from gyrostat.spacecraft.spacecraft import Spacecraft, check_inertia, check_rotors
from gyrostat.spacecraft.surfaces_file import SURFACES, named_tables, read_surfaces
from gyrostat.wheel import WheelArray, WheelModel, read_model, read_wheel_sheet
from gyrostat.wheel.friction_laws import read_law

SAME = 1e-3
"""Largest relative difference between the inertia in this file and that of the model."""
_LIMITS = {"torque_limit": "torque", "momentum_limit": "momentum"}
_BODY = ("name", "inertia", "mass", "centre_of_mass")
_WHEEL = ("name", "axis", "inertia", *_LIMITS, "model", "friction", "sheet")


@dataclass(frozen=True)
class SpacecraftFile(Described):
    """Content of a spacecraft file.

    Attributes:
        name: Name of the spacecraft; empty if the file has none.
        wheel_names: Names of the wheels, in their order.
        spacecraft: Body with wheels.
        wheel_values: For each wheel, all values of its model and its data sheet, SI.
        appendages: Flexible appendages and propellant.
    """

    name: str
    wheel_names: tuple[str, ...]
    spacecraft: Spacecraft
    wheel_values: tuple[Mapping[str, float], ...]
    appendages: tuple[Appendage, ...] = ()

    @property
    def modes(self) -> FlexibleModes | None:
        """Modes of the appendages, for `Gyrostat`; None if there are none."""
        return modes_of(self.appendages, self.spacecraft)

    def wheel_number(self, name: str, where: str) -> int:
        """Index of a wheel, from 0.

        Args:
            name: Name of the wheel in the file.
            where: Start of an error message: the place that names the wheel.

        Raises:
            InputError: No wheel has this name.
        """
        if name in self.wheel_names:
            return self.wheel_names.index(name)
        near = difflib.get_close_matches(name, self.wheel_names, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise InputError(
            f"{where}: found no wheel {name!r}{hint}, expected one of {', '.join(self.wheel_names)}"
        )


def read_spacecraft(path: str | os.PathLike[str], *, force: bool = False) -> SpacecraftFile:
    """Read a spacecraft file.

    Args:
        path: Path of the file.
        force: Accept wheel models that are marked as impossible.

    Raises:
        InputError: The file cannot be read or is not TOML; a key is unknown, missing or has an
            impossible value; or a model file is invalid.
    """
    path = Path(path)
    table = read_toml(path, "a spacecraft file")
    refuse_unknown(path, "", table, ("body", "wheel", *SURFACES, *APPENDAGES))
    body = table.get("body")
    if not isinstance(body, dict):
        raise InputError(f"{path}: key body: found {described(body)}, expected a table [body]")
    refuse_unknown(path, "body.", body, _BODY)
    rows = named_tables(path, "wheel", table.get("wheel"))
    if not rows:
        raise InputError(f"{path}: key wheel: found 0 values, expected tables [[wheel]]")
    inertia = inertia_matrix(path, "body.inertia", body.get("inertia"))
    with placed(f"{path}: key body.inertia"):
        check_inertia(inertia)
    names = tuple(rows)
    wheels = [_wheel(path, f"wheel[{name}].", row, force) for name, row in rows.items()]
    array = WheelArray(
        # unlike jnp.asarray, device_put compiles nothing
        axes=jax.device_put(np.stack([wheel["axis"] for wheel in wheels], axis=1)),
        inertia=jax.device_put(np.array([wheel["inertia"] for wheel in wheels])),
        **{limit: np.array([wheel[limit] for wheel in wheels]) for limit in _LIMITS},
        **_friction(path, rows, [wheel["model"] for wheel in wheels]),
    )
    with placed(f"{path}: key body.inertia"):
        check_rotors(inertia, array.axes, array.inertia)
    surfaces = read_surfaces(path, table)
    spacecraft = Spacecraft(jax.device_put(inertia), array, **_mass(path, body), surfaces=surfaces)
    with placed(str(path)):
        spacecraft.check()
    content = SpacecraftFile(
        name_text(path, "body.name", body.get("name", "")),
        names,
        spacecraft,
        tuple(wheel["known"] for wheel in wheels),
        read_appendages(path, table),
    )
    with placed(str(path)):
        modes_of(content.appendages, spacecraft)
    return content


def _mass(path: Path, body: dict[str, Any]) -> dict[str, Any]:
    """Mass and centre of mass, as far as the file has them."""
    fields: dict[str, Any] = {}
    if "mass" in body:
        fields["mass"] = quantity(path, "body.mass", body["mass"], "mass", positive=True)
    if "centre_of_mass" in body:
        key = "body.centre_of_mass"
        fields["centre_of_mass"] = three(path, key, body["centre_of_mass"], "length")
    return fields


def _wheel(path: Path, prefix: str, row: dict[str, Any], force: bool) -> dict[str, Any]:
    """Read the table of a wheel, with its model and data sheet; SI units."""
    refuse_unknown(path, prefix, row, _WHEEL)
    axis = direction(path, f"{prefix}axis", row.get("axis"))
    sheet = _sheet(path, prefix, row)
    defaults = {} if sheet is None else sheet.values
    fields: dict[str, Any] = {"axis": axis / float(np.linalg.norm(axis)), "model": sheet}
    for name, dimension in _LIMITS.items():
        fields[name] = defaults.get(name, np.inf)
        if name in row:
            key = f"{prefix}{name}"
            fields[name] = quantity(path, key, row[name], dimension, positive=True)
    inertia = None
    if "inertia" in row:
        key = f"{prefix}inertia"
        inertia = quantity(path, key, row["inertia"], "inertia", positive=True)
    if "model" in row:
        fields["model"] = model = read_model(
            path.parent / _text(path, f"{prefix}model", row["model"]), force=force
        )
        rotor = model.values.get("inertia", inertia)
        if inertia is not None and rotor is not None and abs(rotor - inertia) > SAME * inertia:
            raise InputError(
                f"{path}: key {prefix}inertia: found {inertia:g} kg·m², expected the {rotor:g} "
                f"kg·m² of {row['model']}"
            )
        inertia = rotor if inertia is None else inertia
    if "friction" in row:
        fields["model"] = _inline_friction(path, prefix, row)
    inertia = defaults.get("inertia") if inertia is None else inertia
    if inertia is None:
        raise InputError(f"{path}: key {prefix}inertia: found none, expected it in kg·m²")
    model = fields["model"]
    return {**fields, "inertia": inertia, "known": {**defaults, **(model.values if model else {})}}


def _inline_friction(path: Path, prefix: str, row: dict[str, Any]) -> WheelModel:
    """Friction of a wheel in the spacecraft file: a kind of this package or a user's class."""
    key, table = f"{prefix}friction", row["friction"]
    if "model" in row:
        raise InputError(f"{path}: key {key}: found it beside model, expected one of the two")
    if not isinstance(table, dict) or ("kind" in table) == ("python" in table):
        raise InputError(
            f"{path}: key {key}: found {described(table)}, expected a table with kind or python, "
            "and the parameters"
        )
    law = read_law(path, f"{key}.{'kind' if 'kind' in table else 'python'}", table)
    law_keys = ("python", "data") if "python" in table else ("kind",)
    values = {n: v for n, v in table.items() if n not in law_keys}
    refuse_unknown(path, f"{key}.", values, law.dimensions())
    lacking = [name for name in law.dimensions() if name not in values]
    if lacking:
        unit = si_unit(law.dimensions()[lacking[0]])
        raise InputError(f"{path}: key {key}.{lacking[0]}: found none, expected it, in {unit}")
    numbers = {
        name: quantity(path, f"{key}.{name}", values[name], dimension, positive=False)
        for name, dimension in law.dimensions().items()
    }
    return WheelModel(law, numbers)


def _sheet(path: Path, prefix: str, row: dict[str, Any]) -> WheelModel | None:
    """Data sheet of a wheel as a model; None if the table names none."""
    if "sheet" not in row:
        return None
    name = _text(path, f"{prefix}sheet", row["sheet"])
    with placed(f"{path}: key {prefix}sheet"):
        sheet = read_wheel_sheet(path.parent / name if name.endswith(".toml") else name)
    return WheelModel(type(sheet.friction()), sheet.values)


def _friction(
    path: Path, rows: Mapping[str, Mapping[str, Any]], models: list[WheelModel | None]
) -> dict[str, Any]:
    """Friction of a wheel array: one friction model with parameters (wheels,)."""
    present = [model for model in models if model is not None]
    if not present:
        return {}
    names = tuple(rows)
    if len(present) < len(models):
        name = names[models.index(None)]
        raise InputError(
            f"{path}: key wheel[{name}].model: found none, expected one for every wheel or for "
            "none; a data sheet also gives one"
        )
    kind = present[0].friction
    for (name, row), model in zip(rows.items(), present, strict=True):
        key = f"wheel[{name}].{'friction' if 'friction' in row else 'model'}"
        if model.friction is not kind:
            raise InputError(
                f"{path}: key {key}: found {model.friction.name} friction, expected "
                f"{kind.name} as wheel {names[0]} has"
            )
        with placed(f"{path}: key {key}"):
            model.friction.of(**{n: model.values[n] for n in kind.dimensions()}).check()
    values: dict[str, Any] = {
        name: np.array([model.values[name] for model in present]) for name in kind.dimensions()
    }
    return {"friction": kind.of(**values)}


def _text(path: Path, key: str, value: object) -> str:
    if not isinstance(value, str):
        raise InputError(f"{path}: key {key}: found {value!r}, expected a text")
    return value
