"""Common wheel arrangements: orthogonal and pyramid."""

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix

EQUAL_REACH = float(np.arcsin(1.0 / np.sqrt(3.0)))
"""Elevation, rad (35.26 deg), at which a pyramid gives the same torque along its axis as across
it."""


def orthogonal_axes() -> Matrix:
    """Spin axes of three wheels, one along each body axis, (3, 3)."""
    return np.eye(3)


def pyramid_axes(
    count: int = 4, *, elevation: float = EQUAL_REACH, azimuth: float = np.pi / 4.0
) -> Matrix:
    """Spin axes spaced evenly around the z axis of the body.

    Args:
        count: Number of wheels, 3 or more.
        elevation: Elevation of every axis above the x-y plane, rad, above 0 and below pi/2.
        azimuth: Azimuth of the first axis from x towards y, rad.

    Returns:
        Unit vectors in body axes, in the order of their azimuth, (3, count).

    Raises:
        InputError: There are fewer than 3 wheels, or the axes do not span space.
    """
    if count < 3:
        raise InputError(f"wheels of a pyramid: found {count}, expected 3 or more")
    if not 0.0 < elevation < np.pi / 2.0:
        raise InputError(
            f"elevation of a pyramid: found {elevation:g} rad, expected between 0 and pi/2"
        )
    around = azimuth + 2.0 * np.pi * np.arange(count) / count
    flat = np.cos(elevation)
    height = np.full(count, np.sin(elevation))
    return np.stack([flat * np.cos(around), flat * np.sin(around), height])
