"""Exact stepping of several wheels with dry friction on one carrier.

The scheme is that of one wheel (`gyrostat.wheel.stepping`): between events every wheel rests or
turns in one sense. What is new is that the wheels feel each other through the carrier: the torques
that hold the resting ones solve one small symmetric system, the earliest of several events ends a
segment, and of several overloaded wheels the worst is released first.
"""

from typing import NamedTuple

from jaxtyping import Array, Bool, Float, Int

from gyrostat._jax import jax, jnp
from gyrostat.friction import Scalar
from gyrostat.wheel.contact import Motion
from gyrostat.wheel.contacts import Contacts, PerWheel
from gyrostat.wheel.segment import (
    MAX_SEGMENTS,
    bracketed_time,
    falls_through_zero,
    friction_limit,
    newton_step,
    within,
)

EVENT_TOLERANCE = 1e-9
"""Share of a height that may be left where it only dips to zero."""
STAGES = jnp.array([0.0, 0.5, 0.5, 1.0])
WEIGHTS = jnp.array([1.0, 2.0, 2.0, 1.0]) / 6.0


@jax.jit
def _runge_kutta(contacts: Contacts, motion: Motion, direction, start, duration) -> Motion:
    """One classical fourth-order step of frozen modes; its stages a loop, which compiles sooner."""

    def stage(carry, share):
        rate, total = carry
        place, weight = share
        there = jax.tree.map(lambda y, k: y + place * duration * k, motion, rate)
        rate = contacts.rate(there, direction, start + place * duration)
        return (rate, jax.tree.map(lambda y, k: y + weight * duration * k, total, rate)), None

    nothing = jax.tree.map(jnp.zeros_like, motion)
    return jax.lax.scan(stage, (nothing, motion), (STAGES, WEIGHTS))[0][1]


class _Segment(NamedTuple):
    motion: Motion
    elapsed: Float[Array, ""]
    released: PerWheel
    """Sense (±1) in which a load has just reached the breakaway level, else 0."""
    landed: Bool[Array, ""]
    """Whether a speed has just come to zero."""
    number: Int[Array, ""]


def _directions(contacts: Contacts, motion: Motion, released: PerWheel, time: Scalar) -> PerWheel:
    """Mode of each wheel: turning ones keep their sense, resting ones hold if they can."""
    start = jnp.where(motion.speed == 0.0, released, jnp.sign(motion.speed))

    def release_worst(_, direction):
        torque = contacts.torques(motion, direction, time)
        sense = jnp.sign(torque)
        excess = jnp.abs(torque) - contacts.breakaway_torque(sense)
        excess = jnp.where(direction == 0.0, excess, -1.0)
        worst = jnp.argmax(excess)
        free = (jnp.arange(len(excess)) == worst) & (excess > 0.0)
        return jnp.where(free, sense, direction)

    return jax.lax.fori_loop(0, len(start), release_worst, start)


@jax.jit
def _heights(contacts: Contacts, motion: Motion, direction, rising, time):
    """What is left before each mode of motion ends, and how fast it changes.

    For a turning wheel the speed in its sense; for a wheel at rest what the torque that holds it
    lacks to the breakaway torque in the sense `rising` in which it grows.
    """

    def height(motion, time):
        torque = contacts.torques(motion, direction, time)
        lacks = contacts.breakaway_torque(rising) - rising * torque
        at_rest = jnp.where(rising == 0.0, 1.0, lacks)
        return jnp.where(direction == 0.0, at_rest, direction * motion.speed)

    rate = contacts.rate(motion, direction, time)
    return jax.jvp(height, (motion, time), (rate, jnp.ones_like(time)))


@jax.jit
def _segment_limit(contacts: Contacts, motion: Motion, direction, start, remaining):
    """Longest segment that resolves every friction curve, the carrier and the drive."""
    rate = contacts.rate(motion, direction, start)
    mobility = contacts.mobility

    def pull(motion, time):
        drive, drift = contacts.drive(motion, time)
        return mobility @ drive + drift

    change = jax.jvp(pull, (motion, start), (rate, jnp.ones_like(start)))[1]
    limit = friction_limit(
        contacts.friction,
        1.0 / jnp.diagonal(mobility),
        motion.speed,
        direction,
        jnp.abs(rate.speed),
        jnp.abs(change),
        remaining,
    )
    limit = jnp.min(jnp.where(direction == 0.0, remaining, limit))
    return jnp.minimum(limit, contacts.longest_segment(motion, start))


class _Search(NamedTuple):
    """The earliest event so far, and the wheels that may have had an earlier one."""

    time: Float[Array, ""]
    wheel: Int[Array, ""]
    found: Bool[Array, ""]
    suspects: Bool[Array, " wheels"]


