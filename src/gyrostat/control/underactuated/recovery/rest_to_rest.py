"""Rest-to-rest turns of a body that can only turn about axes in one plane.

Two wheels without momentum leave the body rate orthogonal to one axis z of the body, z along J n
with n the normal of the two wheel axes: the rolling of a ball without twist. Every attitude is in
reach all the same. The shortest turn is one sweep whose axis goes round in the plane at a constant
rate per angle turned, because the extremals of that problem are

    q(s) = exp((e + k z) s / 2) exp(-k z s / 2),

with s the angle turned so far, e the axis at the start and k the curvature: the limit of a sequence
of ever shorter turns about axes of the plane. With k = 0 it is one plain turn; a twist about z
alone is one closed loop. V. Jurdjevic, "Geometric Control Theory", chapters 12 and 14, has the
extremals; end point, timing and solution are worked out here.

Attitudes and axes here are in sweep axes, whose third is z. Closed forms and loops of fixed counts
only; one turn for each call, `vmap` gives many.
"""

from typing import NamedTuple

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp

HALVINGS = 64
"""Of the interval that the half angle of a sweep lies in: to rounding."""
LEAST_TILT = 1e-10
"""Sine of half a turn across z, below which a turn is one about z alone."""
RAMP_PEAK = 1.5
"""Largest slope of the ramp x^2 (3 - 2 x)."""
RAMP_SHARE = 0.85
"""Of the acceleration limit that speeding up takes, so that what bends the way has room beside it:
(RAMP_SHARE slope / RAMP_PEAK)^2 + ramp^4 stays below 1."""


class Sweep(NamedTuple):
    """A turn from rest to rest about an axis that goes round in a plane.

    Attributes:
        direction: of the first axis in the plane, from x towards y, rad.
        curvature: angle that the axis goes round for each angle turned, 1.
        length: angle turned in all, rad.
        speed: largest rate, rad/s.
        ramp: time in which that rate is reached, and in which it is given up again, s.
    """

    direction: Scalar
    curvature: Scalar
    length: Scalar
    speed: Scalar
    ramp: Scalar

    @property
    def duration(self) -> Scalar:
        """From rest to rest, s; zero for a sweep of no length."""
        return self.length / self.speed + self.ramp


def _half_phase(rest: Scalar, tilt: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """What a sweep of half angle pi - `rest` twists about z, and its shares across and along z."""
    across = tilt / jnp.sin(rest)
    along = jnp.sqrt(jnp.maximum(1.0 - across**2, 0.0))
    twist = jnp.arctan2(along * jnp.sin(rest), -jnp.cos(rest)) - along * (jnp.pi - rest)
    return twist, across, along


def shortest(turn: Quaternion) -> tuple[Scalar, Scalar, Scalar]:
    """The shortest sweep that makes a turn.

    Args:
        turn: attitude at the end with respect to that at the start, in sweep axes.

    Returns:
        Direction of its first axis, rad, its curvature and its length, rad, at most sqrt(3) pi.
    """
    turn = jnp.where(turn[0] < 0.0, -turn, turn)
    tilt = jnp.maximum(jnp.hypot(turn[1], turn[2]), LEAST_TILT)
    wanted = jnp.arctan2(jnp.abs(turn[3]), turn[0])
    least = jnp.arctan2(tilt, jnp.hypot(turn[0], turn[3]))

    # the twist falls from pi to 0 while the rest of the half angle grows
    def halve(_, bounds):
        low, high = bounds
        middle = 0.5 * (low + high)
        more = _half_phase(middle, tilt)[0] > wanted
        return jnp.where(more, middle, low), jnp.where(more, high, middle)

    low, high = jax.lax.fori_loop(0, HALVINGS, halve, (least, jnp.pi - least))
    rest = 0.5 * (low + high)
    _, across, along = _half_phase(rest, tilt)
    half = jnp.pi - rest
    sense = jnp.where(turn[3] < 0.0, -1.0, 1.0)
    direction = jnp.arctan2(turn[2], turn[1]) - sense * along * half
    return direction, sense * along / across, 2.0 * half * across


def turned(sweep: Sweep, angle: Scalar) -> Quaternion:
    """Attitude after an angle turned along a sweep, with respect to its start, in sweep axes."""
    e = jnp.array([jnp.cos(sweep.direction), jnp.sin(sweep.direction), sweep.curvature])
    back = jnp.array([0.0, 0.0, -sweep.curvature])
    return rotations.product(
        rotations.from_rotation_vector(angle * e), rotations.from_rotation_vector(angle * back)
    )


def rate_axis(sweep: Sweep, angle: Scalar) -> Vector3:
    """Axis of the rate after an angle turned, a unit vector in sweep axes."""
    heading = sweep.direction + sweep.curvature * angle
    return jnp.array([jnp.cos(heading), jnp.sin(heading), 0.0])


def timed(
    direction: Scalar,
    curvature: Scalar,
    length: Scalar,
    speed_limit: Scalar,
    acceleration_limit: Scalar,
) -> Sweep:
    """Give a sweep its time: the rate rises smoothly, is held and falls as it rose.

    Args:
        direction: see `Sweep`.
        curvature: see `Sweep`.
        length: rad.
        speed_limit: of the rate, rad/s.
        acceleration_limit: of the rate's change along and across the way together, rad/s^2.

    Returns:
        The fastest such sweep within the limits.
    """
    slope = RAMP_SHARE * acceleration_limit / RAMP_PEAK
    bent = jnp.sqrt(acceleration_limit / jnp.maximum(jnp.abs(curvature), 1e-9))
    speed = jnp.minimum(jnp.minimum(speed_limit, bent), jnp.sqrt(slope * length))
    speed = jnp.maximum(speed, 1e-12)
    return Sweep(direction, curvature, length, speed, speed / slope)


def progress(sweep: Sweep, time: Scalar) -> tuple[Scalar, Scalar]:
    """Angle turned, rad, and rate, rad/s, at a time after the start of a sweep, s."""
    up = jnp.clip(time / sweep.ramp, 0.0, 1.0)
    down = jnp.clip((sweep.duration - time) / sweep.ramp, 0.0, 1.0)
    held = jnp.clip(time - sweep.ramp, 0.0, sweep.duration - 2.0 * sweep.ramp)
    before = sweep.speed * (sweep.ramp * up**3 * (1.0 - 0.5 * up) + held)
    after = sweep.speed * sweep.ramp * (0.5 - down**3 * (1.0 - 0.5 * down))
    rate = sweep.speed * jnp.minimum(up**2 * (3.0 - 2.0 * up), down**2 * (3.0 - 2.0 * down))
    return before + after, rate
