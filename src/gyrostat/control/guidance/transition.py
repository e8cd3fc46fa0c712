"""Rotation from one moving reference to another."""

from collections.abc import Callable
from typing import NamedTuple, Self

from jaxtyping import Array, Float

from gyrostat.control.guidance.attitude_reference import AttitudeReference
from gyrostat.control.guidance.bowed_path import BowedPath
from gyrostat.control.guidance.planned_turns import Turn
from gyrostat.control.guidance.slew import SlewLimits
from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.control.guidance.way_around import Way
from gyrostat.core import rotations
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp


class Before(NamedTuple):
    """Rotations before the last one of a transition, one after the other from rest to rest.

    Attributes:
        turns: Rotation vectors, from the end to the start of each, (2, 3), rad.
        profiles: Profiles of their progress, leading axis (2,).
        fading: Time in which the motion before the transition fades, s.
        blocked: See `gyrostat.control.guidance.way_around.Way`.
    """

    turns: Float[Array, "2 3"]
    profiles: SlewProfile
    fading: Scalar
    blocked: Scalar

    @property
    def durations(self) -> Float[Array, " 2"]:
        """Durations, (2,), s."""
        return jnp.asarray(self.profiles.duration)


class Transition(NamedTuple):
    """Rotation from a motion to a moving reference, along an eigenaxis of the latter's frame.

    q(t) = q_b(t) exp((1 - s) p) r(c g(t) + a h(t)), with the attitude q_b after the end, the
    rotation p from there to the attitude at the start, the progress s from 0 to 1, and the rate c
    and the acceleration a of the motion before relative to q_b(t) exp(p); r(v) is the rotation with
    the Rodrigues vector v / 2. With x = t / D, over the duration D, g = D x (1 - x)³ (1 + 3 x) and
    h = D² x² (1 - x)³ / 2 have the derivatives g' = 1 and h'' = 1 at the start; all others up to
    the second are zero there and at the end. Attitude, rate and acceleration are therefore
    continuous where those of the profile are. Between attitudes at rest the motion is an eigenaxis
    slew. With bows, a `BowedPath` from the rotation p to none replaces exp((1 - s) p). With
    rotations before it, exp((1 - s) p) exp((1 - s_2) p_2) exp((1 - s_1) p_1) replaces it, in which
    s_1, s_2 and s grow one after the other; c and a then fade in a duration D of their own.

    Attributes:
        turn: Rotation vector p, (3,), rad.
        profile: Profile of the progress.
        rate: Rate c, (3,), rad/s.
        acceleration: Acceleration a, (3,), rad/s².
        bows: Both bows of the path, (2, 3), rad; None: there are none.
        first: Rotations before it; None: there are none.
    """

    turn: Vector3
    profile: SlewProfile
    rate: Vector3
    acceleration: Vector3
    bows: Float[Array, "2 3"] | None = None
    first: Before | None = None

    @classmethod
    def none(cls, *, bowed: bool = False, around: bool = False) -> Self:
        """Rotation by nothing, which is complete at its start.

        Args:
            bowed: Whether it has bows, which are zero.
            around: Whether it has rotations before it, by zero.
        """
        zero = jnp.zeros(())
        still = SlewProfile(zero, zero, zero, zero, zero)
        bows = jnp.zeros((2, 3)) if bowed else None
        first = Before(*Way.straight(jnp.zeros(3), still)[:2], zero, zero) if around else None
        return cls(jnp.zeros(3), still, jnp.zeros(3), jnp.zeros(3), bows, first)

    @classmethod
    def of(
        cls,
        before: AttitudeReference,
        after: AttitudeReference,
        start: Scalar,
        limits: SlewLimits,
        fitted: Callable[[Vector3, SlewProfile, tuple[Scalar, Scalar]], Turn] | None = None,
        around: Callable[["Transition"], Way] | None = None,
    ) -> Self:
        """Create the transition.

        Args:
            before: Motion at the start.
            after: Motion of the reference after the end, at the start.
            start: Time of the start, s.
            limits: Limits of the rotation relative to the attitude after the end.
            fitted: Planned rotation for the rotation vector, the profile of the eigenaxis slew and
                the relative motion, see `PlannedTurns.fitted`; None: there are no plans.
            around: Way for the transition without rotations before it; None: there are none.
        """
        offset = rotations.error(before.attitude, after.attitude)
        carried, gained = (rotations.to_body(offset, each) for each in after[1:])
        rate = before.rate - carried
        acceleration = before.acceleration - gained - jnp.cross(carried, rate)
        turn = rotations.rotation_vector(offset)
        # the slew turns back along p, which has the same components in both frames
        profile = limits.profile(-turn, before.attitude, start, jnp.sqrt(rate @ rate))
        eigenaxis = cls(turn, profile, rate, acceleration)
        if fitted is None:
            return eigenaxis
        planned = fitted(-turn, profile, eigenaxis.moves)
        direct = cls(-planned.turn, planned.profile, rate, acceleration, planned.bows)
        if around is None:
            return direct
        way = around(direct)
        total = jnp.sum(jnp.asarray(way.profiles.duration)) + way.profile.duration
        fading = jnp.minimum(direct.duration, total)
        first = Before(way.turns, way.profiles, fading, way.blocked)
        return direct._replace(turn=way.last, profile=way.profile, first=first)

    @property
    def moves(self) -> tuple[Scalar, Scalar]:
        """Sizes of the rate, rad/s, and of the acceleration, rad/s², at the start."""
        rate, acceleration = self.rate, self.acceleration
        return jnp.sqrt(rate @ rate), jnp.sqrt(acceleration @ acceleration)

    @property
    def duration(self) -> Scalar:
        """Duration, s."""
        if self.first is None:
            return self.profile.duration
        return jnp.sum(self.first.durations) + self.profile.duration

    def __call__(self, since: Scalar, after: AttitudeReference) -> AttitudeReference:
        """Motion at a time.

        The rates of the two rotations have closed forms; their second derivatives as functions of
        quaternions would be several times longer in exported code.

        Args:
            since: Time since the start, s, not negative and not after the end.
            after: Motion of the reference after the end, at this time.
        """
        first = self.first
        duration = self.duration if first is None else first.fading

        def shares(time: Scalar) -> Array:
            x = time / jnp.where(duration > 0.0, duration, 1.0)
            x = x if first is None else jnp.minimum(x, 1.0)
            fading = x * (1.0 - x) ** 3 * duration
            moving = [fading * (1.0 + 3.0 * x), fading * 0.5 * x * duration]
            if first is None:
                return jnp.stack([1.0 - self.profile.progress(time), *moving])
            ends = jnp.cumsum(first.durations)
            since = time - jnp.stack([jnp.zeros(()), ends[0]])
            before = 1.0 - jnp.asarray(jax.vmap(SlewProfile.progress)(first.profiles, since))
            remainder = 1.0 - self.profile.progress(time - ends[1])
            return jnp.stack([remainder, *moving, *before])

        def changing(time: Scalar) -> tuple[Vector3, Vector3]:
            return jax.jvp(shares, (time,), (jnp.ones_like(time),))

        since = jnp.asarray(since, dtype=float)
        (now, slope), (_, bend) = jax.jvp(changing, (since,), (jnp.ones_like(since),))
        if self.bows is None:
            turning = _about_axis(self.turn, now[0], slope[0], bend[0])
        else:
            begin = rotations.from_rotation_vector(self.turn)
            path = BowedPath.bowed(begin, -self.turn, self.bows)
            turning = path.motion(1.0 - now[0], -slope[0], -bend[0])
        if first is not None:
            for k in (1, 0):
                parts = (each[3 + k] for each in (now, slope, bend))
                turning = turning.turned(_about_axis(first.turns[k], *parts))
        half = 0.5 * jnp.stack([self.rate, self.acceleration])
        moving = _by_rodrigues(*(each[1:3] @ half for each in (now, slope, bend)))
        return after.turned(turning).turned(moving)


def _about_axis(turn: Vector3, share: Scalar, slope: Scalar, bend: Scalar) -> AttitudeReference:
    """Motion of exp(share turn), with the first and second derivative of the share."""
    attitude = rotations.from_rotation_vector(share * turn)
    return AttitudeReference(attitude, slope * turn, bend * turn)


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
