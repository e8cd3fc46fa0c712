"""Event location shared by the stepping of one wheel and of several.

Between two events every wheel rests or turns in one sense, so that the right-hand side is smooth:
a segment is one Runge-Kutta step of it, short enough to resolve the friction curve, and its end may
be moved to the time at which something runs out.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from gyrostat.core.jax64 import jax, jnp

MAX_SEGMENTS = 1000
BAND = 6.0
"""Stribeck speeds beyond which exp(-w²/w_s²) is below 1e-15."""
BAND_STEP = 0.15
"""Largest change of speed in one segment inside a deep band, in Stribeck speeds."""
RATE_STEP = 0.05
"""Largest segment times the local eigenvalue |dF/dw| / J; also bounds how fast that may change."""
TURN_STEP = 0.02
"""rad: largest turn of what carries the wheels in one segment; its error is below 1e-12."""
NEWTON_STEPS = 3
"""After which a zero is good to 1e-14 of the segment; to 1e-8 where the speed only touches it."""


class Segment(NamedTuple):
    """Where a segment begins.

    Attributes:
        motion: of the wheels and their carrier.
        elapsed: since the start of the interval, s.
        released: sense (±1) in which a load has just reached the breakaway level, else 0, one for
            each wheel.
        landed: whether a speed has just come to zero.
        number: of segments before.
    """

    motion: Any
    elapsed: Any
    released: Any
    landed: Any
    number: Any


def through_segments(go: Callable[[Segment, Any], Segment], motion: Any, duration: Any) -> Segment:
    """Step from segment to segment to the end of an interval, or for `MAX_SEGMENTS`.

    Args:
        go: (segment, duration) -> the next one.
        motion: at the start.
        duration: of the interval, s.

    Returns:
        Where the last segment ends.
    """
    motion = jax.tree.map(lambda y: jnp.asarray(y, dtype=float), motion)
    duration = jnp.asarray(duration, dtype=float)

    def unfinished(segment: Segment):
        # a wheel that comes to zero at the very end has still to stick or to go through, in no
        # time: its speed is zero either way, but not the derivative
        more = (segment.elapsed < duration) | segment.landed
        return more & (segment.number < MAX_SEGMENTS)

    nothing = jnp.zeros_like(motion.speed)
    start = Segment(motion, jnp.zeros_like(duration), nothing, jnp.array(False), jnp.array(0))
    return jax.lax.while_loop(unfinished, lambda segment: go(segment, duration), start)


def steepness(friction: Any, inertia, speed, direction):
    """First and second derivative of a friction torque by speed, over the inertia that feels it.

    Args:
        friction: static; all arguments may be those of several wheels.
        inertia: kg·m².
        speed: rad/s.
        direction: sense of rotation, ±1.
    """
    ones = jnp.ones_like(speed)

    def eigenvalue(speed):
        slope = jax.jvp(lambda w: friction.torque(w, direction), (speed,), (ones,))[1]
        return slope / inertia

    return jax.jvp(eigenvalue, (speed,), (ones,))


def is_resolved(friction: Any, steep, speed, rate, rate_change, duration):
    """Whether a segment surely resolves a friction curve: `friction_limit` is no shorter.

    It asks for no more than a curve with the deepest bend would.

    Args:
        friction: static; all arguments may be those of several wheels.
        steep: its `steepness`.
        speed: rad/s.
        rate: absolute value of the speed's derivative in time, rad/s².
        rate_change: absolute value of its second one but for the friction's share, rad/s³.
        duration: of the segment, s.
    """
    scale = friction.speed_scale()
    reach = jnp.maximum(jnp.abs(speed) - BAND * scale, 0.0) + BAND_STEP * scale
    slope, curvature = steep
    gained = rate_change * duration
    return (
        (duration * (rate + 0.5 * gained) <= reach)
        & (duration * jnp.abs(slope) <= RATE_STEP)
        & (duration**2 * jnp.abs(curvature) * (rate + gained) <= RATE_STEP)
    )


def friction_limit(friction: Any, inertia, speed, direction, rate, rate_change, remaining):
    """Longest segment that resolves a friction curve where a wheel is and where it goes, s.

    Args:
        friction: static; all arguments may be those of several wheels.
        inertia: that the friction torque feels, kg·m².
        speed: rad/s.
        direction: sense of rotation, ±1.
        rate: absolute value of the speed's derivative in time, rad/s².
        rate_change: absolute value of its second one but for the friction's share, rad/s³.
        remaining: s; nothing longer is asked for.
    """
    tiny = jnp.finfo(speed.dtype).tiny
    scale = friction.speed_scale()
    # The error of a step goes with the depth of the bend and with step^4: a shallow bend, as in the
    # paper, is taken in larger steps. Batches, where some lane is always inside, gain most.
    edge = jnp.where(jnp.isinf(scale), 0.0, BAND * scale)
    far = friction.torque(direction * edge, direction)
    depth = jnp.abs(far - friction.torque(0.0, direction)) / inertia
    larger = jnp.sqrt(jnp.sqrt((rate + depth) / jnp.where(depth > 0.0, depth, 1.0)))
    larger = jnp.where(depth > BAND_STEP**4 * (rate + depth), larger, 1.0 / BAND_STEP)
    reach = jnp.maximum(jnp.abs(speed) - BAND * scale, 0.0) + BAND_STEP * larger * scale
    # root of rate t + rate_change t²/2 = reach, in a form that allows an infinite reach
    frequency = rate / reach
    frequency += jnp.sqrt(frequency**2 + 2.0 * rate_change / reach)
    limit = jnp.minimum(remaining, 2.0 / jnp.maximum(frequency, tiny))
    here, curvature = steepness(friction, inertia, speed, direction)
    limit = jnp.minimum(limit, RATE_STEP / jnp.maximum(jnp.abs(here), tiny))
    # the curve is flat at zero speed: what counts there is how steep it is a segment later
    steepening = jnp.abs(curvature) * (rate + rate_change * limit)
    return jnp.minimum(limit, jnp.sqrt(RATE_STEP / jnp.maximum(steepening, tiny)))


def narrowed(bracket, height, rate):
    """A bracket of the time at which a height above zero runs out, after one step of Newton.

    Args:
        bracket: a duration, s, at which the height is not yet below zero; one at which it is; and
            the one in between that was tried.
        height: there.
        rate: of the height there.
    """
    low, high, time = bracket
    step = time - height / jnp.where(rate == 0.0, -1.0, rate)
    above = height > 0.0
    low, high = jnp.where(above, time, low), jnp.where(above, high, time)
    # a root at the edge of the bracket is a root: a strict test would bisect away from it
    slack = 1e-12 * (high - low)
    inside = (step >= low - slack) & (step <= high + slack)
    return low, high, jnp.where(inside, step, 0.5 * (low + high))


def within(time, latest):
    """The time, kept within 0 and `latest`: at a speed that only touches zero, Newton strays."""
    return time + jax.lax.stop_gradient(jnp.clip(time, 0.0, latest) - time)


def falls_through_zero(height, start_rate, end_rate, length):
    """Time at which the parabola with this height, rate and rate at its end falls through zero."""
    bend = (end_rate - start_rate) / jnp.where(length > 0.0, length, 1.0)
    root = jnp.sqrt(jnp.maximum(start_rate**2 - 2.0 * bend * height, 0.0))
    falls_at_once = start_rate < 0.0
    # the same root twice: each form where its terms have one sign
    return jnp.where(
        falls_at_once,
        2.0 * height / jnp.where(falls_at_once, root - start_rate, 1.0),
        (start_rate + root) / jnp.where(bend < 0.0, -bend, 1.0),
    )


class Ends(NamedTuple):
    """How a mode of motion may end in a segment, told by its height at both ends.

    Attributes:
        turning: time at which a parabola through both ends turns, s.
        from_zero: a wheel that turns and starts at zero: it ends only after it has risen.
        rises: whether the height first grows and then falls.
        past_zero: whether the height has run out at the end.
        dips: whether it has run out in between, if the parabola is right.
    """

    turning: Any
    from_zero: Any
    rises: Any
    past_zero: Any
    dips: Any


def ends(held, first, start_rate, final, end_rate, length) -> Ends:
    """Judge what is left of a mode at the start and at the end of a segment.

    Args:
        held: whether the wheel rests; all arguments may be those of several wheels.
        first: height at the start.
        start_rate: its derivative in time there.
        final: height at the end.
        end_rate: its derivative in time there.
        length: of the segment, s.
    """
    turns = start_rate * end_rate < 0.0
    turning = length * start_rate / jnp.where(turns, start_rate - end_rate, 1.0)
    from_zero = ~held & (first == 0.0)
    rises = turns & (start_rate > 0.0)
    past_zero = (final <= 0.0) & (~from_zero | rises)
    lowest = first + 0.5 * start_rate * turning
    dips = turns & (start_rate < 0.0) & (lowest <= 0.0) & ~from_zero & ~past_zero
    return Ends(turning, from_zero, rises, past_zero, dips)
