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

MAX_SEGMENTS = 500
BAND = 6.0
"""Stribeck speeds beyond which exp(-w²/w_s²) is below 1e-15."""
BAND_STEP = 0.25
"""Largest change of speed in one segment inside the band, in Stribeck speeds."""
RATE_STEP = 0.25
"""Largest segment times the local eigenvalue |dF/dw| / J."""
NEWTON_STEPS = 6


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
    first = wheel.acceleration(speed, current, direction)
    last = wheel.acceleration(speed, current + slope * remaining, direction)
    steepest = jnp.maximum(jnp.abs(first), jnp.abs(last))
    scale = wheel.friction.speed_scale()
    reach = jnp.where(
        jnp.isinf(scale),
        jnp.inf,
        jnp.maximum(jnp.abs(speed) - BAND * scale, 0.0) + BAND_STEP * scale,
    )
    _, bend = jax.jvp(lambda w: wheel.friction.torque(w, direction), (speed,), (1.0,))
    eigenvalue = jnp.abs(bend) / wheel.inertia
    tiny = jnp.finfo(speed.dtype).tiny
    return jnp.minimum(
        reach / jnp.maximum(steepest, tiny), RATE_STEP / jnp.maximum(eigenvalue, tiny)
    )


def _zero_time(wheel: Wheel, speed, current, slope, direction, low, high):
    """Time in [low, high] at which the speed reaches zero, differentiable."""

    def height(time):
        end = _runge_kutta(wheel, speed, current, slope, direction, time)
        steepness = wheel.acceleration(end, current + slope * time, direction)
        return end, jnp.where(steepness == 0.0, -direction, steepness)

    def newton(_, bracket):
        low, high, time = bracket
        end, steepness = height(time)
        above = direction * end > 0.0
        low, high = jnp.where(above, time, low), jnp.where(above, high, time)
        step = time - end / steepness
        # a root at the edge of the bracket is a root: a strict test would bisect away from it
        slack = 1e-12 * (high - low)
        inside = (step >= low - slack) & (step <= high + slack)
        return low, high, jnp.where(inside, step, 0.5 * (low + high))

    _, _, time = jax.lax.fori_loop(0, NEWTON_STEPS, newton, (low, high, 0.5 * (low + high)))
    time = jax.lax.stop_gradient(time)
    end, steepness = height(time)
    return time - end / steepness


def _turn(wheel: Wheel, speed, current, slope, direction, remaining):
    """Turn in one sense until the interval, the segment limit or the speed runs out."""
    limit = jax.lax.stop_gradient(
        _segment_limit(wheel, speed, current, slope, direction, remaining)
    )
    last = limit >= remaining
    duration = jnp.where(last, remaining, limit)
    end = _runge_kutta(wheel, speed, current, slope, direction, duration)

    # speed measured along the sense of rotation, and its slope at both ends
    start_rate = direction * wheel.acceleration(speed, current, direction)
    end_rate = direction * wheel.acceleration(end, current + slope * duration, direction)
    turns = start_rate * end_rate < 0.0
    turning = duration * start_rate / jnp.where(turns, start_rate - end_rate, 1.0)
    past_zero = direction * end <= 0.0
    # a parabola through both ends, at its turning point: does the speed dip below zero?
    lowest = direction * speed + 0.5 * start_rate * turning
    dips = turns & (start_rate < 0.0) & (lowest <= 0.0) & (speed != 0.0)

    def go_on(_):
        return end, duration, last

    def locate(_):
        rises_first = turns & (start_rate > 0.0) & (speed == 0.0)
        low = jnp.where(rises_first, turning, 0.0)
        high = jnp.where(past_zero, duration, turning)
        low, high = jax.lax.stop_gradient((low, high))
        # the parabola that found a dip is only an estimate: the flow itself decides
        deepest = _runge_kutta(wheel, speed, current, slope, direction, high)
        time = _zero_time(wheel, speed, current, slope, direction, low, high)
        stops = (jnp.zeros_like(speed), jnp.minimum(time, remaining), jnp.array(False))
        return jax.tree.map(
            lambda a, b: jnp.where(direction * deepest <= 0.0, a, b), stops, go_on(None)
        )

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
        return (segment.elapsed < duration) & (segment.number < MAX_SEGMENTS)

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
            leaves = (climb != 0.0) & (wait < remaining)
            return (
                jnp.zeros_like(speed),
                jnp.where(leaves, elapsed + wait, duration),
                jnp.where(leaves, rising, 0.0),
            )

        def turn(_):
            # a direction of zero only reaches here when it is not selected
            end, time, finished = _turn(wheel, speed, now, slope, direction, remaining)
            return end, jnp.where(finished, duration, elapsed + time), jnp.zeros_like(direction)

        speed, elapsed, released = jax.lax.cond(holds, rest, turn, None)
        return _Segment(speed, elapsed, released, segment.number + 1)

    start = _Segment(speed, jnp.zeros_like(duration), jnp.zeros_like(speed), jnp.array(0))
    last = jax.lax.while_loop(unfinished, go, start)
    return WheelStep(last.speed, last.elapsed >= duration)
