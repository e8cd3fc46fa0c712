"""Temperature dependence of the friction, from records at different temperatures."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.types import Matrix
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction

DISTINCT = 2.0
"""Smallest range of the records' mean temperatures for which a trend is estimated, °C."""
SLOPES = {"viscous": "viscous_per_degC", "torque": "dry_per_degC"}
"""Dimension of friction parameters -> name of their common temperature coefficient."""


def temperature_offsets(records: Sequence[Record]) -> tuple[float, ...]:
    """Mean temperature of each record minus the mean of all records, °C.

    Args:
        records: Records of one wheel.

    Returns:
        One value for each record; empty if the temperatures are unknown or lie within `DISTINCT`.
    """
    means = [None if r.temperature is None else float(np.mean(r.temperature)) for r in records]
    temperatures = [t for t in means if t is not None]
    if len(temperatures) < max(len(records), 2) or np.ptp(temperatures) < DISTINCT:
        return ()
    return tuple(t - float(np.mean(temperatures)) for t in temperatures)


def slope_dimensions(model: type[Friction]) -> dict[str, str]:
    """Temperature coefficients of a friction model: name -> dimension.

    Args:
        model: Friction model.
    """
    dimensions = dict.fromkeys(model.dimensions().values())
    return {SLOPES[d]: f"{d}_per_temperature" for d in dimensions if d in SLOPES}


def at_temperature(model: type[Friction], names: Sequence[str], offset: float) -> Matrix:
    """Matrix that maps the parameters of a prediction to those at another temperature, (n, n).

    Args:
        model: Friction model.
        names: Names of the parameters; without temperature coefficients the map is the identity.
        offset: Temperature minus that of the parameters, °C.
    """
    change = np.eye(len(names))
    for name, dimension in model.dimensions().items():
        slope = SLOPES.get(dimension)
        if slope in names:
            change[names.index(name), names.index(slope)] = offset
    return change
