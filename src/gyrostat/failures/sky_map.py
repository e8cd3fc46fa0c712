"""Map of inertial directions that a body axis can point at permanently."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.momentum_envelope import TOLERANCE, MomentumSet

EDGE = 1e-7
"""rad: a plane that touches a sphere is known to the square root of rounding."""


@dataclass(frozen=True)
class SkyMap:
    """Inertial directions that an axis of the body can hold, whatever the roll about it.

    A holdable attitude stays holdable when it is turned about the total momentum. So the map
    consists of bands about the direction of the momentum.

    Attributes:
        boresight: (3,) unit direction in the body.
        momentum_direction: (3,) unit, inertial; zero where there is no momentum.
        bands: (K, 2) least and largest angle of each band from the momentum direction, rad; equal
            where single circles are holdable.
        fraction: holdable share of the sphere.
    """

    boresight: Vector
    momentum_direction: Vector
    bands: Matrix
    fraction: float

    def holdable(self, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether inertial directions (..., 3), of any length, are holdable."""
        if not np.any(self.momentum_direction):
            return np.full(directions.shape[:-1], len(self.bands) > 0)
        angle = angles(directions, self.momentum_direction)[..., None]
        inside = (angle >= self.bands[:, 0] - EDGE) & (angle <= self.bands[:, 1] + EDGE)
        return np.any(inside, axis=-1)

    def grid(self, rows: int = 180) -> tuple[Vector, Vector, NDArray[np.bool_]]:
        """The map over inertial longitude (about z, from x) and latitude.

        Args:
            rows: cells from pole to pole; twice as many around.

        Returns:
            Longitude (2 rows,) in (-pi, pi) and latitude (rows,) of the middles of the cells, rad,
            and whether each (rows, 2 rows) is holdable.
        """
        longitude = (np.arange(2 * rows) + 0.5) * np.pi / rows - np.pi
        latitude = (np.arange(rows) + 0.5) * np.pi / rows - 0.5 * np.pi
        return longitude, latitude, self.holdable(directions_at(longitude, latitude[:, None]))


def directions_at(
    longitude: NDArray[np.float64], latitude: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unit vectors (..., 3) at longitude and latitude, rad, which are broadcast."""
    longitude, latitude = np.broadcast_arrays(longitude, latitude)
    across = np.cos(latitude)
    return np.stack(
        [across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)], axis=-1
    )


def angles(directions: NDArray[np.float64], fixed: Vector) -> NDArray[np.float64]:
    """Angles (...) between directions (..., 3) and a fixed one, rad, exact for small ones too."""
    across = np.linalg.norm(np.cross(directions, fixed), axis=-1)
    return np.arctan2(across, directions @ fixed)


def sky_map(held: MomentumSet, momentum: Vector, radius: float, boresight: Vector) -> SkyMap:
    """The map of a boresight.

    Args:
        held: what the wheels hold.
        momentum: (3,) total, inertial axes, N·m·s.
        radius: its magnitude; 0 where it is to count as none.
        boresight: (3,) unit direction in the body.
    """
    if radius == 0.0:
        whole = bool(held.holds(np.zeros(3), TOLERANCE * float(np.linalg.norm(held.frozen))))
        everywhere = np.array([[0.0, np.pi]] if whole else []).reshape(-1, 2)
        return SkyMap(boresight, np.zeros(3), everywhere, float(whole))
    # the angle to the momentum is the same in body axes; it is extreme at these
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
    """Momenta (M, 3) in body axes that the wheels hold with the boresight at an angle to them.

    Some if there are any, at the edges of what can be held.
    """
    aside = np.eye(3)[int(np.argmin(np.abs(boresight)))]
    return held.on_sphere(radius, aside, boresight[None], np.array([radius * np.cos(angle)]))
