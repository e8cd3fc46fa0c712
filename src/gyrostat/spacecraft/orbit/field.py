"""Magnetic field of the Earth: International Geomagnetic Reference Field (IGRF).

The library ppigrf, with the coefficients that it brings. It holds the field inside the Earth, up to
degree 13; currents above the Earth (tens of nT on quiet days) are left out. P. Alken et al. (2021),
"International Geomagnetic Reference Field: the thirteenth generation", Earth, Planets and Space 73.
"""

import datetime

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.frames import Vectors
from gyrostat.spacecraft.orbit.libraries import library
from gyrostat.spacecraft.orbit.time_scales import Epoch, Times

FIRST_YEAR, LAST_YEAR, YEARS = 1900, 2030, 5
"""First and last year of the coefficients, and years between two sets."""
ROWS = 20_000
"""Positions evaluated together; the library holds some hundred numbers for each."""
_LEAST_COLATITUDE = 1e-8  # deg: the library divides by its sine


def magnetic_field(epoch: Epoch, times: Times, position: Vectors) -> Vectors:
    """Magnetic flux density at positions.

    The library forms all pairs of dates and positions. As the coefficients change linearly between
    two sets, the field at the dates of the first and the last row, and of the sets between them,
    gives that of every row exactly.

    Args:
        epoch: Epoch of the run.
        times: Times of the positions, s, ascending.
        position: Positions in ITRF axes, (rows, 3), m.

    Returns:
        Flux density in ITRF axes, (rows, 3), T.

    Raises:
        InputError: A time is outside the years of the coefficients.
    """
    dates = epoch.calendar(times)
    years = np.arange(FIRST_YEAR, LAST_YEAR + 1, YEARS)
    sets = np.array([f"{year}-01-01" for year in years], dtype=dates.dtype)
    first, last = dates[0], dates[-1]
    if first < sets[0] or last > sets[-1]:
        raise InputError(
            f"orbit: found times from {first} to {last}, expected the years {FIRST_YEAR} to "
            f"{LAST_YEAR} of the magnetic field"
        )
    nodes = np.unique(np.concatenate([[first], sets[(sets > first) & (sets < last)], [last]]))
    return np.concatenate(
        [
            _between_nodes(nodes, dates[k : k + ROWS], position[k : k + ROWS])
            for k in range(0, len(dates), ROWS)
        ]
    )


def _between_nodes(nodes: np.ndarray, dates: np.ndarray, position: Vectors) -> Vectors:
    """Flux density, ITRF axes, (rows, 3), T, from that at the dates of the nodes."""
    x, y, z = position.T
    colatitude, longitude = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    radius = np.linalg.norm(position, axis=1)
    at_nodes = library("ppigrf").igrf_gc(
        radius / 1e3,
        np.maximum(np.degrees(colatitude), _LEAST_COLATITUDE),
        np.degrees(longitude),
        [node.astype(datetime.datetime) for node in nodes],
    )
    rows, last = np.arange(len(dates)), max(len(nodes) - 2, 0)
    node = np.clip(np.searchsorted(nodes, dates, side="right") - 1, 0, last)
    following = np.minimum(node + 1, len(nodes) - 1)
    length = np.maximum(nodes[following] - nodes[node], np.timedelta64(1, "us"))
    share = (dates - nodes[node]) / length
    radial, south, east = (
        1e-9 * ((1.0 - share) * part[node, rows] + share * part[following, rows])
        for part in at_nodes
    )
    level = radial * np.sin(colatitude) + south * np.cos(colatitude)
    return np.stack(
        [
            level * np.cos(longitude) - east * np.sin(longitude),
            level * np.sin(longitude) + east * np.cos(longitude),
            radial * np.cos(colatitude) - south * np.sin(colatitude),
        ],
        axis=1,
    )
