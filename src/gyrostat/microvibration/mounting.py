"""Wheels of a structure against those of a spacecraft."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.sight import MountedWheel

PARALLEL = 0.999
"""Least cosine between the axes of a wheel of the spacecraft and of the structure."""


def senses_of(
    wheels: Sequence[MountedWheel], names: Sequence[str], axes: Matrix, owner: str
) -> Vector:
    """1 for each wheel whose axis is that of the spacecraft, -1 for the opposite, (wheels,).

    Args:
        wheels: Wheels on the structure, in the order of those of the spacecraft.
        names: Names of the wheels of the spacecraft.
        axes: Their spin axes, unit vectors, (wheels, 3).
        owner: Name of the scenario, for messages.

    Raises:
        InputError: The structure has other wheels.
    """
    if len(wheels) != len(names):
        raise InputError(
            f"key wheel: found {len(wheels)} wheels on the structure, expected the {len(names)} "
            f"of {owner}"
        )
    cosines = np.sum([wheel.axis for wheel in wheels] * np.asarray(axes), axis=1)
    for name, cosine, axis, wheel in zip(names, cosines, axes, wheels, strict=True):
        if abs(cosine) < PARALLEL:
            raise InputError(
                f"{wheel.name}: found the axis {np.round(wheel.axis, 4).tolist()}, expected "
                f"that of wheel {name} of {owner}, {np.round(axis, 4).tolist()}"
            )
    return np.sign(cosines)
