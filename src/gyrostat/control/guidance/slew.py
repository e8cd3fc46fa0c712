"""Slews: limits, and a list of slews."""

from typing import Annotated, Self

import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.control.guidance.bowed_path import BowedPath
from gyrostat.control.guidance.planned_turns import PlannedTurns
from gyrostat.control.guidance.profiles import is_unit
from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.control.guidance.wheel_envelope import WheelEnvelope, WheelRoom
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, limit
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp


class SlewLimits(Checked):
    """Limits of eigenaxis slews; with an envelope, also those of the working wheels.

    Attributes:
        rate: Rate limit, rad/s; infinite: that of the envelope alone.
        acceleration: Acceleration limit, rad/s²; infinite: that of the envelope alone.
        jerk: Jerk limit, rad/s³; may be infinite.
        envelope: Torque and momentum of the working wheels; None: they are not considered.
    """

    rate: Annotated[Scalar, limit("slew rate", "rad/s")] = np.inf
    acceleration: Annotated[Scalar, limit("slew acceleration", "rad/s²")] = np.inf
    jerk: Annotated[Scalar, limit("slew jerk", "rad/s³")] = np.inf
    envelope: WheelEnvelope | None = None

    def check_own(self) -> None:
        """Check that the acceleration is limited.

        Raises:
            InputError: Neither acceleration nor jerk is finite, and there is no envelope.
        """
        if self.envelope is None and np.any(np.isinf(self.acceleration) & np.isinf(self.jerk)):
            raise InputError(
                "slew limits: found neither acceleration nor jerk, expected one of them, or an "
                "envelope of the wheels"
            )

    def room(self, time: Scalar) -> WheelRoom | None:
        """Wheels that a slew may use; None: they are not considered.

        Args:
            time: Time of its start, s.
        """
        return None if self.envelope is None else self.envelope.room(time)

    def profile(
        self, turn: Vector3, attitude: Quaternion, time: Scalar, change: Scalar = 0.0
    ) -> SlewProfile:
        """Fastest profile of a slew.

        Args:
            turn: Rotation vector of the slew in body axes, (3,), rad.
            attitude: Attitude at its start, (4,).
            time: Time of its start, s.
            change: Change of the rate between the motions before and after, rad/s. The profile then
                has a larger angle, so that it lasts long enough for the change.
        """
        rate, acceleration = self.rate, self.acceleration
        if self.envelope is not None:
            rate, acceleration = self.envelope.limits(turn, attitude, time, rate, acceleration)
        angle = jnp.sqrt(turn @ turn) + 4.0 * change**2 / acceleration
        return SlewProfile.fastest(angle, rate, acceleration, self.jerk)


class Slews(Checked):
    """Eigenaxis slews between fixed attitudes, each from its start time.

    q(t) = q_0 exp(s_1(t) p_1) exp(s_2(t) p_2) ..., with the rotation vector p_i of slew i and its
    progress s_i from 0 to 1; a slew around cones follows a `BowedPath` instead. A slew that starts
    before the last one has ended is added to it: the motion stays smooth and ends at the right
    attitude, but its limits are those of each slew alone.

    Attributes:
        attitude: Attitude before the first slew, a unit quaternion, (4,).
        times: Start times, (slews,), increasing, s.
        turns: Rotation vectors, each in body axes before its slew, (slews, 3), rad.
        profiles: Profiles of all slews, with a leading axis of slews.
        bows: Both bows of each slew, (slews, 2, 3), rad; None: all turn about their eigenaxis.
    """

    attitude: Annotated[Quaternion, is_unit]
    times: Float[Array, " slews"]
    turns: Float[Array, "slews 3"]
    profiles: SlewProfile
    bows: Float[Array, "slews 2 3"] | None = None

    @classmethod
    def to(
        cls,
        attitude: ArrayLike,
        times: ArrayLike,
        attitudes: ArrayLike,
        limits: SlewLimits,
        planned: PlannedTurns | None = None,
    ) -> Self:
        """Create the slews; can be traced by JAX.

        Args:
            attitude: Attitude before the first slew, (4,).
            times: Start times, (slews,), s.
            attitudes: Attitude after each slew, (slews, 4).
            limits: Limits of every slew.
            planned: Planned rotation of each slew; None: no plans.
        """
        ends = jnp.concatenate([jnp.asarray(attitude, dtype=float)[None], jnp.asarray(attitudes)])
        starts = jnp.asarray(times, dtype=float)
        turns = jax.vmap(lambda a, b: rotations.rotation_vector(rotations.error(b, a)))(
            ends[:-1], ends[1:]
        )
        profiles = jax.vmap(limits.profile)(turns, ends[:-1], starts)
        if planned is None:
            return cls(ends[0], starts, turns, profiles)
        rows = jnp.arange(len(starts))
        each = jax.vmap(planned.fitted)(rows, turns, profiles)
        return cls(ends[0], starts, each.turn, each.profile, each.bows)

    def ends(self) -> Float[Array, " slews"]:
        """End times of the slews, (slews,), s."""
        return self.times + self.profiles.duration

    def __call__(self, time: Scalar) -> Quaternion:
        """Attitude at a time, s."""
        since = time - jnp.asarray(self.times)
        progress = jnp.asarray(jax.vmap(SlewProfile.progress)(self.profiles, since))
        if self.bows is None:
            parts = jax.vmap(rotations.from_rotation_vector)(progress[:, None] * self.turns)
        else:
            parts = jax.vmap(_bowed)(progress, self.turns, self.bows)
        attitude = jnp.asarray(self.attitude, dtype=float)
        for part in parts:
            attitude = rotations.product(attitude, part)
        return attitude


def _bowed(progress: Scalar, turn: Vector3, bows: Float[Array, "2 3"]) -> Quaternion:
    """Rotation from the start of a path at a progress, (4,)."""
    return BowedPath.bowed(jnp.array([1.0, 0.0, 0.0, 0.0]), turn, bows)(progress)
