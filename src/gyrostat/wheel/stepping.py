"""Exact stepping of a wheel with dry friction, with sticking, breakaway and crossings located.

Over one interval the drive is smooth. The interval is divided into segments in which the wheel
either rests or turns in one direction. The right-hand side is then smooth, so that a fourth-order
Runge-Kutta step is fourth order. A segment ends where the speed reaches zero, or where the load on
a resting wheel reaches its breakaway torque. Both events are located on the Runge-Kutta flow
itself.

The derivative of an event time comes from the last Newton step. Differentiation through this step
gives the factor f+/f- by which a sensitivity jumps when the speed crosses zero, and zero
sensitivity once the wheel sticks. Only the search before it is excluded from differentiation.
"""

from typing import NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.bearing_equation import BearingEquation, Motion
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.segment import (
    NEWTON_STEPS,
    Segment,
    ends,
    falls_at_once,
    falls_through_zero,
    friction_limit,
    narrowed,
    through_segments,
    within,
)


def _step(rate, motion: Motion, start, duration) -> Motion:
    """Classical fourth-order Runge-Kutta step with the time derivative rate(motion, time)."""

    def ahead(k, share):
        return jax.tree.map(lambda y, slope: y + share * slope, motion, k)

    half = 0.5 * duration
    k1 = rate(motion, start)
    k2 = rate(ahead(k1, half), start + half)
    k3 = rate(ahead(k2, half), start + half)
    k4 = rate(ahead(k3, duration), start + duration)
    return jax.tree.map(
        lambda y, a, b, c, d: y + duration / 6.0 * (a + 2.0 * b + 2.0 * c + d),
        motion,
        k1,
        k2,
        k3,
        k4,
    )


@jax.jit  # a separate function in the trace: traced once, not at every use
def _runge_kutta(contact: BearingEquation, motion: Motion, direction, start, duration) -> Motion:
    """Runge-Kutta step in one mode of motion."""
    return _step(lambda y, time: contact.rate(y, direction, time), motion, start, duration)


@jax.jit
def _turn(contact: BearingEquation, motion: Motion, direction, start, duration) -> Motion:
    """Runge-Kutta step of a wheel that turns."""
    return _step(lambda y, time: contact.turning_rate(y, direction, time), motion, start, duration)


@jax.jit
def _height(contact: BearingEquation, motion: Motion, direction, rising, time):
    """Event function of a mode of motion, and its time derivative.

    For a turning wheel it is the speed in its direction. For a wheel at rest it is the breakaway
    torque minus the load, in the direction `rising` in which the load grows.
    """
    rate = contact.rate(motion, direction, time)
    along = (rate.carrier, jnp.ones_like(time))
    load, change = jax.jvp(contact.load, (motion.carrier, time), along)
    lacks = contact.friction.breakaway_torque(rising) - rising * load
    held = direction == 0.0
    return (
        jnp.where(held, jnp.where(rising == 0.0, 1.0, lacks), direction * motion.speed),
        jnp.where(held, -rising * change, direction * rate.speed),
    )


@jax.jit
def _segment_limit(contact: BearingEquation, motion: Motion, direction, start, remaining):
    """Longest segment that resolves the friction curve and the drive."""
    whole_rate = contact.rate(motion, direction, start)
    along = (whole_rate.carrier, jnp.ones_like(start))
    load_change = jax.jvp(contact.load, (motion.carrier, start), along)[1]
    inertia = contact.inertia()
    limit = friction_limit(
        contact.friction,
        inertia,
        motion.speed,
        direction,
        jnp.abs(whole_rate.speed),
        jnp.abs(load_change) / inertia,
        remaining,
    )
    limit = jnp.where(direction == 0.0, remaining, limit)
    return jnp.minimum(limit, contact.longest_segment(start))