def _travel(contacts: Contacts, motion: Motion, direction, start, remaining):
    """Move in frozen modes until the interval, the segment limit or one of the modes runs out.

    Returns:
        Motion and time at its end, whether that is the end of the interval, the wheels whose mode
        ran out, and the sense in which the torque on each resting wheel grows.
    """
    frozen = jax.lax.stop_gradient((contacts, motion, direction, start))
    limit = _segment_limit(*frozen, jax.lax.stop_gradient(remaining))
    last = limit >= remaining
    duration = jnp.where(last, remaining, limit)
    held = direction == 0.0

    def flow(duration):
        return _runge_kutta(contacts, motion, direction, start, duration)

    end = flow(duration)
    after = contacts.torques(end, direction, start + duration)
    before = contacts.torques(motion, direction, start)
    rising = jax.lax.stop_gradient(jnp.sign(after - before))

    def heights(motion, duration):
        return _heights(contacts, motion, direction, rising, start + duration)

    # what happens is decided on values alone
    length = jax.lax.stop_gradient(duration)
    both = jax.tree.map(lambda a, b: jnp.stack([a, b]), motion, end)
    times = jnp.stack([jnp.zeros_like(length), length])
    # one call for both ends, which compiles once
    (first, final), (start_rate, end_rate) = jax.lax.stop_gradient(jax.vmap(heights)(both, times))
    turns = start_rate * end_rate < 0.0
    turning = length * start_rate / jnp.where(turns, start_rate - end_rate, 1.0)
    # a wheel that starts at zero comes to zero only after it has risen
    from_zero = ~held & (first == 0.0)
    rises = turns & (start_rate > 0.0)
    past_zero = (final <= 0.0) & (~from_zero | rises)
    # a parabola through both ends, at its turning point: does the height dip below zero?
    lowest = first + 0.5 * start_rate * turning
    dips = turns & (start_rate < 0.0) & (lowest <= 0.0) & ~from_zero & ~past_zero
    guess = falls_through_zero(first, start_rate, end_rate, length)

    def go_on(_):
        # just at the breakaway level, rounding may turn a wheel back: it stays at zero
        stays = from_zero & ~rises & (final < 0.0)
        speed = jnp.where(stays, 0.0, end.speed)
        return end._replace(speed=speed), duration, last, jnp.zeros_like(held)

    def locate(_):
        def of_wheel(wheel):
            def height(motion, duration):
                value, rate = heights(motion, duration)
                return value[wheel], rate[wheel]

            return height

        def narrow(search: _Search) -> _Search:
            wheel = jnp.argmin(jnp.where(search.suspects, guess, jnp.inf))
            low = jnp.where(rises[wheel] & from_zero[wheel], turning[wheel], 0.0)
            high = jnp.where(past_zero[wheel], search.time, turning[wheel])
            first_guess = jnp.clip(guess[wheel], low, high)
            time = bracketed_time(flow, of_wheel(wheel), low, first_guess, high)
            # the parabola that found a dip is only an estimate: the flow itself decides
            left = heights(flow(time), time)[0]
            happens = past_zero[wheel] | (left[wheel] <= EVENT_TOLERANCE * first[wheel])
            time = jnp.where(happens, time, search.time)
            earlier = jnp.where(past_zero, left <= 0.0, turning < time)
            others = search.suspects & (jnp.arange(len(held)) != wheel)
            others &= jnp.where(happens, earlier, True)
            return _Search(
                time, jnp.where(happens, wheel, search.wheel), search.found | happens, others
            )

        none = _Search(length, jnp.array(0), jnp.array(False), past_zero | dips)
        search = jax.lax.while_loop(lambda s: jnp.any(s.suspects), narrow, none)
        search = jax.lax.stop_gradient(search)
        time = within(newton_step(flow, of_wheel(search.wheel), search.time)[1], remaining)
        hit = jnp.arange(len(held)) == search.wheel
        there = flow(time)
        there = there._replace(speed=jnp.where(hit, 0.0, there.speed))
        stops = (there, time, jnp.array(False), hit)
        return jax.tree.map(lambda a, b: jnp.where(search.found, a, b), stops, go_on(None))

    return *jax.lax.cond(jnp.any(past_zero | dips), locate, go_on, None), rising


def slide_together(
    contacts: Contacts, motion: Motion, duration: Scalar
) -> tuple[Motion, Bool[Array, ""]]:
    """Carry several wheels and their carrier over one interval.

    Args:
        contacts: the equations of motion.
        motion: at the start; its speed is (wheels,).
        duration: s.

    Returns:
        The motion at the end, and whether the interval was resolved: False when it needed more than
        `MAX_SEGMENTS` segments. Differentiable in forward mode in every argument and parameter.
    """
    motion = jax.tree.map(lambda y: jnp.asarray(y, dtype=float), motion)
    duration = jnp.asarray(duration, dtype=float)

    def unfinished(segment: _Segment):
        # wheels that come to zero at the very end have still to stick or to go through, in no time
        more = (segment.elapsed < duration) | segment.landed
        return more & (segment.number < MAX_SEGMENTS)

    def go(segment: _Segment) -> _Segment:
        motion, elapsed = segment.motion, segment.elapsed
        direction = _directions(contacts, motion, segment.released, elapsed)
        after, time, finished, hit, rising = _travel(
            contacts, motion, direction, elapsed, duration - elapsed
        )
        breaks_away = hit & (direction == 0.0)
        return _Segment(
            motion=after,
            elapsed=jnp.where(finished, duration, elapsed + time),
            released=jnp.where(breaks_away, rising, 0.0),
            landed=jnp.any(hit & (direction != 0.0)),
            number=segment.number + 1,
        )

    start = _Segment(
        motion, jnp.zeros(()), jnp.zeros_like(motion.speed), jnp.array(False), jnp.array(0)
    )
    last = jax.lax.while_loop(unfinished, go, start)
    return last.motion, (last.elapsed >= duration) & ~last.landed
