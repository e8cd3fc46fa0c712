"""Common wheel arrangements: orthogonal, pyramid."""

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix

EQUAL_REACH = float(np.arcsin(1.0 / np.sqrt(3.0)))
"""rad, 35.26 deg: with this elevation a pyramid gives as much torque along as across its axis."""


def orthogonal_axes() -> Matrix:
    """(3, 3): one wheel along each body axis."""
    return np.eye(3)


def pyramid_axes(
    count: int = 4, *, elevation: float = EQUAL_REACH, azimuth: float = np.pi / 4.0
) -> Matrix:
    """Spin axes spread evenly round the body's z axis.

    Args:
        count: of wheels, 3 or more.
        elevation: of every axis above the x-y plane, rad, between 0 and pi/2 without the ends.
        azimuth: of the first axis from x towards y, rad.

    Returns:
        (3, count) unit vectors in body axes, in the order of their azimuth.

    Raises:
        InputError: fewer than 3 wheels, or axes that do not span space.
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