def _event_time(flow, height, low, guess, high, latest):
    """Time in [low, high] at which an event function reaches zero, differentiable.

    Args:
        flow: Function duration -> state.
        height: Function (state, duration) -> event function and its time derivative.
        low: Duration, s, at which the event function is not yet negative.
        guess: First duration tried, s.
        high: Duration, s, at which the event function is negative.
        latest: Upper limit of the result, s.
    """

    def narrow(_, bracket):
        time = bracket[2]
        return narrowed(bracket, *jax.lax.stop_gradient(height(flow(time), time)))

    bracket = jax.lax.fori_loop(0, NEWTON_STEPS, narrow, (low, high, guess))
    time = jax.lax.stop_gradient(bracket)[2]
    end, rate = height(flow(time), time)
    rate = jax.lax.stop_gradient(rate)
    return within(time - end / jnp.where(rate == 0.0, -1.0, rate), latest)


class _Travel(NamedTuple):
    motion: Motion
    time: Float[Array, ""]
    finished: Bool[Array, ""]
    """Whether this ends the interval."""
    ran_out: Bool[Array, ""]
    """Whether an event ended the mode: a turning wheel reached zero, or a held one breaks away."""


def _longest(contact: BearingEquation, motion: Motion, direction, start, remaining):
    """Duration of a segment without events, and whether it ends the interval."""
    frozen = jax.lax.stop_gradient((contact, motion, direction, start))
    limit = _segment_limit(*frozen, jax.lax.stop_gradient(remaining))
    last = limit >= remaining
    return jnp.where(last, remaining, limit), last


@jax.jit
def _speed_along(contact: BearingEquation, motion: Motion, direction, time):
    """Speed of a turning wheel in its direction, and its time derivative."""
    rate = contact.turning_rate(motion, direction, time)
    return direction * motion.speed, direction * rate.speed


def _travel_steadily(contact: BearingEquation, motion: Motion, direction, start, remaining):
    """Move in one mode under a constant load; see `_travel`.

    The only event is that a turning wheel reaches zero speed, by the end of the segment. A wheel
    that is held, of direction 0, has none.
    """
    duration, last = _longest(contact, motion, direction, start, remaining)

    def flow(duration):
        return _turn(contact, motion, direction, start, duration)

    def height(motion, duration):
        return _speed_along(contact, motion, direction, start + duration)

    end, length = flow(duration), jax.lax.stop_gradient(duration)
    first, start_rate = jax.lax.stop_gradient(height(motion, jnp.zeros_like(duration)))
    final, end_rate = jax.lax.stop_gradient(height(end, duration))

    def go_on(_):
        speed = jnp.where(direction == 0.0, motion.speed, end.speed)
        # exactly at the breakaway torque, rounding may turn the wheel back: it stays at zero
        speed = jnp.where(final < 0.0, 0.0, speed)
        return _Travel(end._replace(speed=speed), duration, last, jnp.array(False))

    def locate(_):
        guess = jnp.clip(falls_at_once(first, start_rate, end_rate, length), 0.0, length)
        time = _event_time(flow, height, jnp.zeros_like(length), guess, length, remaining)
        state = flow(time)._replace(speed=jnp.zeros_like(end.speed))
        return _Travel(state, time, jnp.array(False), jnp.array(True))

    return jax.lax.cond((first > 0.0) & (final <= 0.0), locate, go_on, None)


