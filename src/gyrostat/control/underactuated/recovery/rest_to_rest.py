"""Rest-to-rest rotations of a body that can only turn about axes in one plane.

With two wheels and no momentum, the body rate is orthogonal to one axis z of the body, along J n
with n the normal of the two wheel axes. The body then moves like a ball that rolls without spin.
Every attitude can still be reached. The shortest rotation is one sweep, whose axis turns in the
plane at a constant rate per angle turned, because the extremals of this problem are

    q(s) = exp((e + k z) s / 2) exp(-k z s / 2),

with s the angle turned so far, e the axis at the start and k the curvature. This is the limit of a
sequence of ever shorter rotations about axes in the plane. With k = 0 it is a simple rotation; a
rotation about z alone is one closed loop. V. Jurdjevic, "Geometric Control Theory", chapters 12 and
14, has the extremals; end point, timing and solution are derived here.

Attitudes and axes in this module are in sweep axes, whose third axis is z. The functions use only
closed forms and loops of fixed length. Each call handles one rotation; use `vmap` for many.
"""

from typing import NamedTuple

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp

HALVINGS = 64
"""Number of bisections for the half angle of a sweep, enough to reach rounding."""
LEAST_TILT = 1e-10
"""Sine of half the rotation across z, below which it counts as a rotation about z alone."""
RAMP_PEAK = 1.5
"""Largest slope of the ramp x^2 (3 - 2 x)."""
RAMP_SHARE = 0.85
"""Fraction of the acceleration limit for speeding up. The rest is for the change of the axis:
(RAMP_SHARE slope / RAMP_PEAK)^2 + ramp^4 stays below 1."""


class Sweep(NamedTuple):
    """Rotation from rest to rest about an axis that turns in a plane.

    Attributes:
        direction: Direction of the first axis in the plane, from x towards y, rad.
        curvature: Angle that the axis turns for each angle of the rotation, 1.
        length: Total angle of the rotation, rad.
        speed: Largest rate, rad/s.
        ramp: Time in which that rate is reached, and in which it falls to zero again, s.
    """

    direction: Scalar
    curvature: Scalar
    length: Scalar
    speed: Scalar
    ramp: Scalar

    @property
    def duration(self) -> Scalar:
        """Duration from rest to rest, s; zero for a sweep of zero length."""
        return self.length / self.speed + self.ramp


def _half_phase(deficit: Scalar, tilt: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Twist of a sweep of half angle pi - `deficit`, and its axis parts across and along z."""
    across = tilt / jnp.sin(deficit)
    along = jnp.sqrt(jnp.maximum(1.0 - across**2, 0.0))
    twist = jnp.arctan2(along * jnp.sin(deficit), -jnp.cos(deficit)) - along * (jnp.pi - deficit)
    return twist, across, along


def shortest(turn: Quaternion) -> tuple[Scalar, Scalar, Scalar]:
    """Shortest sweep that makes a rotation.

    Args:
        turn: Attitude at the end relative to that at the start, in sweep axes, (4,).

    Returns:
        Direction of the first axis, rad, curvature, and length, rad, at most sqrt(3) pi.
    """
    turn = jnp.where(turn[0] < 0.0, -turn, turn)
    tilt = jnp.maximum(jnp.hypot(turn[1], turn[2]), LEAST_TILT)
    target_twist = jnp.arctan2(jnp.abs(turn[3]), turn[0])
    lowest = jnp.arctan2(tilt, jnp.hypot(turn[0], turn[3]))

    # the twist falls from pi to 0 as `deficit` grows
    def halve(_, bounds):
        low, high = bounds
        middle = 0.5 * (low + high)
        is_above = _half_phase(middle, tilt)[0] > target_twist
        return jnp.where(is_above, middle, low), jnp.where(is_above, high, middle)

    low, high = jax.lax.fori_loop(0, HALVINGS, halve, (lowest, jnp.pi - lowest))
    deficit = 0.5 * (low + high)
    _, across, along = _half_phase(deficit, tilt)
    half = jnp.pi - deficit
    sense = jnp.where(turn[3] < 0.0, -1.0, 1.0)
    direction = jnp.arctan2(turn[2], turn[1]) - sense * along * half
    return direction, sense * along / across, 2.0 * half * across


def turned(sweep: Sweep, angle: Scalar) -> Quaternion:
    """Attitude after an angle along a sweep, relative to its start, in sweep axes."""
    e = jnp.array([jnp.cos(sweep.direction), jnp.sin(sweep.direction), sweep.curvature])
    back = jnp.array([0.0, 0.0, -sweep.curvature])
    return rotations.product(
        rotations.from_rotation_vector(angle * e), rotations.from_rotation_vector(angle * back)
    )


def rate_axis(sweep: Sweep, angle: Scalar) -> Vector3:
    """Axis of the body rate after an angle along a sweep, a unit vector in sweep axes."""
    heading = sweep.direction + sweep.curvature * angle
    return jnp.array([jnp.cos(heading), jnp.sin(heading), 0.0])


def timed(
    direction: Scalar,
    curvature: Scalar,
    length: Scalar,
    speed_limit: Scalar,
    acceleration_limit: Scalar,
) -> Sweep:
    """Fastest timing of a sweep: the rate rises smoothly, is held, and falls as it rose.

    Args:
        direction: Direction of the first axis, rad, see `Sweep`.
        curvature: Curvature, see `Sweep`.
        length: Total angle, rad.
        speed_limit: Limit of the rate, rad/s.
        acceleration_limit: Limit of the acceleration, along and across the path together, rad/s^2.

    Returns:
        Fastest such sweep within the limits.
    """
    slope = RAMP_SHARE * acceleration_limit / RAMP_PEAK
    bend_speed = jnp.sqrt(acceleration_limit / jnp.maximum(jnp.abs(curvature), 1e-9))
    speed = jnp.minimum(jnp.minimum(speed_limit, bend_speed), jnp.sqrt(slope * length))
    speed = jnp.maximum(speed, 1e-12)
    return Sweep(direction, curvature, length, speed, speed / slope)


def progress(sweep: Sweep, time: Scalar) -> tuple[Scalar, Scalar]:
    """Angle turned, rad, and rate, rad/s, at a time after the start of a sweep, s."""
    up = jnp.clip(time / sweep.ramp, 0.0, 1.0)
    down = jnp.clip((sweep.duration - time) / sweep.ramp, 0.0, 1.0)
    cruise_time = jnp.clip(time - sweep.ramp, 0.0, sweep.duration - 2.0 * sweep.ramp)
    rise = sweep.speed * (sweep.ramp * up**3 * (1.0 - 0.5 * up) + cruise_time)
    fall = sweep.speed * sweep.ramp * (0.5 - down**3 * (1.0 - 0.5 * down))
    rate = sweep.speed * jnp.minimum(up**2 * (3.0 - 2.0 * up), down**2 * (3.0 - 2.0 * down))
    return rise + fall, rate
