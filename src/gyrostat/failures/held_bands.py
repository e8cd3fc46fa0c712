"""Feasible directions of a boresight for each set of failed wheels, and the nearest one.

The directions are bands of the angle to the total momentum. They depend on its magnitude and on the
failed wheels, neither on its direction nor on the target: a page that has those of each set needs
only `nearest_on_bands`, which is compiled for it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.feasibility import reason_of
from gyrostat.failures.nearest_attitude import least_loaded, nearest_extremes, pointed
from gyrostat.failures.query import Case
from gyrostat.failures.sky_map import EDGE, SkyMap, angles, sky_map
from gyrostat.spacecraft import Spacecraft

MOST_BANDS = 8
"""Largest number of bands of a set."""
UNUSED = 1e3
"""Angle of the edges of bands that a set does not have, rad: farther than any other one."""


@dataclass(frozen=True)
class HeldBands:
    """Feasible directions of a boresight with some failed wheels.

    Attributes:
        failed: Indices of the failed wheels.
        sky: Sky map of the boresight.
        points: Total momentum in body axes at the edges of its bands, with the largest margin
            there, (K, 2, 3), N·m·s.
        reason: Reason why no attitude is feasible; None if some attitude is.
    """

    failed: tuple[int, ...]
    sky: SkyMap
    points: np.ndarray
    reason: str | None


def held_bands(
    spacecraft: Spacecraft, momentum: Vector, kept: Mapping[int, float], body: Vector
) -> list[HeldBands]:
    """Feasible directions of a boresight for each set of failed wheels.

    Args:
        spacecraft: Spacecraft.
        momentum: Total momentum, (3,), inertial axes, N·m·s; not negligible.
        kept: Index of a wheel -> momentum that it keeps if it fails, N·m·s; 0 for all others.
        body: Boresight in body axes, unit vector (3,).
    """
    every = range(spacecraft.wheels.count)
    sets = [failed for n in range(len(every) + 1) for failed in combinations(every, n)]
    return [
        _bands(spacecraft, momentum, {k: kept.get(k, 0.0) for k in each}, body) for each in sets
    ]


def _bands(
    spacecraft: Spacecraft, momentum: Vector, failed: Mapping[int, float], body: Vector
) -> HeldBands:
    case = Case.of(spacecraft, momentum, failed)
    sky = sky_map(case.held, case.momentum, case.radius, body)
    points = [least_loaded(case, nearest_extremes(case, body, edge)) for edge in sky.bands.flat]
    reason = None if points else reason_of(case)
    return HeldBands((*failed,), sky, np.array(points).reshape(-1, 2, 3), reason)


def padded(held: HeldBands) -> tuple[Matrix, np.ndarray]:
    """Edges of the bands, (MOST_BANDS, 2), rad, and momenta there, (MOST_BANDS, 2, 3), N·m·s.

    Those beyond the bands of the set are `UNUSED`.
    """
    count = MOST_BANDS - len(held.sky.bands)
    edges = np.pad(held.sky.bands, ((0, count), (0, 0)), constant_values=UNUSED)
    return edges, np.pad(held.points, ((0, count), (0, 0), (0, 0)), constant_values=1.0)


def nearest_on_bands(
    body: Vector, momentum: Vector, wanted: Vector, edges: Matrix, points: np.ndarray
) -> tuple[Vector, Vector, Vector, Vector]:
    """Feasible direction that is nearest to a wanted one, by functions without a branch.

    Args:
        body: Boresight in body axes, unit vector (3,).
        momentum: Total momentum, inertial axes, (3,), N·m·s.
        wanted: Wanted direction, inertial axes, unit vector (3,).
        edges: See `padded`.
        points: See `padded`.

    Returns:
        Whether the wanted direction is feasible, 1 or 0; angle to the nearest feasible one, rad;
        this direction, inertial axes, (3,); attitude there, (4,), if it is not the wanted one.
    """
    polar = angles(wanted, momentum / np.linalg.norm(momentum))
    outside = np.maximum(np.maximum(edges[:, 0] - polar, polar - edges[:, 1]), 0.0)
    away = np.min(outside)
    distance = np.abs(np.reshape(edges, (-1,)) - polar)
    chosen = 1.0 * (np.arange(2 * MOST_BANDS) == np.argmin(distance))
    angle = np.where(away <= EDGE, polar, chosen @ np.reshape(edges, (-1,)))
    point = chosen @ np.reshape(points, (-1, 3))
    direction, attitude = pointed(body, point, wanted, momentum, angle)
    return 1.0 * (away <= EDGE), away, direction, attitude
