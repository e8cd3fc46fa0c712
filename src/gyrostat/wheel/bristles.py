"""Step a wheel with bristle friction (LuGre, Dahl) by a stiff integrator."""

from typing import Any

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.bearing_equation import BearingEquation, Motion
from gyrostat.wheel.bristle_equations import error_scale, first_step
from gyrostat.wheel.rodas import integrate
from gyrostat.wheel.stepping import step_dry_friction

TOLERANCE = 1e-6
"""Largest error of a step, relative to the scales below or to the state, whichever is larger.

Measured on 64 closed-loop runs of Moreira, Lopes and Kuga, 300 s each: the error of the momentum is
within 8e-9 of its largest value. It would be within 1.3e-7 at 1e-5, and within 4e-10 at 1e-7.
"""


def step_bristles(
    contact: BearingEquation, motion: Motion, deflection: Scalar, duration: Scalar
) -> tuple[Motion, Float[Array, ""], Bool[Array, ""]]:
    """Advance a wheel with bristle friction, and its carrier, over one interval.

    Args:
        contact: Equations of motion with bristle friction.
        motion: State at the start.
        deflection: Deflection of the bristles at the start, rad.
        duration: Length of the interval, s.

    Returns:
        State and deflection at the end, and whether the requested accuracy was reached: False if it
        needed too many steps. Differentiable in forward mode.

    Raises:
        TypeError: The friction has no bristles.
    """
    friction = contact.friction.bristles
    if friction is None:
        raise TypeError(
            f"friction: found {type(contact.friction).__name__}, expected one with bristles"
        )

    def field(state: Any, time: Scalar) -> Any:
        speed, deflection, carrier = state
        torque = friction.torque(speed, deflection)
        return (
            (contact.load(carrier, time) - torque) / contact.inertia(),
            friction.deflection_rate(speed, deflection),
            contact.carrier_rate(carrier, speed, torque, time),
        )

    state = (motion.speed, deflection, motion.carrier)
    scale = error_scale(friction, motion)
    first = first_step(motion.speed, field(state, 0.0)[0], scale)
    scale, first = jax.lax.stop_gradient((scale, first))
    state, resolved = integrate(
        field, state, duration, scale=scale, tolerance=TOLERANCE, first=first
    )
    speed, deflection, carrier = state
    return Motion(speed, carrier), jnp.asarray(deflection), resolved


def step_wheel(
    contact: BearingEquation, motion: Motion, deflection: Scalar, duration: Scalar
) -> tuple[Motion, Scalar, Bool[Array, ""]]:
    """Advance a wheel with any friction model over one interval.

    Args:
        contact: Equations of motion.
        motion: State at the start.
        deflection: Deflection of the bristles at the start, rad; unchanged without bristles.
        duration: Length of the interval, s.

    Returns:
        State and deflection at the end, and whether the interval was resolved.
    """
    if contact.friction.bristles is not None:
        return step_bristles(contact, motion, deflection, duration)
    motion, resolved = step_dry_friction(contact, motion, duration)
    return motion, deflection, resolved
