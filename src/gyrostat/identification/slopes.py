"""Change of the friction with the temperature of several records, as part of one model."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.types import Matrix
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction

DISTINCT = 2.0
"""°C that the mean temperatures of records must span before a trend is worth asking for."""
SLOPES = {"viscous": "viscous_per_degC", "torque": "dry_per_degC"}
"""Dimension of friction parameters -> name of their common change with temperature."""


def temperature_offsets(records: Sequence[Record]) -> tuple[float, ...]:
    """Mean temperature of each record less that of all, °C.

    Args:
        records: Of one wheel.

    Returns:
        One value a record; empty where the temperatures are not known or lie within `DISTINCT`.
    """
    means = [None if r.temperature is None else float(np.mean(r.temperature)) for r in records]
    known = [t for t in means if t is not None]
    if len(known) < max(len(records), 2) or np.ptp(known) < DISTINCT:
        return ()
    return tuple(t - float(np.mean(known)) for t in known)


def slope_dimensions(model: type[Friction]) -> dict[str, str]:
    """Names of the changes with temperature that a friction model has -> dimension.

    Args:
        model: friction model.
    """
    own = dict.fromkeys(model.dimensions().values())
    return {SLOPES[d]: f"{d}_per_temperature" for d in own if d in SLOPES}


def at_temperature(model: type[Friction], names: Sequence[str], offset: float) -> Matrix:
    """Map of all parameters of a prediction to those at another temperature, (n, n).

    Args:
        model: friction model.
        names: of the parameters; without changes with temperature the map changes nothing.
        offset: temperature less that of the parameters, °C.
    """
    change = np.eye(len(names))
    for name, dimension in model.dimensions().items():
        slope = SLOPES.get(dimension)
        if slope in names:
            change[names.index(name), names.index(slope)] = offset
    return change
