"""Axes: GCRS, ITRF, TEME and EME2000, and geodetic coordinates.

Computed by the library erfa: precession and nutation of the IAU 2006/2000A models, Earth rotation
angle, sidereal time of 1982 for TEME, the ellipsoid WGS 84. Polar motion is 0 (it is below 0.6
arcseconds, 20 m on the ground). The functions need the extra `orbit`.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.libraries import library
from gyrostat.spacecraft.orbit.time_scales import Epoch, Times

EARTH_RATE = 7.292115146706979e-5
"""Rate of the Earth rotation angle, rad/s of UT1: 2 pi 1.00273781191135448 / 86400 (IAU 2000)."""
FRAMES = ("GCRS", "EME2000", "TEME", "ITRF")
"""Axes that are converted to those of the GCRS."""

Vectors = Float[np.ndarray, "rows 3"]
Matrices = Float[np.ndarray, "rows 3 3"]


class States(NamedTuple):
    """Positions and velocities along an orbit.

    Attributes:
        position: Positions from the centre of the Earth, (rows, 3), m.
        velocity: Velocities, (rows, 3), m/s.
    """

    position: Vectors
    velocity: Vectors


def gcrs_to_itrf(epoch: Epoch, times: Times) -> Matrices:
    """Matrices from GCRS to ITRF axes at times, s, (rows, 3, 3)."""
    return library("erfa").c2t06a(*epoch.tt(times), *epoch.ut1_at(times), 0.0, 0.0)


def teme_to_gcrs(epoch: Epoch, times: Times) -> Matrices:
    """Matrices from TEME to GCRS axes at times, s, (rows, 3, 3).

    TEME is the frame of SGP4: the true equator, and an equinox from which Greenwich is at the mean
    sidereal time of 1982. D. A. Vallado, P. Crawford, R. Hujsak, T. S. Kelso, "Revisiting
    Spacetrack Report #3" (AIAA 2006-6753), appendix C.
    """
    erfa = library("erfa")
    turn = erfa.rz(erfa.gmst82(*epoch.ut1_at(times)), np.eye(3))
    return transposed(gcrs_to_itrf(epoch, times)) @ turn


def earth_attitude(to_itrf: Matrices) -> Float[np.ndarray, "rows 4"]:
    """Attitude of the ITRF with respect to the GCRS.

    Args:
        to_itrf: Matrices from GCRS to ITRF axes at ascending times, (rows, 3, 3).

    Returns:
        Quaternions, scalar first, (rows, 4). The first one has a scalar part of 0 or more, and the
        others have no change of sign from row to row.
    """
    from scipy.spatial.transform import Rotation  # slow to import

    rotations = Rotation.from_matrix(transposed(to_itrf))
    quaternions = rotations.as_quat(canonical=True, scalar_first=True)
    steps = np.sum(quaternions[1:] * quaternions[:-1], axis=1)
    quaternions[1:] *= np.cumprod(np.where(steps < 0.0, -1.0, 1.0))[:, None]
    return quaternions


def to_gcrs(states: States, frame: str, epoch: Epoch, times: Times) -> States:
    """Convert states to axes of the GCRS, with inertial velocities.

    Args:
        states: Positions and velocities. Those in ITRF axes are relative to the turning Earth.
        frame: One of `FRAMES`.
        epoch: Epoch of the run.
        times: Times of the states, s.

    Raises:
        InputError: The frame is none of `FRAMES`.
    """
    position, velocity = states
    if frame == "GCRS":
        return states
    if frame == "EME2000":
        # the frame bias of the IAU 2006 model, 23 milliarcseconds
        bias = library("erfa").bp06(*epoch.tt(np.zeros(1)))[0][0]
        return States(position @ bias, velocity @ bias)
    if frame == "TEME":
        matrices = teme_to_gcrs(epoch, times)
    elif frame == "ITRF":
        matrices = transposed(gcrs_to_itrf(epoch, times))
        velocity = velocity + np.cross([0.0, 0.0, EARTH_RATE], position)
    else:
        raise InputError(f"frame: found {frame!r}, expected one of {', '.join(FRAMES)}")
    return States(rotated(matrices, position), rotated(matrices, velocity))


def geodetic(position: Vectors) -> tuple[Times, Times, Times]:
    """Geodetic coordinates (WGS 84) of positions in ITRF axes, (rows, 3), m.

    Returns:
        Latitude, rad; longitude to the east, rad; height above the ellipsoid, m; each (rows,).
    """
    longitude, latitude, height = library("erfa").gc2gd(1, position)
    return latitude, longitude, height


def rotated(matrices: Matrices, vectors: Vectors) -> Vectors:
    """Product of each matrix with its vector, (rows, 3)."""
    return (matrices @ vectors[:, :, None])[:, :, 0]


def transposed(matrices: Matrices) -> Matrices:
    """Transpose of each matrix, (rows, 3, 3)."""
    return np.swapaxes(matrices, -1, -2)
