"""Exact stepping of a wheel with dry friction: sticking, breakaway and crossings at their times.

Between two samples the current is a straight line in time. The interval is cut into segments in
which the wheel either rests or turns in one sense, so that the right-hand side is smooth and a
fourth-order Runge-Kutta step is fourth order. A segment ends where the speed reaches zero (located
on the Runge-Kutta flow itself) or where a rising motor torque breaks the wheel away.

The derivative of a located time comes from the last Newton step: differentiating through it gives
the factor f+/f- by which a sensitivity jumps when the speed passes zero, and no sensitivity at all
once the wheel sticks. Only the search that leads there is hidden from differentiation.
"""

from typing import NamedTuple

from jaxtyping import Array, Bool, Float, Int

from gyrostat._jax import jax, jnp
from gyrostat.friction import Scalar
from gyrostat.wheel.wheel import Wheel

MAX_SEGMENTS = 1000
BAND = 6.0
"""Stribeck speeds beyond which exp(-w²/w_s²) is below 1e-15."""
BAND_STEP = 0.15
"""Largest change of speed in one segment inside a deep band, in Stribeck speeds."""
RATE_STEP = 0.05
"""Largest segment times the local eigenvalue |dF/dw| / J; also bounds how fast that may change."""
NEWTON_STEPS = 3
"""After which a zero is good to 1e-14 of the segment; to 1e-8 where the speed only touches it."""


class WheelStep(NamedTuple):
    """Where one interval ends.

    Attributes:
        speed: rad/s; exactly zero while the wheel rests.
        resolved: False when the interval needed more than `MAX_SEGMENTS` segments.
    """

    speed: Float[Array, ""]
    resolved: Bool[Array, ""]


class _Segment(NamedTuple):
    speed: Float[Array, ""]
    elapsed: Float[Array, ""]
    released: Float[Array, ""]
    """Sense (±1) in which the torque has just reached the breakaway level, else 0."""
    landed: Bool[Array, ""]
    """Whether the speed has just come to zero."""
    number: Int[Array, ""]


@jax.jit  # a function of its own in the trace: traced once, not at every use
def _runge_kutta(wheel: Wheel, speed, current, slope, direction, duration):
    """One classical fourth-order step of the smooth field of one sense of rotation."""

    def rate(time, speed):
        return wheel.acceleration(speed, current + slope * time, direction)

    half = 0.5 * duration
    k1 = rate(0.0, speed)
    k2 = rate(half, speed + half * k1)
    k3 = rate(half, speed + half * k2)
    k4 = rate(duration, speed + duration * k3)
    return speed + duration / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def _segment_limit(wheel: Wheel, speed, current, slope, direction, remaining):
    """Longest segment that resolves the friction curve where the wheel is and where it goes."""
    tiny = jnp.finfo(speed.dtype).tiny
    scale = wheel.friction.speed_scale()
    rate = jnp.abs(wheel.acceleration(speed, current, direction))
    # The error of a step goes with the depth of the bend and with step^4: a shallow bend, as in the
    # paper, is taken in larger steps. Batches, where some lane is always inside, gain most.
    edge = jnp.where(jnp.isinf(scale), 0.0, BAND * scale)
    far = wheel.friction.torque(direction * edge, direction)
    depth = jnp.abs(far - wheel.friction.torque(0.0, direction)) / wheel.inertia
    larger = jnp.sqrt(jnp.sqrt((rate + depth) / jnp.where(depth > 0.0, depth, 1.0)))
    larger = jnp.where(depth > BAND_STEP**4 * (rate + depth), larger, 1.0 / BAND_STEP)
    reach = jnp.maximum(jnp.abs(speed) - BAND * scale, 0.0) + BAND_STEP * larger * scale
    rate_change = jnp.abs(wheel.motor_constant * slope / wheel.inertia)
    # root of rate t + rate_change t²/2 = reach, in a form that allows an infinite reach
    frequency = rate / reach
    frequency += jnp.sqrt(frequency**2 + 2.0 * rate_change / reach)
    limit = jnp.minimum(remaining, 2.0 / jnp.maximum(frequency, tiny))

    def eigenvalue(speed):
        bend = jax.jvp(lambda w: wheel.friction.torque(w, direction), (speed,), (1.0,))[1]
        return bend / wheel.inertia

    here, curvature = jax.jvp(eigenvalue, (speed,), (1.0,))
    limit = jnp.minimum(limit, RATE_STEP / jnp.maximum(jnp.abs(here), tiny))
    # the curve is flat at zero speed: what counts there is how steep it is a segment later
    steepening = jnp.abs(curvature) * (rate + rate_change * limit)
    return jnp.minimum(limit, jnp.sqrt(RATE_STEP / jnp.maximum(steepening, tiny)))


def _zero_time(wheel: Wheel, speed, current, slope, direction, low, guess, high):
    """Time in [low, high] at which the speed reaches zero, differentiable."""

    def newton(wheel, speed, current, slope, time):
        end = _runge_kutta(wheel, speed, current, slope, direction, time)
        rate = jax.lax.stop_gradient(wheel.acceleration(end, current + slope * time, direction))
        return end, time - end / jnp.where(rate == 0.0, -direction, rate)

    frozen = jax.lax.stop_gradient((wheel, speed, current, slope))

    def narrow(_, bracket):
        low, high, time = bracket
        end, step = newton(*frozen, time)
        above = direction * end > 0.0
        low, high = jnp.where(above, time, low), jnp.where(above, high, time)
        # a root at the edge of the bracket is a root: a strict test would bisect away from it
        slack = 1e-12 * (high - low)
        inside = (step >= low - slack) & (step <= high + slack)
        return low, high, jnp.where(inside, step, 0.5 * (low + high))

    _, _, time = jax.lax.fori_loop(0, NEWTON_STEPS, narrow, (low, high, guess))
    _, time = newton(wheel, speed, current, slope, time)
    return time


