"""Slews: limits, a list of slews, and the rotation from one moving reference to another."""

from collections.abc import Callable
from typing import Annotated, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.control.guidance.attitude_reference import AttitudeReference
from gyrostat.control.guidance.bowed_path import BowedPath
from gyrostat.control.guidance.planned_turns import PlannedTurns, Turn
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
        progress = jnp.asarray(jax.vmap(_progress)(self.profiles, since))
        if self.bows is None:
            parts = jax.vmap(rotations.from_rotation_vector)(progress[:, None] * self.turns)
        else:
            parts = jax.vmap(_bowed)(progress, self.turns, self.bows)
        attitude = jnp.asarray(self.attitude, dtype=float)
        for part in parts:
            attitude = rotations.product(attitude, part)
        return attitude


class Transition(NamedTuple):
    """Rotation from a motion to a moving reference, along an eigenaxis of the latter's frame.

    q(t) = q_b(t) exp((1 - s) p) r(c g(t) + a h(t)), with the attitude q_b after the end, the
    rotation p from there to the attitude at the start, the progress s from 0 to 1, and the rate c
    and the acceleration a of the motion before relative to q_b(t) exp(p); r(v) is the rotation with
    the Rodrigues vector v / 2. With x = t / D, over the duration D, g = D x (1 - x)³ (1 + 3 x) and
    h = D² x² (1 - x)³ / 2 have the derivatives g' = 1 and h'' = 1 at the start; all others up to
    the second are zero there and at the end. Attitude, rate and acceleration are therefore
    continuous where those of the profile are. Between attitudes at rest the motion is an eigenaxis
    slew. With bows, a `BowedPath` from the rotation p to none replaces exp((1 - s) p).

    Attributes:
        turn: Rotation vector p, (3,), rad.
        profile: Profile of the progress.
        rate: Rate c, (3,), rad/s.
        acceleration: Acceleration a, (3,), rad/s².
        bows: Both bows of the path, (2, 3), rad; None: there are none.
    """

    turn: Vector3
    profile: SlewProfile
    rate: Vector3
    acceleration: Vector3
    bows: Float[Array, "2 3"] | None = None

    @classmethod
    def none(cls, *, bowed: bool = False) -> Self:
        """Rotation by nothing, which is complete at its start.

        Args:
            bowed: Whether it has bows, which are zero.
        """
        zero = jnp.zeros(())
        still = SlewProfile(zero, zero, zero, zero, zero)
        bows = jnp.zeros((2, 3)) if bowed else None
        return cls(jnp.zeros(3), still, jnp.zeros(3), jnp.zeros(3), bows)

    @classmethod
    def of(
        cls,
        before: AttitudeReference,
        after: AttitudeReference,
        start: Scalar,
        limits: SlewLimits,
        fitted: Callable[[Vector3, SlewProfile], Turn] | None = None,
    ) -> Self:
        """Create the transition.

        Args:
            before: Motion at the start.
            after: Motion of the reference after the end, at the start.
            start: Time of the start, s.
            limits: Limits of the rotation relative to the attitude after the end.
            fitted: Planned rotation for the rotation vector and the profile of the eigenaxis slew,
                see `PlannedTurns.fitted`; None: there are no plans.
        """
        offset = rotations.error(before.attitude, after.attitude)
        carried, gained = (rotations.to_body(offset, each) for each in after[1:])
        rate = before.rate - carried
        acceleration = before.acceleration - gained - jnp.cross(carried, rate)
        turn = rotations.rotation_vector(offset)
        # the slew turns back along p, which has the same components in both frames
        profile = limits.profile(-turn, before.attitude, start, jnp.sqrt(rate @ rate))
        if fitted is None:
            return cls(turn, profile, rate, acceleration)
        planned = fitted(-turn, profile)
        return cls(-planned.turn, planned.profile, rate, acceleration, planned.bows)

    @property
    def duration(self) -> Scalar:
        """Duration, s."""
        return self.profile.duration

    def __call__(self, since: Scalar, after: AttitudeReference) -> AttitudeReference:
        """Motion at a time.

        The rates of the two rotations have closed forms; their second derivatives as functions of
        quaternions would be several times longer in exported code.

        Args:
            since: Time since the start, s, not negative and not after the end.
            after: Motion of the reference after the end, at this time.
        """
        duration = self.duration

        def shares(time: Scalar) -> Vector3:
            x = time / jnp.where(duration > 0.0, duration, 1.0)
            fading = x * (1.0 - x) ** 3 * duration
            remainder = 1.0 - _progress(self.profile, time)
            return jnp.stack([remainder, fading * (1.0 + 3.0 * x), fading * 0.5 * x * duration])

        def changing(time: Scalar) -> tuple[Vector3, Vector3]:
            return jax.jvp(shares, (time,), (jnp.ones_like(time),))

        since = jnp.asarray(since, dtype=float)
        (now, slope), (_, bend) = jax.jvp(changing, (since,), (jnp.ones_like(since),))
        if self.bows is None:
            turn = rotations.from_rotation_vector(now[0] * self.turn)
            turning = AttitudeReference(turn, slope[0] * self.turn, bend[0] * self.turn)
        else:
            path = _path(-self.turn, self.bows, rotations.from_rotation_vector(self.turn))
            turning = path.motion(1.0 - now[0], -slope[0], -bend[0])
        half = 0.5 * jnp.stack([self.rate, self.acceleration])
        moving = _by_rodrigues(*(each[1:] @ half for each in (now, slope, bend)))
        return after.turned(turning).turned(moving)


def _path(turn: Vector3, bows: Float[Array, "2 3"], start: Quaternion) -> BowedPath:
    """Path from an attitude, with bows."""
    eigenaxis = BowedPath.eigenaxis(start, turn)
    return eigenaxis._replace(bow=bows[0], twist=bows[1])


def _bowed(progress: Scalar, turn: Vector3, bows: Float[Array, "2 3"]) -> Quaternion:
    """Rotation from the start of a path at a progress, (4,)."""
    return _path(turn, bows, jnp.array([1.0, 0.0, 0.0, 0.0]))(progress)


def _by_rodrigues(vector: Vector3, slope: Vector3, bend: Vector3) -> AttitudeReference:
    """Motion of the quaternion (1, g) / sqrt(1 + g'g), with g and its first and second derivative.

    The rate is 2 (g' - g x g') / (1 + g'g): M. D. Shuster, "A survey of attitude representations",
    J. Astronautical Sciences 41 (1993), section on the Rodrigues vector.
    """
    scale = 1.0 / (1.0 + vector @ vector)
    attitude = jnp.sqrt(scale) * jnp.concatenate([jnp.ones(1), vector])
    rate = 2.0 * scale * (slope - jnp.cross(vector, slope))
    acceleration = 2.0 * scale * (bend - jnp.cross(vector, bend) - (vector @ slope) * rate)
    return AttitudeReference(attitude, rate, acceleration)


def _progress(profile: SlewProfile, time: Scalar) -> Scalar:
    """Angle over the whole angle, from 0 to 1; 1 after the start of a rotation by zero."""
    turns = profile.angle > 0.0
    share = profile(time) / jnp.where(turns, profile.angle, 1.0)
    return jnp.where(turns, share, jnp.where(time < 0.0, 0.0, 1.0))
