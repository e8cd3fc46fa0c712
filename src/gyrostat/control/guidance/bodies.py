"""Bright bodies in axes of a target that may move, and the cones that instruments keep."""

from collections.abc import Callable
from typing import NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar

NO_BODY = -1.0
"""Angle of a cone that is none, rad."""


class Sky(NamedTuple):
    """Bodies at one time.

    Attributes:
        directions: Unit vectors, (bodies, 3).
        angles: Angle of the cone of each instrument about each body, rad, `NO_BODY` for none,
            (instruments, bodies).
    """

    directions: Float[Array, "bodies 3"]
    angles: Float[Array, "instruments bodies"]


class Bodies(NamedTuple):
    """Bodies over time.

    Attributes:
        boresights: Boresights in body axes, of unit length, (instruments, 3).
        at: Function (time, s) -> bodies.
    """

    boresights: Float[Array, "instruments 3"]
    at: Callable[[Scalar], Sky]
