"""Equations of motion of several wheels with bristle friction, and their stiff part."""

from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.wheel.bearing_equation import Motion
from gyrostat.wheel.coupled_bearings import CoupledBearings
from gyrostat.wheel.rosenbrock_w import GAMMA
from gyrostat.wheel.segment import TURN_STEP

CARRIER_SCALE = 1e-2
"""Scale of the errors in the motion of the carrier, rad, rad/s and N·m·s."""
REST = 1e-2
"""Scale of the speed error over the speed scale of the curve; it bounds the creep at rest.

A table whose wheel is held below breakaway for 10 000 s, in steps of 10 s, creeps by 4e-6 rad. The
creep is proportional to this value.
"""
SLOWEST = 1e-2
"""Speed scale of a friction curve that has none, rad/s."""
FIRST_REACH = 0.2
"""Largest change of speed in a first step, relative to the speed or to the scale of the curve."""


class Bristled(NamedTuple):
    """State of wheels with bristles and their carrier, or its time derivative.

    Attributes:
        free_speed: Speeds w + M s_1 z, (wheels,), rad/s; unlike w, their rate is without the
            damping torque s_1 dz/dt, so that they are smooth where the bristles are stiff.
        deflection: Deflections z of the bristles, (wheels,), rad.
        carrier: State of the carrier, any tree of arrays.
    """

    free_speed: PerWheel
    deflection: PerWheel
    carrier: Any


def error_scale(friction: Any, motion: Motion) -> Bristled:
    """Scale of the errors of each component of a state.

    Args:
        friction: Bristle friction of one wheel or of several.
        motion: State at the start.
    """
    ones = jnp.ones_like(motion.speed)
    curve_scale = friction.curve.speed_scale() * ones
    return Bristled(
        REST * jnp.where(jnp.isinf(curve_scale), SLOWEST, curve_scale),
        friction.level(0.0 * ones) / friction.stiffness,
        jax.tree.map(lambda y: jnp.full_like(y, CARRIER_SCALE), motion.carrier),
    )


def first_step(speed: PerWheel, acceleration: PerWheel, scale: Bristled) -> PerWheel:
    """Longest first step of each wheel, s, which does not step over the bend of a friction curve.

    Args:
        speed: Speed of one wheel or of several, rad/s.
        acceleration: Its rate of change, rad/s².
        scale: Scale of the errors.
    """
    rate = jnp.maximum(jnp.abs(acceleration), jnp.finfo(float).tiny)
    size, bend = jnp.abs(speed), scale.free_speed / REST
    step = FIRST_REACH * jnp.maximum(size, bend) / rate
    # from rest, the first step must resolve the deflection of the bristles
    rests = jnp.sqrt(scale.deflection / rate)
    return jnp.where(size < bend, jnp.minimum(step, rests), step)


