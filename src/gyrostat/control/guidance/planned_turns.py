"""Rotations around keep-out cones that were planned once, as data of a reference."""

from typing import Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Bool, Float, Int

from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp

DEVIATION = 0.1
"""Largest change of a rotation vector against its plan, rad, and as a share of its angle. Rates and
torques grow by the same share; the default shares of the wheels leave that free."""
TINY = 1e-9
"""Angle below which a rotation has no longer way around, rad."""
ROUNDING = 1e-6
"""Angle by which rounding may move a start that is as planned, rad."""
FADING = 0.198, 0.0173
"""Largest x (1 - x)³ (1 + 3 x) and x² (1 - x)³ / 2: see `Transition`, g / D and h / D²."""


def turned_beside(rate: Scalar, acceleration: Scalar, duration: Scalar) -> Scalar:
    """Bound of the angle by which the motion before a transition turns the body beside its path.

    Args:
        rate: Size of the rate relative to the target, rad/s.
        acceleration: Size of the acceleration relative to it, rad/s².
        duration: Time in which they fade, s.
    """
    return FADING[0] * rate * duration + FADING[1] * acceleration * duration**2


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
        covers: Change of the rotation vector, and angle `turned_beside` the path, that the cones of
            each plan are widened for, (rotations, 2), rad; a rotation with more does not fit. None:
            it fits within `DEVIATION`.
    """

    is_planned: Float[Array, " rotations"]
    turns: Turn
    covers: Float[Array, "rotations 2"] | None = None

    @classmethod
    def none(cls, count: int, *, covered: bool = False) -> Self:
        """Rotations of which none is planned.

        Args:
            count: Number of rotations.
            covered: Whether each plan says what its cones are widened for.
        """
        zero: Any = np.zeros(count)
        bows: Any = np.zeros((count, 2, 3))
        covers: Any = np.zeros((count, 2)) if covered else None
        turns = Turn(bows[:, 0], bows, SlewProfile(zero, zero, zero, zero, zero))
        return cls(zero, turns, covers)

    def planned(self, row: int, turn: Turn, covers: Any = None) -> Self:
        """Rotations with a plan for one of them.

        Args:
            row: Number of the rotation.
            turn: Its plan.
            covers: What its cones are widened for, (2,), see the attributes.
        """

        def put(every: Any, value: Any) -> Any:
            changed = np.array(every, dtype=float)
            changed[row] = value
            return changed

        return jax.tree.map(put, self, type(self)(jnp.ones(()), turn, covers))

    def fits(
        self, row: Int[Array, ""] | int, turn: Vector3, motion: tuple[Scalar, Scalar]
    ) -> Bool[Array, ""]:
        """Whether a rotation of a run is near that of a plan; see `fitted`."""
        return self._nearest(row, turn, motion)[1]

    def _nearest(
        self, row: Int[Array, ""] | int, turn: Vector3, motion: tuple[Scalar, Scalar]
    ) -> tuple[Vector3, Bool[Array, ""], Turn]:
        """Of both ways around, the nearest one to the plan, whether it is near, and the plan."""
        is_planned, plan, covers = jax.tree.map(lambda each: jnp.asarray(each)[row], tuple(self))
        angle = jnp.sqrt(turn @ turn)
        longer = (1.0 - 2.0 * jnp.pi / jnp.maximum(angle, TINY)) * turn
        offsets = turn - plan.turn, longer - plan.turn
        squares = [offset @ offset for offset in offsets]
        taken = jnp.where(squares[0] <= squares[1], turn, longer)
        reach = DEVIATION**2 * jnp.minimum(plan.turn @ plan.turn, 1.0)
        fits = is_planned > 0.0
        if covers is not None:
            reach = jnp.minimum(reach, (covers[0] + ROUNDING) ** 2)
            fits &= turned_beside(*motion, plan.profile.duration) <= covers[1] + ROUNDING
        return taken, fits & (jnp.minimum(*squares) <= reach), plan

    def fitted(
        self,
        row: Int[Array, ""] | int,
        turn: Vector3,
        otherwise: SlewProfile,
        motion: tuple[Scalar, Scalar] = (0.0, 0.0),
    ) -> Turn:
        """Rotation of a run: the planned one if its start and its end are near those of the plan.

        Args:
            row: Number of the rotation.
            turn: Rotation vector of the shortest rotation, (3,), rad.
            otherwise: Profile of the eigenaxis slew, which is taken without a plan, or if the
                rotation vector is farther than `DEVIATION` from the planned one, or the start has
                more than the plan `covers`.
            motion: Sizes of the rate, rad/s, and of the acceleration, rad/s², at the start relative
                to the target.
        """
        taken, fits, plan = self._nearest(row, turn, motion)
        eigenaxis = Turn(turn, jnp.zeros((2, 3)), otherwise)
        fitted = Turn(taken, plan.bows, plan.profile)
        return jax.tree.map(lambda one, other: jnp.where(fits, one, other), fitted, eigenaxis)
