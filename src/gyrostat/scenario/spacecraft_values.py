"""Numbers of a spacecraft file as values of a scenario."""

import numpy as np

from gyrostat.scenario.scenario import AXES, INERTIA
from gyrostat.scenario.schema import CENTRE_OF_MASS
from gyrostat.spacecraft import SpacecraftFile


def spacecraft_values(file: SpacecraftFile) -> dict[str, float]:
    """Numbers of a spacecraft file: full keys of a scenario -> values, SI."""
    wheels, inertia = file.spacecraft.wheels, np.asarray(file.spacecraft.inertia)
    values = {
        f"body.inertia.{end}": float(inertia[AXES.index(end[0]), AXES.index(end[1])])
        for end in INERTIA
    }
    craft = file.spacecraft
    if craft.mass is not None:
        values["body.mass"] = float(craft.mass)
    if craft.centre_of_mass is not None:
        centre = np.asarray(craft.centre_of_mass, dtype=float).tolist()
        values |= dict(zip(CENTRE_OF_MASS.ends("body.centre_of_mass"), centre, strict=True))
    numbers = {
        "inertia": wheels.inertia,
        "torque_limit": wheels.torque_limit,
        "momentum_limit": wheels.momentum_limit,
        **wheels.friction.parameters(),
    }
    for name, entry in numbers.items():
        per_wheel = np.broadcast_to(np.asarray(entry, dtype=float), (wheels.count,))
        values |= {f"wheel.{w}.{name}": float(per_wheel[k]) for k, w in enumerate(file.wheel_names)}
    for part in file.appendages:
        values |= {f"{part.kind}.{part.name}.{name}": v for name, v in part.values.items()}
    return values


def surface_rows(craft: SpacecraftFile) -> tuple[tuple[float, ...], ...]:
    """Facets as rows; see `Scenario.surfaces`."""
    surfaces = craft.spacecraft.surfaces
    return () if surfaces is None else tuple(map(tuple, surfaces.rows().tolist()))
