"""Bearing friction of the wheels of a spacecraft, a static curve or bristles."""

from typing import Any

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import normalised
from gyrostat.spacecraft.flexible.coupling import with_names
from gyrostat.spacecraft.gyrostat_state import GyrostatState
from gyrostat.spacecraft.wheels_on_body import Carrier, WheelsOnBody
from gyrostat.wheel import Motion, step_coupled_bristles, step_coupled_wheels
from gyrostat.wheel.friction import AnyFriction


def started_deflection(friction: AnyFriction, speed: PerWheel, given: Any) -> PerWheel | None:
    """Deflections of the bristles at the start, (wheels,), rad; None without bristles.

    Args:
        friction: Friction of the wheels.
        speed: Wheel speeds, (wheels,), rad/s.
        given: Deflections, (wheels,), or one value for all, rad; None for those of steady rotation.

    Raises:
        InputError: Deflections are given, and the friction has no bristles.
    """
    if friction.bristles is not None:
        deflection = friction.bristles.steady_deflection(speed) if given is None else given
        return jnp.broadcast_to(jnp.asarray(deflection, dtype=float), speed.shape)
    if given is not None:
        raise InputError(f"deflection: found one, expected none with {friction.name} friction")
    return None


def check_deflection(friction: AnyFriction, state: GyrostatState) -> None:
    """Validate the deflections of the bristles.

    Raises:
        InputError: They are missing, not finite, or given without bristles.
    """
    has_deflection = state.deflection is not None
    if has_deflection != (friction.bristles is not None):
        words = ("one", "none") if has_deflection else ("none", "those of the bristles, rad")
        raise InputError(f"deflection: found {words[0]}, expected {words[1]}")
    if has_deflection and not np.all(np.isfinite(np.asarray(state.deflection))):
        raise InputError("deflection: found one that is not finite, expected finite ones, rad")


def net_torque(friction: AnyFriction, torque: PerWheel, state: Any) -> PerWheel:
    """Motor torques less friction, (wheels,), N·m; zero for wheels that stick.

    Args:
        friction: Friction of the wheels.
        torque: Motor torques, (wheels,), N·m.
        state: State of the spacecraft, a `GyrostatState`.
    """
    speed = jnp.asarray(state.wheel_speed)
    if friction.bristles is not None:
        return torque - friction.bristles.torque(speed, state.deflection)
    # a wheel at rest moves with the body
    return jnp.where(speed == 0.0, 0.0, torque - friction.torque(speed, jnp.sign(speed)))


def advanced(
    contacts: WheelsOnBody, state: GyrostatState, duration: Scalar
) -> tuple[GyrostatState, Bool[Array, ""]]:
    """State at the end of an interval, s, and whether the interval was resolved.

    Args:
        contacts: Equations of motion over the interval.
        state: State at the start.
        duration: Length of the interval, s.
    """
    motion: Motion = Motion(state.wheel_speed, Carrier.of(state))
    deflection: Any = state.deflection
    if contacts.friction.bristles is not None:
        motion, deflection, resolved = step_coupled_bristles(
            contacts, motion, deflection, contacts.seized, duration
        )
    else:
        motion, resolved = step_coupled_wheels(contacts, motion, duration)
    attitude, momentum, modal = motion.carrier
    after = GyrostatState(normalised(attitude), momentum, motion.speed, **with_names(modal))
    return after._replace(deflection=deflection), resolved
