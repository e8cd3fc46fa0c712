"""Lower bound of the time of any rotation from rest to rest, with or without keep-out cones."""

import itertools
from typing import Any

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.guidance.slew import SlewLimits
from gyrostat.control.guidance.slew_profile import NO_LIMIT
from gyrostat.control.guidance.wheel_envelope import WheelRoom
from gyrostat.core import rotations
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.directions import spread_evenly
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite

HALVINGS = 60
"""Bisections of the bound."""
AXES = 200
"""Body axes whose ways are bounds."""


def shortest_time(turn: Vector3, limits: SlewLimits, room: WheelRoom | None) -> Scalar:
    """Lower bound of the time from rest to rest, s.

    A body axis b must turn by the angle between both of its directions, and only the part of the
    rate across b turns it; the whole rotation takes the whole rate. With J w' = -w x H - A u and
    J_c w = H - A h, no torque u and momentum h of the wheels, in whatever combination, gives more
    than |P w'| <= a_b + c |w| and |P w| <= w_b: P removes the part along b, a_b and w_b come from
    the corners of the torque and momentum polytopes, and c = |H| |J^-1|, Frobenius norm.
    The bound is the largest over many axes. It is in general not reached.

    Args:
        turn: Rotation vector in body axes, (3,), rad.
        limits: Limits of the slew; its jerk is left out.
        room: Wheels that it may use; None: they are not considered.
    """
    turn = jnp.asarray(turn, dtype=float)
    axes = jnp.asarray(np.concatenate([np.eye(3), spread_evenly(AXES)]))
    turned = jax.vmap(lambda b: rotations.to_body(rotations.from_rotation_vector(turn), b))(axes)
    angles = jax.vmap(rotations.angle_between)(axes, turned)
    angles = jnp.append(angles, jnp.sqrt(turn @ turn))
    across = jnp.concatenate([jnp.eye(3) - axes[:, :, None] * axes[:, None, :], jnp.eye(3)[None]])
    acceleration = jnp.minimum(jnp.asarray(limits.acceleration, dtype=float), NO_LIMIT)
    rate = jnp.minimum(jnp.asarray(limits.rate, dtype=float), NO_LIMIT)
    accelerations, rates = (jnp.full(len(angles), each) for each in (acceleration, rate))
    growth: Any = 0.0
    if room is not None:
        total = jnp.sqrt(room.total @ room.total)
        growth = total * _norm(inverse_definite(room.inertia))
        largest = _largest(across, room, room.inertia, room.torque)
        accelerations = jnp.minimum(accelerations, largest)
        held = total * _norm(inverse_definite(room.locked))
        rates = jnp.minimum(rates, _largest(across, room, room.locked, room.momentum) + held)
    # the last element has no axis: that of the whole rate
    extra = accelerations[-1]

    def reached(time: Array) -> Array:
        """Largest angles from rest."""
        ramp = jnp.minimum(time, rates / accelerations)
        x = growth * ramp
        safe = jnp.where(x > 1e-2, x, 1.0)
        series = x / 6.0 * (1.0 + x / 4.0 * (1.0 + x / 4.0))
        grown = jnp.where(x > 1e-2, (jnp.expm1(safe) - safe) / safe**2 - 0.5, series)
        return (0.5 * accelerations + extra * grown) * ramp**2 + rates * (time - ramp)

    def halve(_: int, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bounds
        middle = 0.5 * (low + high)
        is_enough = reached(middle) > 0.5 * angles
        return jnp.where(is_enough, low, middle), jnp.where(is_enough, middle, high)

    high = jnp.sqrt(angles / accelerations) + angles / rates
    low, _ = jax.lax.fori_loop(0, HALVINGS, halve, (jnp.zeros_like(high), high))
    return 2.0 * jnp.max(low)


def _largest(
    across: Float[Array, "axes 3 3"], room: WheelRoom, inertia: Array, each: Array
) -> Float[Array, " axes"]:
    """Largest rates or accelerations across each axis by corners of a polytope."""
    works = jnp.any(room.rows != 0.0, axis=1)
    # the pseudo-inverse of the pseudo-inverse: the axes of the working wheels
    axes = inverse_definite(room.rows.T @ room.rows) @ room.rows.T
    corners = np.array(list(itertools.product([1.0, -1.0], repeat=len(room.torque))))
    vectors = inverse_definite(inertia) @ axes @ (corners * (works * each)).T
    return jnp.max(jnp.sqrt(jnp.sum((across @ vectors) ** 2, axis=1)), axis=1)


def _norm(matrix: Array) -> Scalar:
    """Frobenius norm, which is at least the spectral one."""
    return jnp.sqrt(jnp.sum(matrix**2))
