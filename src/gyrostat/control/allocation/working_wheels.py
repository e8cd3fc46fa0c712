"""The subset of working wheels, for laws designed on it."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.types import Matrix, Vector
from gyrostat.spacecraft import Spacecraft

SPAN = 1e-6
"""Of a singular value of the working axes: below it they do not reach that direction."""


class WorkingWheels(NamedTuple):
    """The working wheels, and the body with the seized ones fixed to it.

    Attributes:
        works: (wheels,) whether a wheel works.
        axes: (3, wheels) spin axes, those of failed wheels zero.
        rotor_inertia: (wheels,) of every rotor about its axis, kg·m².
        inertia: (3, 3) of the body and the seized rotors, without the own spin of the others,
            kg·m².
        directions: (3, 3) orthonormal columns, first those that the working axes span.
        rank: how many they span.
    """

    works: np.ndarray
    axes: Matrix
    rotor_inertia: Vector
    inertia: Matrix
    directions: Matrix
    rank: int

    @classmethod
    def of(cls, spacecraft: Spacecraft, working: ArrayLike, seized: ArrayLike | None) -> Self:
        """Those of a spacecraft.

        Args:
            spacecraft: one, no batch.
            working: (wheels,) whether a wheel works.
            seized: (wheels,) whether the rotor is fixed to the body; None for none.
        """
        wheels = spacecraft.wheels
        works = np.broadcast_to(np.asarray(working, dtype=bool), (wheels.count,))
        every = np.asarray(wheels.axes, dtype=float)
        own = np.asarray(wheels.inertia, dtype=float) * np.ones(wheels.count)
        fixed = np.zeros(wheels.count) if seized is None else np.asarray(seized, dtype=float)
        inertia = np.asarray(spacecraft.inertia, dtype=float) + (every * own * fixed) @ every.T
        axes = every * works
        directions, sizes, _ = np.linalg.svd(axes)
        return cls(works, axes, own, inertia, directions, int(np.sum(sizes > SPAN)))
