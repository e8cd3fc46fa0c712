"""Event location for the stepping of one wheel and of several wheels.

Between two events every wheel rests or turns in one direction, so that the right-hand side is
smooth. A segment is one Runge-Kutta step, short enough to resolve the friction curve. An event ends
a segment early: a turning wheel reaches zero speed, or a resting wheel its breakaway torque. The
event function (also called height) of a wheel is positive before its event and zero at the event.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from gyrostat.core.jax64 import jax, jnp

MAX_SEGMENTS = 1000
BAND = 6.0
"""Speed, in Stribeck speeds, above which exp(-w²/w_s²) is below 1e-15."""
BAND_STEP = 0.15
"""Largest change of speed in one segment inside a deep band, in Stribeck speeds."""
RATE_STEP = 0.05
"""Largest segment times the local eigenvalue |dF/dw| / J; also bounds the change of that
product."""
TURN_STEP = 0.02
"""Largest rotation of the carrier in one segment, rad; the resulting error is below 1e-12."""
NEWTON_STEPS = 3
"""Number of Newton steps; a zero is then accurate to 1e-14 of the segment, a double zero to
1e-8."""


class Segment(NamedTuple):
    """State at the start of a segment.

    Attributes:
        motion: State of the wheels and their carrier.
        elapsed: Time since the start of the interval, s.
        released: Direction (±1) in which a load has just reached the breakaway torque, else 0, one
            for each wheel.
        landed: Whether a speed has just reached zero.
        number: Number of segments so far.
    """

    motion: Any
    elapsed: Any
    released: Any
    landed: Any
    number: Any


def through_segments(go: Callable[[Segment, Any], Segment], motion: Any, duration: Any) -> Segment:
    """Step from segment to segment to the end of an interval, with at most `MAX_SEGMENTS`.

    Args:
        go: Function (segment, duration) -> next segment.
        motion: State at the start.
        duration: Length of the interval, s.

    Returns:
        State at the end of the last segment.
    """
    motion = jax.tree.map(lambda y: jnp.asarray(y, dtype=float), motion)
    duration = jnp.asarray(duration, dtype=float)

    def unfinished(segment: Segment):
        # a wheel that reaches zero exactly at the end needs one more segment of zero length, in
        # which it sticks or crosses: the speed is zero in both cases, but not the derivative
        goes_on = (segment.elapsed < duration) | segment.landed
        return goes_on & (segment.number < MAX_SEGMENTS)

    zeros = jnp.zeros_like(motion.speed)
    start = Segment(motion, jnp.zeros_like(duration), zeros, jnp.array(False), jnp.array(0))
    return jax.lax.while_loop(unfinished, lambda segment: go(segment, duration), start)


def steepness(friction: Any, inertia, speed, direction):
    """First and second derivative of a friction torque by speed, over the effective inertia.

    Args:
        friction: Static friction model; all arguments may be those of several wheels.
        inertia: Effective inertia, kg·m².
        speed: Wheel speed, rad/s.
        direction: Direction of rotation, ±1.
    """
    ones = jnp.ones_like(speed)

    def eigenvalue(speed):
        slope = jax.jvp(lambda w: friction.torque(w, direction), (speed,), (ones,))[1]
        return slope / inertia

    return jax.jvp(eigenvalue, (speed,), (ones,))


def is_resolved(friction: Any, steep, speed, rate, rate_change, duration):
    """Whether a segment certainly resolves a friction curve, so `friction_limit` is no shorter.

    The test is conservative: it assumes a curve with the deepest bend.

    Args:
        friction: Static friction model; all arguments may be those of several wheels.
        steep: Result of `steepness`.
        speed: Wheel speed, rad/s.
        rate: Absolute acceleration of the wheel, rad/s².
        rate_change: Absolute time derivative of the acceleration, without the part of friction,
            rad/s³.
        duration: Length of the segment, s.
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
    """Longest segment that resolves the friction curve at the speed of a wheel and ahead of it, s.

    Args:
        friction: Static friction model; all arguments may be those of several wheels.
        inertia: Effective inertia for the friction torque, kg·m².
        speed: Wheel speed, rad/s.
        direction: Direction of rotation, ±1.
        rate: Absolute acceleration of the wheel, rad/s².
        rate_change: Absolute time derivative of the acceleration, without the part of friction,
            rad/s³.
        remaining: Remaining time, s; an upper bound of the result.
    """
    tiny = jnp.finfo(speed.dtype).tiny
    scale = friction.speed_scale()
    # The error of a step is proportional to the depth of the bend and to step^4. A shallow bend,
    # as in the paper, allows larger steps, mainly in a batch, where some lane is always inside.
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
    slope, curvature = steepness(friction, inertia, speed, direction)
    limit = jnp.minimum(limit, RATE_STEP / jnp.maximum(jnp.abs(slope), tiny))
    # the curve is flat at zero speed, so its slope one segment later is also tested
    steepening = jnp.abs(curvature) * (rate + rate_change * limit)
    return jnp.minimum(limit, jnp.sqrt(RATE_STEP / jnp.maximum(steepening, tiny)))


