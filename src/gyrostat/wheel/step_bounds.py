"""Step bounds at the start of a segment: its length, and wheels certain to stay at rest."""

from typing import NamedTuple

from gyrostat.core.arrays import PerWheel
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.bearing_equation import Motion
from gyrostat.wheel.coupled_bearings import Changes, CoupledBearings, Modes
from gyrostat.wheel.segment import TURN_STEP, friction_limit, is_resolved, steepness


class Begin(NamedTuple):
    """Friction torques, N·m, and rates of change at the start of a segment."""

    torque: PerWheel
    rate: Motion
    changes: Changes
    steep: tuple[PerWheel, PerWheel]
    """Derivatives of the friction torque, see `steepness`."""


def _segment_limit(
    contacts: CoupledBearings, motion: Motion, modes: Modes, begin: Begin, remaining
):
    """Longest segment that resolves every friction curve, the carrier and the drive."""
    held, friction = modes.direction == 0.0, contacts.friction
    rate, change = jnp.abs(begin.rate.speed), jnp.abs(begin.changes.pull)
    turn, turn_change = begin.changes.turn_squared, begin.changes.turn_change_squared

    def limit(_):
        # root of turn t + turn_change t²/2 = TURN_STEP, also for a carrier that starts at rest
        frequency = jnp.sqrt(turn) / TURN_STEP
        frequency += jnp.sqrt(turn / TURN_STEP**2 + 2.0 * jnp.sqrt(turn_change) / TURN_STEP)
        inertia = 1.0 / jnp.diagonal(contacts.mobility)
        limits = friction_limit(
            friction, inertia, motion.speed, modes.direction, rate, change, remaining
        )
        longest = jnp.min(jnp.where(held, remaining, limits))
        return jnp.minimum(longest, 2.0 / jnp.maximum(frequency, 1e-9))

    # most segments are far from any limit, and this test is faster than finding the limit
    turned = remaining**2 * (2.0 * turn + 0.5 * remaining**2 * turn_change)
    resolved = is_resolved(friction, begin.steep, motion.speed, rate, change, remaining)
    fits = jnp.all(held | resolved) & (turned <= TURN_STEP**2)
    return jax.lax.cond(fits, lambda _: remaining, limit, None)


@jax.jit
def step_bounds(
    contacts: CoupledBearings, motion: Motion, modes: Modes, start, torque, rate, remaining
):
    """Rates of change at the start of a segment, and the limit of its length."""
    steep = steepness(
        contacts.friction, 1.0 / jnp.diagonal(contacts.mobility), motion.speed, modes.direction
    )
    begin = Begin(torque, rate, contacts.changes(motion, rate, start), steep)
    return begin, _segment_limit(contacts, motion, modes, begin, remaining)


def stays(contacts: CoupledBearings, modes: Modes, begin: Begin, end: Motion, time, duration):
    """Whether each held wheel certainly rests until the end of a segment, at this time."""
    held, steep = modes.direction == 0.0, begin.steep[0]
    # a holding torque changes with the drive and with the friction of the turning wheels
    rubs = steep / jnp.diagonal(contacts.mobility) * begin.rate.speed
    slowing = contacts.mobility @ jnp.where(held, begin.changes.drive, rubs)
    change = begin.changes.drive + modes.holding @ (begin.changes.pull - slowing)
    ones = jnp.ones_like(modes.direction)
    breakaway = jnp.minimum(contacts.breakaway_torque(ones), contacts.breakaway_torque(-ones))
    # a parabola with this slope that ends below the level does not exceed it before
    bound = jnp.abs(begin.torque) + 0.5 * duration * jnp.abs(change)
    return (bound < breakaway) & (jnp.abs(contacts.torques(end, modes, time)) < breakaway)
