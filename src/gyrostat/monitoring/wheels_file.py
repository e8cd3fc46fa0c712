"""Read wheels.toml: what is known of the wheels before their telemetry is read.

[[wheel]]                          # one for each wheel
name = "wheel1"                    # columns wheel1_speed, wheel1_current, ...
axis = [1.0, 0.0, 0.0]             # body axes, of any length; optional with --spacecraft
inertia = "1.5e-3 kg·m²"           # of the rotor
motor_constant = "27 mN·m/A"
coulomb = "0.9 mN·m"               # nominal values
viscous = 5e-6                     # N·m·s/rad
offset = 0.0                       # N·m, optional
stribeck_speed = 0.5               # rad/s, optional
model = "x/model.toml"             # the values above from `gyrostat identify`, optional
idle_power = "1.2 W"               # of the drive at no current; needed where power is read
resistance = "1.1 Ohm"             # of winding and drive as the current sees it; likewise

[wheel.sigma]                      # standard deviations, optional
motor_constant = 1e-4
viscous = 1e-7
offset = 1e-5
idle_power = 0.02                  # W
resistance = 0.1                   # Ohm
power_gain = 0.01                  # of the relative error of the measured power

[telemetry]                        # optional
speed_resolution = "0.4 rpm"
power_resolution = "10 mW"
modes_left_out = [2]               # values of the mode column without usable telemetry
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import (
    direction,
    name_text,
    number,
    quantity,
    read_toml,
    refuse_unknown,
)
from gyrostat.core.types import Matrix
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels

_VALUES = {
    "inertia": "inertia",
    "motor_constant": "motor_constant",
    "coulomb": "torque",
    "viscous": "viscous",
    "offset": "torque",
    "stribeck_speed": "speed",
    "idle_power": "power",
    "resistance": "resistance",
}
_NEEDED = ("inertia", "motor_constant", "coulomb", "viscous")
_POSITIVE = ("inertia", "motor_constant", "coulomb", "stribeck_speed", "idle_power", "resistance")
_SIGMAS = ("motor_constant", "viscous", "offset", "idle_power", "resistance", "power_gain")
_RESOLUTIONS = {"speed_resolution": ("speed", "rad/s"), "power_resolution": ("power", "W")}
_WHEEL = ("name", "axis", "model", "sigma", *_VALUES)


def read_wheels(
    path: str | os.PathLike[str], spacecraft: str | os.PathLike[str] | None = None
) -> KnownWheels:
    """Read a file of wheels.

    Args:
        path: Path of wheels.toml.
        spacecraft: Spacecraft file with the axes of the wheels of these names, and the inertia of
            the body; optional.

    Raises:
        InputError: A file cannot be read, a key is unknown or missing, or a value is impossible.
    """
    path = Path(path)
    table = read_toml(path, "a file of wheels")
    refuse_unknown(path, "", table, ("wheel", "telemetry"))
    rows = table.get("wheel")
    if not isinstance(rows, list) or not rows or not all(isinstance(r, dict) for r in rows):
        raise InputError(f"{path}: key wheel: found no table [[wheel]], expected one per wheel")
    wheels = tuple(_wheel(path, f"wheel[{k}].", row) for k, row in enumerate(rows))
    names = [wheel.name for wheel in wheels]
    if len({*names}) < len(names):
        raise InputError(f"{path}: key wheel.name: found one name twice, expected different ones")
    axes, inertia = _axes(path, rows), None
    if spacecraft is not None:
        axes, inertia = _of_spacecraft(spacecraft, names)
    telemetry = table.get("telemetry", {})
    refuse_unknown(path, "telemetry.", telemetry, (*_RESOLUTIONS, "modes_left_out"))
    modes = telemetry.get("modes_left_out", [])
    if not isinstance(modes, list):
        raise InputError(f"{path}: key telemetry.modes_left_out: found {modes!r}, expected a list")
    resolutions = {}
    for name, (dimension, unit) in _RESOLUTIONS.items():
        key = f"telemetry.{name}"
        value = quantity(path, key, telemetry.get(name, 0.0), dimension, positive=False)
        if value < 0.0:
            raise InputError(f"{path}: key {key}: found {value:g} {unit}, expected zero or more")
        resolutions[name] = value
    return KnownWheels(
        wheels,
        axes,
        inertia,
        tuple(number(path, "telemetry.modes_left_out", m, positive=False) for m in modes),
        **resolutions,
    )


def _wheel(path: Path, prefix: str, row: Mapping[str, Any]) -> KnownWheel:
    refuse_unknown(path, prefix, row, _WHEEL)
    values: dict[str, float] = {}
    sigma: dict[str, float] = {}
    if "model" in row:
        values, sigma = _of_model(path, prefix, row["model"])
    for name, dimension in _VALUES.items():
        if name in row:
            positive = name in _POSITIVE
            values[name] = quantity(path, prefix + name, row[name], dimension, positive=positive)
            if name == "viscous" and values[name] < 0.0:
                found = f"{path}: key {prefix}viscous: found {row[name]!r}"
                raise InputError(f"{found}, expected a value of zero or more")
    missing = [name for name in _NEEDED if name not in values]
    if missing:
        raise InputError(f"{path}: key {prefix}{missing[0]}: found none, expected its value")
    stated = row.get("sigma", {})
    if not isinstance(stated, dict):
        raise InputError(f"{path}: key {prefix}sigma: found {stated!r}, expected a table")
    refuse_unknown(path, f"{prefix}sigma.", stated, _SIGMAS)
    for name, value in stated.items():
        key = f"{prefix}sigma.{name}"
        if name == "power_gain":
            sigma[name] = number(path, key, value, positive=True)
        else:
            sigma[name] = quantity(path, key, value, _VALUES[name], positive=True)
    if values["viscous"] == 0.0 and "viscous" not in sigma:
        raise InputError(
            f"{path}: key {prefix}viscous: found 0 without {prefix}sigma.viscous, expected its "
            "standard deviation: that of a value is 100 % otherwise"
        )
    return KnownWheel(
        name_text(path, f"{prefix}name", row.get("name")),
        sigma={name: sigma[name] for name in _SIGMAS if name in sigma},
        **values,
    )


def _of_model(path: Path, prefix: str, name: object) -> tuple[dict[str, float], dict[str, float]]:
    """Values and standard deviations of a model file."""
    from gyrostat.wheel.model_file import read_model

    if not isinstance(name, str):
        raise InputError(f"{path}: key {prefix}model: found {name!r}, expected the name of a file")
    model = read_model(path.parent / name)
    values = {key: float(value) for key, value in model.values.items() if key in _VALUES}
    return values, {key: float(value) for key, value in model.sigma.items()}


def _axes(path: Path, rows: list[Any]) -> Matrix | None:
    """Axes of the wheels, (3, wheels); None if no wheel has one."""
    present = [k for k, row in enumerate(rows) if "axis" in row]
    if not present:
        return None
    if len(present) < len(rows):
        missing = next(k for k in range(len(rows)) if k not in present)
        raise InputError(f"{path}: key wheel[{missing}].axis: found none, expected one, as others")
    axes = [direction(path, f"wheel[{k}].axis", row["axis"]) for k, row in enumerate(rows)]
    return np.column_stack([axis / np.linalg.norm(axis) for axis in axes])


def _of_spacecraft(path: str | os.PathLike[str], names: list[str]) -> tuple[Matrix, Matrix]:
    """Axes of the named wheels and the inertia of the body, from a spacecraft file."""
    from gyrostat.spacecraft.spacecraft_file import read_spacecraft

    content = read_spacecraft(path)
    places = [content.wheel_number(name, f"{path}: wheel.name") for name in names]
    wheels = content.spacecraft.wheels
    return np.asarray(wheels.axes)[:, places], np.asarray(content.spacecraft.inertia)
