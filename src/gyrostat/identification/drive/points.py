"""Measured points of the friction curve of a drive."""

from collections.abc import Sequence

import numpy as np

from gyrostat.identification.drive.equation import Equation
from gyrostat.identification.drive.parts import Part
from gyrostat.identification.drive.weak_form import HOPS
from gyrostat.identification.result.fit import FrictionPoints

BINS = 12
"""Points of each sense of rotation, with as many windows in each."""
FEWEST = 4 * HOPS
"""Smallest number of windows of a point."""


def friction_points(
    equation: Equation, parts: Sequence[Part], values: dict[str, float]
) -> FrictionPoints | None:
    """Motor torque less that of the inertia in the windows, pooled by speed.

    Args:
        equation: Equation of motion.
        parts: Segments.
        values: Name -> held values and estimates, SI.

    Returns:
        The points, whose sigma allows for windows that overlap; None with too few windows.
    """
    columns = []
    begin = min(part.drive.time[0] for part in parts)
    length = max(part.drive.time[-1] for part in parts) - begin
    for part in parts:
        rows = part.rows(equation, part.drive.measured)
        torque = values["motor_constant"] * (rows.current + values.get("current_bias", 0.0))
        middle = 0.5 * (part.drive.time[1:] + part.drive.time[:-1])
        speed = part.windows.mean @ part.drive.measured.mean_speed
        when = (part.windows.mean @ (middle - begin)) / length
        friction = torque - values["inertia"] * rows.acceleration
        columns.append([speed[part.used], friction, when[part.used]])
    speed, torque, when = (np.concatenate(each) for each in zip(*columns, strict=True))
    points = []
    for sense in (-1.0, 1.0):
        order = np.flatnonzero(np.sign(speed) == sense)
        order = order[np.argsort(speed[order])]
        for group in np.array_split(order, min(BINS, max(len(order) // FEWEST, 1))):
            if len(group) >= FEWEST:
                error = np.std(torque[group], ddof=1) * np.sqrt(2.0 * HOPS / len(group))
                means = (float(np.mean(each[group])) for each in (speed, torque))
                points.append((*means, float(error), float(np.mean(when[group]))))
    return FrictionPoints(*map(np.array, zip(*points, strict=True))) if points else None