def narrowed(bracket, height, rate):
    """Bracket of the time at which an event function reaches zero, after one Newton step.

    Args:
        bracket: Duration, s, at which the event function is not yet negative; one at which it is;
            and the one in between that was tried.
        height: Event function at the tried duration.
        rate: Its time derivative there.
    """
    low, high, time = bracket
    step = time - height / jnp.where(rate == 0.0, -1.0, rate)
    above = height > 0.0
    low, high = jnp.where(above, time, low), jnp.where(above, high, time)
    # a root at the edge of the bracket is accepted: a strict test would bisect away from it
    slack = 1e-12 * (high - low)
    inside = (step >= low - slack) & (step <= high + slack)
    return low, high, jnp.where(inside, step, 0.5 * (low + high))


def within(time, latest):
    """Time limited to 0 to `latest`, since Newton steps diverge where a speed only touches zero."""
    return time + jax.lax.stop_gradient(jnp.clip(time, 0.0, latest) - time)


def _bend_and_root(height, start_rate, end_rate, length):
    """Second derivative of a parabola, and the root in the times at which it is zero."""
    bend = (end_rate - start_rate) / jnp.where(length > 0.0, length, 1.0)
    return bend, jnp.sqrt(jnp.maximum(start_rate**2 - 2.0 * bend * height, 0.0))


def falls_at_once(height, start_rate, end_rate, length):
    """Time at which a parabola of given height that falls from the start is zero, s."""
    _, root = _bend_and_root(height, start_rate, end_rate, length)
    return 2.0 * height / (root - start_rate)


def falls_through_zero(height, start_rate, end_rate, length):
    """Time at which a falling parabola of given height, initial and final rate is zero, s."""
    bend, root = _bend_and_root(height, start_rate, end_rate, length)
    falls = start_rate < 0.0
    # two forms of the same root, each used where its terms have the same sign
    return jnp.where(
        falls,
        2.0 * height / jnp.where(falls, root - start_rate, 1.0),
        (start_rate + root) / jnp.where(bend < 0.0, -bend, 1.0),
    )


class Ends(NamedTuple):
    """Possible ends of a mode of motion in a segment, from its event function at both ends.

    Attributes:
        turning: Time at which a parabola through both ends has its extremum, s.
        from_zero: Whether a turning wheel starts at zero speed; its mode ends only after a rise.
        rises: Whether the event function first grows and then falls.
        past_zero: Whether the event function is zero or negative at the end.
        dips: Whether it reaches zero in between, according to the parabola.
    """

    turning: Any
    from_zero: Any
    rises: Any
    past_zero: Any
    dips: Any


def ends(held, first, start_rate, final, end_rate, length) -> Ends:
    """Find possible ends of a mode from its event function at both ends of a segment.

    Args:
        held: Whether the wheel rests; all arguments may be those of several wheels.
        first: Event function at the start.
        start_rate: Its time derivative at the start.
        final: Event function at the end.
        end_rate: Its time derivative at the end.
        length: Length of the segment, s.
    """
    turns = start_rate * end_rate < 0.0
    turning = length * start_rate / jnp.where(turns, start_rate - end_rate, 1.0)
    from_zero = ~held & (first == 0.0)
    rises = turns & (start_rate > 0.0)
    past_zero = (final <= 0.0) & (~from_zero | rises)
    lowest = first + 0.5 * start_rate * turning
    dips = turns & (start_rate < 0.0) & (lowest <= 0.0) & ~from_zero & ~past_zero
    return Ends(turning, from_zero, rises, past_zero, dips)
