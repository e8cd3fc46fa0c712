"""Exact stepping of several wheels with dry friction on one carrier.

The method is that for one wheel (`gyrostat.wheel.stepping`): between events, every wheel rests or
turns in one direction. In addition, the wheels are coupled through the carrier. The torques that
hold the resting wheels solve one small symmetric system, the earliest of several events ends a
segment, and of several overloaded wheels the one with the largest excess is released first.
"""

from typing import NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rarely import rarely
from gyrostat.wheel.bearing_equation import Motion
from gyrostat.wheel.coupled_bearings import CoupledBearings, Modes
from gyrostat.wheel.coupled_events import earliest_event, runge_kutta
from gyrostat.wheel.segment import Segment, through_segments
from gyrostat.wheel.step_bounds import stays, step_bounds


def _modes(contacts: CoupledBearings, motion: Motion, released: PerWheel, time: Scalar) -> Modes:
    """Mode of each wheel: a turning wheel keeps its direction, a resting one holds if it can."""
    start = jnp.where(motion.speed == 0.0, released, jnp.sign(motion.speed))

    def release_worst(carry):
        direction, _, _, number = carry
        modes = contacts.modes(direction)
        torque = contacts.torques(motion, modes, time)
        sense = jnp.sign(torque)
        excess = jnp.abs(torque) - contacts.breakaway_torque(sense)
        excess = jnp.where(direction == 0.0, excess, -1.0)
        worst = jnp.argmax(excess)
        free = (jnp.arange(len(excess)) == worst) & (excess > 0.0)
        return jnp.where(free, sense, direction), modes, jnp.any(free), number + 1

    initial = Modes(start, jnp.zeros_like(contacts.mobility))
    rests = jnp.any(start == 0.0)  # otherwise no wheel is held and none can be released

    def goes_on(carry):
        # each pass but the last releases a wheel; flight code needs an explicit bound
        return carry[2] & (carry[3] < len(start) + 2)

    return jax.lax.while_loop(goes_on, release_worst, (start, initial, rests, 0))[1]


class _FreeSegment(NamedTuple):
    """Segment without events: state, time and whether the interval ends, at its end."""

    end: Motion
    duration: Scalar
    last: Bool[Array, ""]


def _without_events(contacts: CoupledBearings, motion: Motion, modes: Modes, start, remaining):
    """Move in fixed modes until the end of the interval or the segment limit.

    Returns:
        Segment, whether an event is certainly absent, and the rate of the state at the start.
    """
    torque = contacts.torques(motion, modes, start)
    rate = contacts.rate_under(motion, torque, modes, start)
    frozen = jax.lax.stop_gradient((contacts, motion, modes, start, torque, rate, remaining))
    begin, limit = step_bounds(*frozen)
    last = limit >= remaining
    duration = jnp.where(last, remaining, limit)
    direction = modes.direction
    end = runge_kutta(contacts, motion, modes, start, rate, duration)
    # far from zero and not moving there, so that `ends` would find no event
    first, final = direction * motion.speed, direction * end.speed
    heads_for = first + 0.5 * duration * jnp.minimum(direction * rate.speed, 0.0)
    turns_on = (first > 0.0) & (final > 0.0) & (heads_for > 0.0)
    rests_on = stays(contacts, modes, begin, end, start + duration, duration)
    calm = jnp.all(jnp.where(direction == 0.0, rests_on, turns_on))
    return _FreeSegment(end, duration, last), calm, rate


def _travel(contacts: CoupledBearings, motion: Motion, modes: Modes, start, remaining):
    """Move in fixed modes until the end of the interval, the segment limit or an event.

    Returns:
        State and time at the end, whether it is the end of the interval, the wheels that had an
        event, and the direction in which the torque on each resting wheel grows.
    """
    segment, calm, rate = _without_events(contacts, motion, modes, start, remaining)
    direction = modes.direction

    def look_closer(_):
        return earliest_event(contacts, motion, modes, start, remaining, rate, segment)

    no_event = (jnp.zeros(direction.shape, dtype=bool), jnp.zeros_like(direction))
    return jax.lax.cond(calm, lambda _: (*segment, *no_event), look_closer, None)


def quick_step(contacts, motion, duration):
    """Advance by one segment without a search for events; also whether that is all there is."""
    motion = jax.tree.map(lambda y: jnp.asarray(y, dtype=float), motion)
    time = jnp.zeros(())
    modes = _modes(contacts, motion, jnp.zeros_like(motion.speed), time)
    segment, calm, _ = _without_events(contacts, motion, modes, time, duration)
    return (segment.end, jnp.array(True)), calm & segment.last


def step_coupled_wheels(
    contacts: CoupledBearings, motion: Motion, duration: Scalar
) -> tuple[Motion, Bool[Array, ""]]:
    """Advance several wheels with static friction, and their carrier, over one interval.

    Args:
        contacts: Equations of motion.
        motion: State at the start, with a speed of (wheels,).
        duration: Length of the interval, s.

    Returns:
        State at the end, and whether the interval was resolved: False if it needed more than
        `MAX_SEGMENTS` segments. Differentiable in forward mode in every argument and parameter.
    """
    arrays, static = eqx.partition(contacts, eqx.is_array_like)

    def exact(arrays, motion, duration):
        return _step(eqx.combine(arrays, static), motion, duration)

    def quick(arrays, motion, duration):
        return quick_step(eqx.combine(arrays, static), motion, duration)

    return rarely(quick, exact)(arrays, motion, duration)


def _step(contacts, motion, duration):
    """Advance through all segments of an interval."""

    def go(segment: Segment, duration: Scalar) -> Segment:
        motion, elapsed = segment.motion, segment.elapsed
        modes = _modes(contacts, motion, segment.released, elapsed)
        after, time, finished, hit, rising = _travel(
            contacts, motion, modes, elapsed, duration - elapsed
        )
        held = modes.direction == 0.0
        breaks_away = hit & held
        return Segment(
            motion=after,
            elapsed=jnp.where(finished, duration, elapsed + time),
            released=jnp.where(breaks_away, rising, 0.0),
            landed=jnp.any(hit & ~held),
            number=segment.number + 1,
        )

    end = through_segments(go, motion, duration)
    return end.motion, (end.elapsed >= duration) & ~end.landed
