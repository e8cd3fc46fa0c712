"""Search for the earliest event of several wheels with dry friction on one carrier.

See `gyrostat.wheel.coupled_wheels`.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float, Int

from gyrostat.core.arrays import PerWheel
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.bearing_equation import Motion
from gyrostat.wheel.coupled_bearings import CoupledBearings, Modes
from gyrostat.wheel.segment import NEWTON_STEPS, ends, falls_through_zero, narrowed, within

EVENT_TOLERANCE = 1e-9
"""Remaining share of an event function that counts as zero, if its minimum only reaches zero."""
POLISH = 1e-6
"""Largest share of a segment by which the last Newton step may move an event; its square is the
error."""
STAGES, WEIGHTS = np.array([0.5, 0.5, 1.0]), np.array([2.0, 2.0, 1.0]) / 6.0


@jax.jit
def runge_kutta(contacts: CoupledBearings, motion: Motion, modes: Modes, start, rate, duration):
    """Classical fourth-order step in fixed modes; later stages in a loop, which compiles faster."""

    def stage(carry, share):
        rate, total = carry
        fraction, weight = share
        state = jax.tree.map(lambda y, k: y + fraction * duration * k, motion, rate)
        rate = contacts.rate(state, modes, start + fraction * duration)
        return (rate, jax.tree.map(lambda y, k: y + weight * duration * k, total, rate)), None

    total = jax.tree.map(lambda y, k: y + duration / 6.0 * k, motion, rate)
    return jax.lax.scan(stage, (rate, total), (STAGES, WEIGHTS))[0][1]


class _Loads(NamedTuple):
    """Friction torques, N·m, their rates of change, N·m/s, and the time derivative of the state."""

    torque: PerWheel
    change: PerWheel
    rate: Motion


@jax.jit
def _loads(contacts: CoupledBearings, motion: Motion, modes: Modes, time) -> _Loads:
    """Friction torques and their rates of change in fixed modes of motion."""
    torque, along = jax.linearize(
        lambda motion, time: contacts.torques(motion, modes, time), motion, time
    )
    rate = contacts.rate_under(motion, torque, modes, time)
    return _Loads(torque, along(rate, jnp.ones_like(time)), rate)


class _Search(NamedTuple):
    """Earliest event so far, and the wheels that may have had an earlier one."""

    time: Float[Array, ""]
    wheel: Int[Array, ""]
    found: Bool[Array, ""]
    suspects: Bool[Array, " wheels"]


class _Trial(NamedTuple):
    """State of the search for the event of one wheel."""

    wheel: Int[Array, ""]
    bracket: tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""]]
    steps: Int[Array, ""]


def earliest_event(contacts, motion, modes, start, remaining, begins, whole):
    """Move in fixed modes until the first event, if there is one.

    Args:
        contacts: Equations of motion.
        motion: State at the start of the segment.
        modes: Modes of motion.
        start: Time of the start, s.
        remaining: Remaining time of the interval, s.
        begins: Time derivative of the state at the start.
        whole: State, time and whether the interval ends, at the end of the segment without events.

    Returns:
        State and time at the end, whether it is the end of the interval, the wheels that had an
        event, and the direction in which the torque on each resting wheel grows.
    """
    (end, duration, last), direction, held = whole, modes.direction, modes.direction == 0.0

    def flow(duration):
        return runge_kutta(contacts, motion, modes, start, begins, duration)

    def loads(motion, duration):
        return _loads(contacts, motion, modes, start + duration)

    # the kind of event depends on values only, not on derivatives
    length = jax.lax.stop_gradient(duration)
    boundary = jax.tree.map(lambda a, b: jnp.stack([a, b]), motion, end)
    # one call for both ends, which compiles once
    end_loads = jax.lax.stop_gradient(jax.vmap(loads)(boundary, jnp.stack([jnp.zeros(()), length])))
    rising = jnp.sign(end_loads.torque[1] - end_loads.torque[0])

    def heights(motion, loads):
        """Event function of each mode of motion, and its rate of change.

        For a turning wheel it is the speed in its direction. For a wheel at rest it is the
        breakaway torque minus the holding torque, in the direction in which this torque grows.
        """
        lacks = contacts.breakaway_torque(rising) - rising * loads.torque
        at_rest = jnp.where(rising == 0.0, 1.0, lacks)
        return (
            jnp.where(held, at_rest, direction * motion.speed),
            jnp.where(held, -rising * loads.change, direction * loads.rate.speed),
        )

    values = jax.lax.stop_gradient(jax.vmap(heights)(boundary, end_loads))
    (initial, final), (start_rate, end_rate) = values
    turning, from_zero, rises, past_zero, dips = ends(
        held, initial, start_rate, final, end_rate, length
    )
    guess = falls_through_zero(initial, start_rate, end_rate, length)

    def go_on(_):
        # exactly at the breakaway torque, rounding may turn a wheel back: it stays at zero
        stays = from_zero & ~rises & (final < 0.0)
        speed = jnp.where(stays, 0.0, end.speed)
        return end._replace(speed=speed), duration, last, jnp.zeros_like(held)

    def next_trial(search: _Search) -> _Trial:
        wheel = jnp.argmin(jnp.where(search.suspects, guess, jnp.inf))
        low = jnp.where(rises[wheel] & from_zero[wheel], turning[wheel], 0.0)
        high = jnp.where(past_zero[wheel], search.time, turning[wheel])
        return _Trial(wheel, (low, high, jnp.clip(guess[wheel], low, high)), jnp.array(0))

    def locate(_):
        def look(carry: tuple[_Search, _Trial, Array]) -> tuple[_Search, _Trial, Array]:
            # the bracket and its end are evaluated in one step, so that a flow compiles once
            search, trial, number = carry
            wheel, time = trial.wheel, trial.bracket[2]
            state = flow(time)
            height, rate = heights(state, loads(state, time))
            closer = trial._replace(
                bracket=narrowed(trial.bracket, height[wheel], rate[wheel]), steps=trial.steps + 1
            )
            # the parabola that indicated the dip is only an estimate; the flow decides
            happens = past_zero[wheel] | (height[wheel] <= EVENT_TOLERANCE * initial[wheel])
            earliest = jnp.where(happens, time, search.time)
            earlier = jnp.where(past_zero, height <= 0.0, turning < earliest)
            suspects = search.suspects & (jnp.arange(len(held)) != wheel)
            suspects &= jnp.where(happens, earlier, True)
            result = _Search(
                earliest, jnp.where(happens, wheel, search.wheel), search.found | happens, suspects
            )
            over = trial.steps == NEWTON_STEPS
            return *jax.tree.map(
                lambda a, b: jnp.where(over, a, b), (result, next_trial(result)), (search, closer)
            ), number + 1

        # flight code needs a constant bound, and reports if it is reached
        bound = len(held) * (NEWTON_STEPS + 1)
        none = _Search(length, jnp.array(0), jnp.array(False), past_zero | dips)
        search, *_ = jax.lax.stop_gradient(
            jax.lax.while_loop(
                lambda s: jnp.any(s[0].suspects) & (s[2] <= bound),
                look,
                (none, next_trial(none), jnp.array(0)),
            )
        )
        state = flow(search.time)
        at = loads(state, search.time)
        height, rate = (value[search.wheel] for value in heights(state, at))
        # one more Newton step, which has the derivative but hardly changes the value
        move = -height / jax.lax.stop_gradient(jnp.where(rate == 0.0, -1.0, rate))
        move += jax.lax.stop_gradient(jnp.where(jnp.abs(move) < POLISH * length, 0.0, -move))
        time = within(search.time + move, remaining)
        hit = jnp.arange(len(held)) == search.wheel
        move = time - search.time
        state = jax.tree.map(lambda y, k: y + move * jax.lax.stop_gradient(k), state, at.rate)
        state = state._replace(speed=jnp.where(hit, 0.0, state.speed))
        stops = (state, time, jnp.array(False), hit)
        return jax.tree.map(lambda a, b: jnp.where(search.found, a, b), stops, go_on(None))

    return *jax.lax.cond(jnp.any(past_zero | dips), locate, go_on, None), rising