class BristleEquations(eqx.Module):
    """Equations of motion of wheels with bristles over one interval.

    Attributes:
        contacts: Equations of motion of the wheels, with bristle friction.
        held: Whether each wheel is fixed to the carrier, (wheels,).
        holding: See `Modes`.
        mobility: Mobility with fixed wheels, (wheels, wheels), 1/(kg·m²); zero rows for them.
        inertia: Its inverse, (wheels, wheels), kg·m²; unit rows for fixed wheels.
        drag: Decrease of the drive torques with speed, (wheels,), N·m·s/rad.
        scale: Scale of the errors of each component.
    """

    contacts: CoupledBearings
    held: Bool[Array, " wheels"]
    holding: Float[Array, "wheels wheels"]
    mobility: Float[Array, "wheels wheels"]
    inertia: Float[Array, "wheels wheels"]
    drag: PerWheel
    scale: Bristled

    def damped(self, deflection: PerWheel) -> PerWheel:
        """Speeds M s_1 z, (wheels,), rad/s, of deflections or from rates of deflection."""
        return self.mobility @ (self.contacts.friction.damping * deflection)

    def speed(self, state: Bristled) -> PerWheel:
        """Wheel speeds, (wheels,), rad/s, or accelerations from the time derivative of a state."""
        return state.free_speed - self.damped(state.deflection)

    def rate(self, state: Bristled, time: Scalar) -> Bristled:
        """Time derivative of the state."""
        contacts, friction = self.contacts, self.contacts.friction
        motion = Motion(self.speed(state), state.carrier)
        drive, drift = contacts.drive(motion, time)
        bends = friction.deflection_rate(motion.speed, state.deflection)
        elastic = friction.stiffness * state.deflection + friction.viscous_torque(motion.speed)
        sliding = elastic + friction.damping * bends
        surplus = jnp.where(self.held, 0.0, drive - sliding)
        holding = drive + self.holding @ (contacts.mobility @ surplus + drift)
        torque = jnp.where(self.held, holding, sliding)
        carrier = contacts.carrier_rate(motion, torque, time)
        drift = drift - contacts.mobility @ (self.holding @ drift)
        pull = self.mobility @ (drive - elastic) + jnp.where(self.held, 0.0, drift)
        return Bristled(pull, bends, carrier)

    def solver(self, state: Bristled, step: Scalar):
        """Function r -> x with x / (GAMMA step) - A x = r.

        A is the derivative of the rates of speed and deflection by both, without the effect of the
        wheels on the drift, and without a falling friction torque, which would make the small
        symmetric system indefinite.
        """
        friction, held = self.contacts.friction, self.held
        speed, inverse_step = self.speed(state), 1.0 / (GAMMA * step)
        ones = jnp.ones_like(speed)
        slip, bend = jax.jvp(friction.slip_rate, (speed,), (ones,))
        viscous = jax.jvp(friction.viscous_torque, (speed,), (ones,))[1]
        by_speed = 1.0 - bend * state.deflection  # derivative of the deflection rate
        relaxed = 1.0 / (inverse_step + slip)
        elastic = (friction.stiffness + inverse_step * friction.damping) * relaxed
        stiff = jnp.maximum(elastic * by_speed + viscous + self.drag, 0.0)
        stiff = jnp.where(held, 0.0, stiff)
        inverse = inverse_definite(inverse_step * self.inertia + jnp.diag(stiff))

        def solve(right: Bristled) -> Bristled:
            pushed = jnp.where(held, 0.0, elastic * right.deflection)
            speed = inverse @ (self.inertia @ right.free_speed - pushed)
            deflection = relaxed * (right.deflection + by_speed * speed)
            return Bristled(
                speed + self.damped(deflection),
                deflection,
                jax.tree.map(lambda y: y / inverse_step, right.carrier),
            )

        return solve

    def crossing(self, state: Bristled, rate: Bristled, tolerance: Scalar) -> Scalar:
        """Time until the first wheel reaches zero speed, s; infinite if the bend has no effect.

        The rate of deflection has a bend at zero speed. A step that ends there does not contain it.
        """
        speed, pull = self.speed(state), self.speed(rate)
        nears = speed * pull < 0.0
        pull = jnp.where(nears, pull, 1.0)
        bend_error = self._bend_error(speed**2 / jnp.abs(pull), state.deflection)
        return jnp.min(jnp.where(nears & (bend_error > tolerance), -speed / pull, jnp.inf))

    def error(self, old: Bristled, new: Bristled, error: Bristled, step: Scalar) -> Scalar:
        """Largest relative error of a step."""
        worst = jnp.zeros(())
        leaves = (jax.tree.leaves(tree) for tree in (old, new, error, self.scale))
        for initial, final, deviation, scale in zip(*leaves, strict=True):
            size = jnp.maximum(jnp.maximum(jnp.abs(initial), jnp.abs(final)), scale)
            worst = jnp.maximum(worst, jnp.max(jnp.abs(deviation) / size))
        before, after = self.speed(old), self.speed(new)
        crosses = before * after < 0.0
        change = jnp.where(crosses, jnp.abs(after - before), 1.0)
        nearer = jnp.minimum(jnp.abs(before), jnp.abs(after))
        bend_error = self._bend_error(nearer**2 / change * step, old.deflection)
        return jnp.maximum(worst, jnp.max(jnp.where(crosses, bend_error, 0.0)))

    def _bend_error(self, angle: PerWheel, deflection: PerWheel) -> PerWheel:
        """Relative error of the deflections by a bend inside a step, from the angle beyond, rad."""
        scale = self.scale.deflection
        return angle / scale * jnp.abs(deflection) / scale

    def step_limits(self, state: Bristled) -> tuple[Scalar, Scalar]:
        """Longest first step and longest later step, s.

        The first step does not skip the curved part of a friction curve near rest. The later steps
        resolve the motion of the carrier.
        """
        rate = self.rate(state, jnp.zeros(()))
        before, change = (Motion(self.speed(y), y.carrier) for y in (state, rate))
        first = jnp.min(first_step(before.speed, change.speed, self.scale))
        turns = self.contacts.changes(before, change, jnp.zeros(())).turn_squared
        return first, TURN_STEP / jnp.sqrt(jnp.maximum(turns, 1e-18))


def bristle_equations(
    contacts: CoupledBearings, motion: Motion, held: Bool[Array, " wheels"]
) -> BristleEquations:
    """Equations of motion over an interval.

    Args:
        contacts: Equations of motion of the wheels, with bristle friction.
        motion: State at the start.
        held: Whether each wheel is fixed to the carrier, (wheels,).
    """
    free = ~held[:, None] & ~held
    unit = jnp.eye(len(held))
    inertia = jnp.where(free, inverse_definite(contacts.mobility), unit)

    def drive(speed: PerWheel) -> PerWheel:
        return contacts.drive(Motion(speed, motion.carrier), jnp.zeros(()))[0]

    return BristleEquations(
        contacts,
        held,
        contacts.modes(jnp.where(held, 0.0, 1.0)).holding,
        jnp.where(free, inverse_definite(inertia), 0.0),
        inertia,
        -jax.jvp(drive, (motion.speed,), (jnp.ones_like(motion.speed),))[1],
        jax.lax.stop_gradient(error_scale(contacts.friction, motion)),
    )
