"""Rotations around keep-out cones that were planned once, as data of a reference."""

from typing import Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Bool, Float, Int

from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jax, jnp

DEVIATION = 0.1
"""Largest change of a rotation vector against its plan, rad, and as a share of its angle. Rates and
torques grow by the same share; the default shares of the wheels leave that free."""
TINY = 1e-9
"""Angle below which a rotation has no longer way around, rad."""


class Turn(NamedTuple):
    """Rotation from rest to rest along a `gyrostat.control.guidance.bowed_path.BowedPath`.

    Attributes:
        turn: Rotation vector in body axes at the start, (3,), rad; longer than pi for the longer
            way around.
        bows: Both bows of the path, (2, 3), rad; zero for an eigenaxis slew.
        profile: Profile of the progress.
    """

    turn: Vector3
    bows: Float[Array, "2 3"]
    profile: SlewProfile


class PlannedTurns(NamedTuple):
    """Planned rotations, and which of them are planned; leading axis (rotations,).

    Attributes:
        is_planned: 1 for a rotation that is planned, otherwise 0, (rotations,).
        turns: The rotations.
    """

    is_planned: Float[Array, " rotations"]
    turns: Turn

    @classmethod
    def none(cls, count: int) -> Self:
        """Rotations of which none is planned.

        Args:
            count: Number of rotations.
        """
        zero: Any = np.zeros(count)
        bows: Any = np.zeros((count, 2, 3))
        return cls(zero, Turn(bows[:, 0], bows, SlewProfile(zero, zero, zero, zero, zero)))

    def planned(self, row: int, turn: Turn) -> Self:
        """Rotations with a plan for one of them.

        Args:
            row: Number of the rotation.
            turn: Its plan.
        """

        def put(every: Any, value: Any) -> Any:
            changed = np.array(every, dtype=float)
            changed[row] = value
            return changed

        return jax.tree.map(put, self, type(self)(jnp.ones(()), turn))

    def fits(self, row: Int[Array, ""] | int, turn: Vector3) -> Bool[Array, ""]:
        """Whether a rotation of a run is near that of a plan; see `fitted`."""
        return self._nearest(row, turn)[1]

    def _nearest(
        self, row: Int[Array, ""] | int, turn: Vector3
    ) -> tuple[Vector3, Bool[Array, ""], Turn]:
        """Of both ways around, the nearest one to the plan, whether it is near, and the plan."""
        is_planned, plan = jax.tree.map(lambda each: jnp.asarray(each)[row], tuple(self))
        angle = jnp.sqrt(turn @ turn)
        longer = (1.0 - 2.0 * jnp.pi / jnp.maximum(angle, TINY)) * turn
        offsets = turn - plan.turn, longer - plan.turn
        squares = [offset @ offset for offset in offsets]
        taken = jnp.where(squares[0] <= squares[1], turn, longer)
        reach = DEVIATION**2 * jnp.minimum(plan.turn @ plan.turn, 1.0)
        return taken, (is_planned > 0.0) & (jnp.minimum(*squares) <= reach), plan

    def fitted(self, row: Int[Array, ""] | int, turn: Vector3, otherwise: SlewProfile) -> Turn:
        """Rotation of a run: the planned one if its start and its end are near those of the plan.

        Args:
            row: Number of the rotation.
            turn: Rotation vector of the shortest rotation, (3,), rad.
            otherwise: Profile of the eigenaxis slew, which is taken without a plan, or if the
                rotation vector is farther than `DEVIATION` from the planned one.
        """
        taken, fits, plan = self._nearest(row, turn)
        eigenaxis = Turn(turn, jnp.zeros((2, 3)), otherwise)
        fitted = Turn(taken, plan.bows, plan.profile)
        return jax.tree.map(lambda one, other: jnp.where(fits, one, other), fitted, eigenaxis)