def _falls_through_zero(height, start_rate, end_rate, length):
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


def _turn(wheel: Wheel, speed, current, slope, direction, remaining):
    """Turn in one sense until the interval, the segment limit or the speed runs out.

    Returns:
        Speed at the end; time taken; whether this ends the interval; whether the speed ran out.
    """
    frozen = jax.lax.stop_gradient((wheel, speed, current, slope, direction))
    limit = _segment_limit(*frozen, jax.lax.stop_gradient(remaining))
    last = limit >= remaining
    duration = jnp.where(last, remaining, limit)
    end = _runge_kutta(wheel, speed, current, slope, direction, duration)

    # what happens is decided on values alone; heights and rates are along the sense of rotation
    length, height, end_height = jax.lax.stop_gradient(
        (duration, direction * speed, direction * end)
    )
    start_rate = direction * wheel.acceleration(speed, current, direction)
    end_rate = direction * wheel.acceleration(end, current + slope * duration, direction)
    start_rate, end_rate = jax.lax.stop_gradient((start_rate, end_rate))
    turns = start_rate * end_rate < 0.0
    turning = length * start_rate / jnp.where(turns, start_rate - end_rate, 1.0)
    # a wheel that starts at zero comes to zero only after it has risen
    from_zero = height == 0.0
    rises = turns & (start_rate > 0.0)
    past_zero = (end_height <= 0.0) & (~from_zero | rises)
    # a parabola through both ends, at its turning point: does the speed dip below zero?
    lowest = height + 0.5 * start_rate * turning
    dips = turns & (start_rate < 0.0) & (lowest <= 0.0) & ~from_zero

    def go_on(_):
        # just at the breakaway level, rounding may turn the wheel back: it stays at zero
        stays = from_zero & ~rises & (end_height < 0.0)
        return jnp.where(stays, 0.0, end), duration, last, jnp.array(False)

    def locate(_):
        low = jnp.where(rises & from_zero, turning, 0.0)
        high = jnp.where(past_zero, length, turning)
        guess = jnp.clip(_falls_through_zero(height, start_rate, end_rate, length), low, high)
        time = _zero_time(wheel, speed, current, slope, direction, low, guess, high)
        # where the speed only touches zero, the last Newton step may lead anywhere
        time += jax.lax.stop_gradient(jnp.clip(time, 0.0, remaining) - time)
        # the parabola that found a dip is only an estimate: the flow itself decides
        deepest = direction * _runge_kutta(*frozen, high)
        stops = (jnp.zeros_like(speed), time, jnp.array(False), jnp.array(True))
        return jax.tree.map(lambda a, b: jnp.where(deepest <= 0.0, a, b), stops, go_on(None))

    return jax.lax.cond(past_zero | dips, locate, go_on, None)


def advance(
    wheel: Wheel, speed: Scalar, current: Scalar, slope: Scalar, duration: Scalar
) -> WheelStep:
    """Carry a wheel over one interval in which its current is a straight line in time.

    Args:
        wheel: the wheel.
        speed: at the start, rad/s; exactly zero is at rest.
        current: at the start, A.
        slope: of the current, A/s; zero for a held current.
        duration: s.

    Returns:
        The speed at the end. Differentiable in forward mode in every argument and parameter.
    """
    speed = jnp.asarray(speed, dtype=float)
    duration = jnp.asarray(duration, dtype=float)

    def unfinished(segment: _Segment):
        # a wheel that comes to zero at the very end has still to stick or to go through, in no
        # time: its speed is zero either way, but not the derivative
        more = (segment.elapsed < duration) | segment.landed
        return more & (segment.number < MAX_SEGMENTS)

    def go(segment: _Segment) -> _Segment:
        speed, elapsed = segment.speed, segment.elapsed
        remaining = duration - elapsed
        now = current + slope * elapsed
        torque = wheel.motor_constant * now
        at_rest = speed == 0.0
        free = jnp.where(segment.released != 0.0, segment.released, jnp.sign(torque))
        direction = jnp.where(at_rest, free, jnp.sign(speed))
        holds = (
            at_rest
            & (segment.released == 0.0)
            & (jnp.abs(torque) <= wheel.friction.breakaway_torque(free))
        ) | (direction == 0.0)

        def rest(_):
            rising = jnp.sign(wheel.motor_constant * slope)
            level = rising * wheel.friction.breakaway_torque(rising)
            climb = wheel.motor_constant * slope
            wait = (level - torque) / jnp.where(climb == 0.0, 1.0, climb)
            # the level is passed already where a fit tries a static torque below zero
            wait = jnp.where(wait < 0.0, 0.0, wait)
            leaves = (climb != 0.0) & (wait < remaining)
            return (
                jnp.zeros_like(speed),
                jnp.where(leaves, elapsed + wait, duration),
                jnp.where(leaves, rising, 0.0),
                jnp.array(False),
            )

        def turn(_):
            # a direction of zero only reaches here when it is not selected
            end, time, finished, landed = _turn(wheel, speed, now, slope, direction, remaining)
            reached = jnp.where(finished, duration, elapsed + time)
            return end, reached, jnp.zeros_like(direction), landed

        speed, elapsed, released, landed = jax.lax.cond(holds, rest, turn, None)
        return _Segment(speed, elapsed, released, landed, segment.number + 1)

    zero = jnp.zeros_like(speed)
    start = _Segment(speed, jnp.zeros_like(duration), zero, jnp.array(False), jnp.array(0))
    last = jax.lax.while_loop(unfinished, go, start)
    return WheelStep(last.speed, last.elapsed >= duration)
