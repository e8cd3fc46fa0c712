"""Working wheels of a spacecraft, for the design of recovery laws."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.types import Matrix, Vector
from gyrostat.spacecraft import Spacecraft

SPAN = 1e-6
"""Singular value of the working axes below which they do not span a direction."""


class WorkingWheels(NamedTuple):
    """Working wheels, and the inertia of the body with the seized rotors fixed to it.

    Attributes:
        works: Whether each wheel works, (wheels,).
        axes: Spin axes, (3, wheels); zero for failed wheels.
        rotor_inertia: Inertia of every rotor about its axis, (wheels,), kg·m².
        inertia: Inertia of the body and the seized rotors, without the spin inertia of the other
            rotors, (3, 3), kg·m².
        directions: Orthonormal columns, (3, 3); the first ones span the working axes.
        rank: Dimension of the span of the working axes.
    """

    works: np.ndarray
    axes: Matrix
    rotor_inertia: Vector
    inertia: Matrix
    directions: Matrix
    rank: int

    @classmethod
    def of(cls, spacecraft: Spacecraft, working: ArrayLike, seized: ArrayLike | None) -> Self:
        """Working wheels of a spacecraft.

        Args:
            spacecraft: Spacecraft without a batch axis.
            working: Whether each wheel works, (wheels,).
            seized: Whether each rotor is fixed to the body, (wheels,); None for no seized rotor.
        """
        wheels = spacecraft.wheels
        works = np.broadcast_to(np.asarray(working, dtype=bool), (wheels.count,))
        every = np.asarray(wheels.axes, dtype=float)
        rotors = np.asarray(wheels.inertia, dtype=float) * np.ones(wheels.count)
        fixed = np.zeros(wheels.count) if seized is None else np.asarray(seized, dtype=float)
        inertia = np.asarray(spacecraft.inertia, dtype=float) + (every * rotors * fixed) @ every.T
        axes = every * works
        directions, sizes, _ = np.linalg.svd(axes)
        return cls(works, axes, rotors, inertia, directions, int(np.sum(sizes > SPAN)))
