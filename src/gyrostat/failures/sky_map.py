"""Map of inertial directions that a body axis can point at permanently."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.momentum_envelope import TOLERANCE, MomentumSet

EDGE = 1e-7
"""Tolerance for a plane that touches a sphere, rad: square root of the rounding error."""


@dataclass(frozen=True)
class SkyMap(Described):
    """Inertial directions at which a body axis can be held, with free roll angle.

    A feasible attitude stays feasible when it is rotated about the total momentum. The map
    therefore consists of bands around the direction of the momentum.

    Attributes:
        boresight: Unit vector in body axes, (3,).
        momentum_direction: Inertial unit vector, (3,); zero without momentum.
        bands: Smallest and largest angle of each band from the momentum direction, (K, 2), rad;
            equal for a single circle.
        fraction: Feasible fraction of the sphere.
    """

    boresight: Vector
    momentum_direction: Vector
    bands: Matrix
    fraction: float

    def holdable(self, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether inertial directions (..., 3), of any length, are feasible."""
        if not np.any(self.momentum_direction):
            return np.full(directions.shape[:-1], len(self.bands) > 0)
        angle = angles(directions, self.momentum_direction)[..., None]
        in_band = (angle >= self.bands[:, 0] - EDGE) & (angle <= self.bands[:, 1] + EDGE)
        return np.any(in_band, axis=-1)

    def grid(self, rows: int = 180) -> tuple[Vector, Vector, NDArray[np.bool_]]:
        """Sample the map over inertial longitude (about z, from x) and latitude.

        Args:
            rows: Number of cells from pole to pole; twice as many around.

        Returns:
            Longitude (2 rows,) in (-pi, pi) and latitude (rows,) of the cell centres, rad, and
            whether each cell is feasible, (rows, 2 rows).
        """
        longitude = (np.arange(2 * rows) + 0.5) * np.pi / rows - np.pi
        latitude = (np.arange(rows) + 0.5) * np.pi / rows - 0.5 * np.pi
        return longitude, latitude, self.holdable(directions_at(longitude, latitude[:, None]))


def directions_at(
    longitude: NDArray[np.float64], latitude: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unit vectors (..., 3) at longitude and latitude, rad; the arguments are broadcast."""
    longitude, latitude = np.broadcast_arrays(longitude, latitude)
    across = np.cos(latitude)
    return np.stack(
        [across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)], axis=-1
    )


def angles(directions: NDArray[np.float64], fixed: Vector) -> NDArray[np.float64]:
    """Angles (...) between directions (..., 3) and a fixed one, rad, accurate for small angles."""
    across = np.linalg.norm(np.cross(directions, fixed), axis=-1)
    return np.arctan2(across, directions @ fixed)


def sky_map(held: MomentumSet, momentum: Vector, radius: float, boresight: Vector) -> SkyMap:
    """Sky map of a boresight.

    Args:
        held: Momentum envelope of the wheels.
        momentum: Total momentum, (3,), inertial axes, N·m·s.
        radius: Magnitude of the total momentum, N·m·s; 0 if it counts as zero.
        boresight: Unit vector in body axes, (3,).
    """
    if radius == 0.0:
        is_holdable = bool(held.holds(np.zeros(3), TOLERANCE * float(np.linalg.norm(held.frozen))))
        everywhere = np.array([[0.0, np.pi]] if is_holdable else []).reshape(-1, 2)
        return SkyMap(boresight, np.zeros(3), everywhere, float(is_holdable))
    # the angle to the momentum is the same in body axes; its extremes are among these points
    extreme = np.unique(angles(held.on_sphere(radius, boresight), boresight))
    bands: list[list[float]] = []
    for angle in extreme:
        if bands:
            middle = 0.5 * (bands[-1][1] + angle)
            if angle - bands[-1][1] <= EDGE or len(at_angle(held, radius, boresight, middle)):
                bands[-1][1] = angle
                continue
        bands.append([angle, angle])
    edges = np.array(bands).reshape(-1, 2)
    fraction = float(np.sum(np.cos(edges[:, 0]) - np.cos(edges[:, 1]))) / 2.0
    return SkyMap(boresight, momentum / radius, edges, fraction)


def at_angle(held: MomentumSet, radius: float, boresight: Vector, angle: float) -> Matrix:
    """Momenta (M, 3) in body axes, at an angle to the boresight, that the wheels can hold.

    Only extreme points at the limits of the envelope are returned, at least one if any exist.
    """
    objective = np.eye(3)[int(np.argmin(np.abs(boresight)))]
    return held.on_sphere(radius, objective, boresight[None], np.array([radius * np.cos(angle)]))
