"""Stepping of several wheels with bristle friction (LuGre, Dahl) on one carrier.

While every wheel slips far from zero speed, the deflection of its bristles is constant, and the
friction is exactly the static curve: the step is that of `gyrostat.wheel.coupled_wheels`. Otherwise
speeds and deflections, which are stiff, are integrated by a linearly implicit method, and the
carrier, which is not, by the explicit part of this method (`gyrostat.wheel.rosenbrock_w`).
"""

from dataclasses import replace
from typing import NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rarely import rarely
from gyrostat.wheel.adaptive_steps import Step, in_adaptive_steps
from gyrostat.wheel.bearing_equation import Motion
from gyrostat.wheel.bristle_equations import Bristled, BristleEquations, bristle_equations
from gyrostat.wheel.coupled_bearings import CoupledBearings
from gyrostat.wheel.coupled_wheels import quick_step
from gyrostat.wheel.friction import Bristles
from gyrostat.wheel.rosenbrock_w import ORDER, rosenbrock_w_step
from gyrostat.wheel.segment import BAND

TOLERANCE = 1e-5
"""Largest estimated error of a step, relative to the scales below or to the state, whichever is
larger.

The estimate is that of a method of second order; the error is smaller. Measured on a cubesat with
four wheels, 20 s with 18 crossings of zero speed, for bristles that bend by 0.001, 0.01 and 0.1
rad: the errors are within 2e-5 of the largest deflection, 8e-6 rad/s and, in attitude, 6e-9 rad.
They are proportional to this value.
"""
SETTLED = 1e-9
"""Largest deviation of a settled deflection from that of steady slip, relative."""


def _edge(friction: Bristles) -> Scalar:
    """Speed above which the level of the bristles is constant, rad/s."""
    scale = friction.curve.speed_scale()
    return jnp.where(jnp.isinf(scale), 0.0, BAND * scale)


def _integrate(equations: BristleEquations, state: Bristled, duration, tolerance: Scalar):
    """State at the end of an interval, and whether it was reached."""

    def step(state: Bristled, time: Scalar, target_length: Scalar) -> Step:
        rate = equations.rate(state, time)
        crossing = jax.lax.stop_gradient(equations.crossing(state, rate, tolerance))
        remaining = duration - time
        length = jnp.minimum(target_length, jnp.minimum(crossing, longest))
        last = length >= remaining
        length = jnp.where(last, remaining, length)
        solve = equations.solver(state, length)
        reached, error = rosenbrock_w_step(equations.rate, solve, state, rate, time, length)
        worst = equations.error(state, reached, error, length) / tolerance
        return Step(reached, length, last, worst)

    def ratio(error: Scalar) -> Scalar:
        return jnp.exp(-jnp.log(error) / ORDER)

    first, longest = jax.lax.stop_gradient(equations.step_limits(state))
    return in_adaptive_steps(step, state, duration, first, ratio)


class _End(NamedTuple):
    motion: Motion
    deflection: PerWheel
    resolved: Bool[Array, ""]


def _slipping(contacts: CoupledBearings, motion: Motion, deflection, held, duration):
    """Step with the static curve, and whether all wheels slip at the constant level throughout."""
    friction = contacts.friction
    slipping = replace(contacts, friction=friction.curve)
    (after, _), is_complete = quick_step(slipping, motion, duration)
    steady = friction.steady_deflection(motion.speed)
    settled = jnp.abs(deflection - steady) <= SETTLED * jnp.abs(steady)
    slowest = jnp.minimum(jnp.abs(motion.speed), jnp.abs(after.speed))
    slips = settled & (slowest > _edge(friction))
    deflection = jnp.where(held, deflection, friction.steady_deflection(after.speed))
    return _End(after, deflection, jnp.array(True)), is_complete & jnp.all(held | slips)


def step_coupled_bristles(
    contacts: CoupledBearings,
    motion: Motion,
    deflection: PerWheel,
    held: Bool[Array, " wheels"],
    duration: Scalar,
    *,
    tolerance: Scalar = TOLERANCE,
) -> tuple[Motion, PerWheel, Bool[Array, ""]]:
    """Advance several wheels with bristle friction, and their carrier, over one interval.

    Args:
        contacts: Equations of motion with bristle friction.
        motion: State at the start, with a speed of (wheels,).
        deflection: Deflections of the bristles at the start, (wheels,), rad.
        held: Whether each wheel is fixed to the carrier, (wheels,); its speed is 0.
        duration: Length of the interval, s.
        tolerance: Largest error of a step, see `TOLERANCE`.

    Returns:
        State and deflections at the end, and whether the requested accuracy was reached: False if
        it needed too many steps. Differentiable in forward mode.
    """
    arrays, static = eqx.partition(contacts, eqx.is_array_like)
    arguments = (motion, deflection, duration, tolerance)
    arguments = jax.tree.map(lambda y: jnp.asarray(y, dtype=float), arguments)
    motion, deflection, duration, tolerance = arguments

    def quick(arrays, motion, deflection, held, duration, tolerance):
        return _slipping(eqx.combine(arrays, static), motion, deflection, held, duration)

    def exact(arrays, motion, deflection, held, duration, tolerance):
        contacts = eqx.combine(arrays, static)
        end, slips = _slipping(contacts, motion, deflection, held, duration)

        def integrated(_):
            equations = bristle_equations(contacts, motion, held)
            free_speed = motion.speed + equations.damped(deflection)
            state = Bristled(free_speed, deflection, motion.carrier)
            state, resolved = _integrate(equations, state, duration, tolerance)
            speed = jnp.where(held, 0.0, equations.speed(state))
            return _End(Motion(speed, state.carrier), state.deflection, resolved)

        return jax.lax.cond(slips, lambda _: end, integrated, None)

    end = rarely(quick, exact)(arrays, motion, deflection, held, duration, tolerance)
    return end.motion, end.deflection, end.resolved