def _travel(contact: BearingEquation, motion: Motion, direction, start, remaining):
    """Move in one mode until the end of the interval, the segment limit or an event.

    Returns:
        State and event at the end, and the direction in which the load on a wheel at rest grows.
    """
    duration, last = _longest(contact, motion, direction, start, remaining)
    held = direction == 0.0

    def flow(duration):
        return _runge_kutta(contact, motion, direction, start, duration)

    end = flow(duration)
    grown = contact.load(end.carrier, start + duration) - contact.load(motion.carrier, start)
    rising = jax.lax.stop_gradient(jnp.sign(grown))

    def height(motion, duration):
        return _height(contact, motion, direction, rising, start + duration)

    # the kind of event depends on values only, not on derivatives
    length = jax.lax.stop_gradient(duration)
    first, start_rate = jax.lax.stop_gradient(height(motion, jnp.zeros_like(duration)))
    final, end_rate = jax.lax.stop_gradient(height(end, duration))
    turning, from_zero, rises, past_zero, dips = ends(
        held, first, start_rate, final, end_rate, length
    )

    goes_on = _Travel(end, duration, last, jnp.array(False))

    def go_on(_):
        # exactly at the breakaway torque, rounding may turn the wheel back: it stays at zero
        stays = from_zero & ~rises & (final < 0.0)
        speed = jnp.where(stays, 0.0, end.speed)
        return goes_on._replace(motion=end._replace(speed=speed))

    def locate(_):
        low = jnp.where(rises & from_zero, turning, 0.0)
        high = jnp.where(past_zero, length, turning)
        guess = jnp.clip(falls_through_zero(first, start_rate, end_rate, length), low, high)
        time = _event_time(flow, height, low, guess, high, remaining)
        # the parabola that indicated the dip is only an estimate; the flow decides
        deepest = jax.lax.stop_gradient(height(flow(high), high)[0])
        state = flow(time)._replace(speed=jnp.zeros_like(end.speed))
        stops = _Travel(state, time, jnp.array(False), jnp.array(True))
        reaches = past_zero | (deepest <= 0.0)
        return jax.tree.map(lambda a, b: jnp.where(reaches, a, b), stops, goes_on)

    return jax.lax.cond(past_zero | dips, locate, go_on, None), rising


def step_dry_friction(
    contact: BearingEquation, motion: Motion, duration: Scalar
) -> tuple[Motion, Bool[Array, ""]]:
    """Advance a wheel with static friction, and its carrier, over one interval.

    Args:
        contact: Equations of motion.
        motion: State at the start.
        duration: Length of the interval, s.

    Returns:
        State at the end, and whether the interval was resolved: False if it needed more than
        `MAX_SEGMENTS` segments. Differentiable in forward mode in every argument and parameter.

    Raises:
        TypeError: The friction is not static; for bristle friction use `step_bristles`.
    """
    if not isinstance(contact.friction, Friction):
        raise TypeError(f"friction: found {type(contact.friction).__name__}, expected a static one")

    def go_steadily(segment: Segment, duration: Scalar) -> Segment:
        motion, elapsed = segment.motion, segment.elapsed
        load = contact.load(motion.carrier, elapsed)
        at_rest, sense = motion.speed == 0.0, jnp.sign(load)
        holds = at_rest & (jnp.abs(load) <= contact.friction.breakaway_torque(sense))
        direction = jnp.where(at_rest, jnp.where(holds, 0.0, sense), jnp.sign(motion.speed))
        travel = _travel_steadily(contact, motion, direction, elapsed, duration - elapsed)
        return segment._replace(
            motion=travel.motion,
            elapsed=jnp.where(travel.finished, duration, elapsed + travel.time),
            landed=travel.ran_out,
            number=segment.number + 1,
        )

    def go(segment: Segment, duration: Scalar) -> Segment:
        motion, elapsed = segment.motion, segment.elapsed
        load = contact.load(motion.carrier, elapsed)
        at_rest = motion.speed == 0.0
        free = jnp.where(segment.released != 0.0, segment.released, jnp.sign(load))
        bears = jnp.abs(load) <= contact.friction.breakaway_torque(free)
        holds = at_rest & (segment.released == 0.0) & bears
        direction = jnp.where(at_rest, jnp.where(holds, 0.0, free), jnp.sign(motion.speed))
        travel, rising = _travel(contact, motion, direction, elapsed, duration - elapsed)
        breaks_away = travel.ran_out & (direction == 0.0)
        return Segment(
            motion=travel.motion,
            elapsed=jnp.where(travel.finished, duration, elapsed + travel.time),
            released=jnp.where(breaks_away, rising, 0.0),
            landed=travel.ran_out & ~breaks_away,
            number=segment.number + 1,
        )

    end = through_segments(go_steadily if contact.is_steady() else go, motion, duration)
    return end.motion, end.elapsed >= duration
