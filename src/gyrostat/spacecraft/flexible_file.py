"""Read flexible appendages and propellant of a spacecraft from its file.

[[flexible]]                      # one vibration mode
name = "wing"
frequency = "0.5 Hz"              # on a body at rest
damping = 0.005                   # ratio; optional, default 0
participation = [1.5, 0.2, 0.0]   # √kg·m, angular momentum about the centre of mass per modal rate
translation = [0.0, 0.3, 2.0]     # √kg, linear momentum per modal rate; optional, default none

[[hinged_panel]]                  # rigid panel on a hinge with a spring
name = "panel"
frequency = "0.2 Hz"
mass = "12 kg"
inertia = [1.2, 0.4, 1.6]         # kg·m², about its centre of mass: principal values or three rows
hinge = ["0.5 m", 0.0, 0.0]       # m, body axes
centre = ["1.5 m", 0.0, 0.0]      # m, of mass, body axes
axis = [0.0, 1.0, 0.0]            # hinge line, of any length

[[slosh]]                         # mass on a spring along a line
name = "tank"
frequency = "0.4 Hz"
damping = 0.02
mass = "20 kg"                    # the part that moves
position = [0.0, 0.0, "30 cm"]    # m, at rest, body axes
direction = [1.0, 0.0, 0.0]       # of any length
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import (
    direction,
    inertia_matrix,
    number,
    quantity,
    refuse_unknown,
    three,
)
from gyrostat.core.units import SI_UNIT
from gyrostat.spacecraft.flexible.appendages import APPENDAGES, appendage_modes
from gyrostat.spacecraft.flexible.modes import FlexibleModes
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.surfaces_file import named_tables

_INERTIA = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


@dataclass(frozen=True)
class Appendage:
    """Flexible appendage of a spacecraft file.

    Attributes:
        kind: Key of `gyrostat.spacecraft.flexible.appendages.APPENDAGES`.
        name: Name, unique among those of its kind.
        values: Values of its keys, such as "participation.x", SI; frequencies in Hz.
    """

    kind: str
    name: str
    values: Mapping[str, float]


def read_appendages(path: Path, table: dict[str, Any]) -> tuple[Appendage, ...]:
    """Read the appendages.

    Args:
        path: Path of the file, for error messages.
        table: Content of the file.

    Raises:
        InputError: A key is unknown, missing or has an impossible value.
    """
    appendages: list[Appendage] = []
    for kind, dimensions in APPENDAGES.items():
        for name, row in named_tables(path, kind, table.get(kind, [])).items():
            if "." in name:
                raise InputError(f"{path}: key {kind}.name: found {name!r}, expected no dot in it")
            prefix = f"{kind}[{name}]."
            refuse_unknown(path, prefix, row, ("name", "frequency", "damping", *dimensions))
            values = _common(path, prefix, row)
            for key, dimension in dimensions.items():
                if key != "translation" or key in row:
                    values |= _value(path, prefix, key, row.get(key), dimension)
            appendages.append(Appendage(kind, name, values))
    return tuple(appendages)


def modes_of(appendages: tuple[Appendage, ...], spacecraft: Spacecraft) -> FlexibleModes | None:
    """Modes of the appendages of a spacecraft; None if there are none.

    Args:
        appendages: Appendages of a spacecraft file.
        spacecraft: Spacecraft of the file.

    Raises:
        InputError: The mass of the spacecraft is needed and is not given, or the modes have more
            mass or inertia than the spacecraft.
    """
    if not appendages:
        return None
    for each in appendages:
        if spacecraft.mass is None and (each.kind != "flexible" or "translation.x" in each.values):
            raise InputError(
                f"{each.kind}[{each.name}]: found a spacecraft without mass, expected body.mass"
            )
    parts = [appendage_modes(each.kind, each.values, spacecraft) for each in appendages]
    modes = FlexibleModes.joined(*parts)
    modes.check()
    modes.check_inertia(spacecraft.inertia)
    return modes


def _common(path: Path, prefix: str, row: dict[str, Any]) -> dict[str, float]:
    frequency = quantity(
        path, f"{prefix}frequency", row.get("frequency"), "frequency", positive=True
    )
    damping = number(path, f"{prefix}damping", row.get("damping", 0.0), positive=False)
    if damping < 0.0:
        raise InputError(f"{path}: key {prefix}damping: found {damping:g}, expected 0 or more")
    return {"frequency": frequency, "damping": damping}


def _value(path: Path, prefix: str, key: str, value: Any, dimension: str) -> dict[str, float]:
    """Values of a key: of a mass, of an inertia or of a vector."""
    full_key = f"{prefix}{key}"
    if key == "mass":
        return {key: quantity(path, full_key, value, dimension, positive=True)}
    if key != "inertia":
        if dimension == "1":
            vector = direction(path, full_key, value)
        else:
            vector = three(path, full_key, value, dimension if dimension in SI_UNIT else None)
        return dict(zip((f"{key}.{end}" for end in "xyz"), vector.tolist(), strict=True))
    matrix = inertia_matrix(path, full_key, value)
    if np.any(matrix != matrix.T) or np.min(np.linalg.eigvalsh(matrix)) < 0.0:
        raise InputError(
            f"{path}: key {full_key}: found a matrix that is not symmetric and positive "
            "semidefinite, expected an inertia"
        )
    return {f"{key}.{end}": float(matrix[at]) for end, at in _INERTIA.items()}
