"""Certificate at the best roll angle of a boresight, by loops alone, so that it can be compiled.

`certificate_of_roll` searches the same bound by a solver of bounded least squares. Here the nearest
momentum of the wheels is found on all faces of their limits: each wheel is at its lower limit, at
its upper one, or free, and the free ones, whose axes are independent, solve a least-squares problem
without bounds. The bound is evaluated from its direction, so that it holds however it was found.
"""

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from gyrostat.core.directions import across
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.momentum_envelope import RANK_TOLERANCE, TOLERANCE
from gyrostat.failures.nearest_attitude import ROLLS

_ROUNDS, _POINTS = 12, 9
"""Number of refinements of the roll, and of roll angles in each."""
_SLACK = 1e-12
"""Relative tolerance of a momentum at its limit."""


def roll_certificate(inertia: Matrix, axes: Matrix, body: Vector) -> Callable[..., Any]:
    """Function of momentum, direction, limits and frozen momentum that gives the certificate.

    Its arguments: total momentum, inertial axes, (3,), N·m·s, above 0; wanted direction of the
    boresight, inertial unit vector, (3,); momentum limit of each wheel, (wheels,), N·m·s, 0 for
    failed ones; momentum of the failed wheels, body axes, (3,), N·m·s. Its results: lower bound of
    the body rate, rad/s; momentum that the wheels cannot absorb, N·m·s, and its direction, body
    axes, (3,), all zero if there is no bound.

    Args:
        inertia: Inertia with locked wheels, (3, 3), kg·m².
        axes: Unit axes of all wheels, (3, wheels).
        body: Boresight in body axes, unit vector, (3,).
    """
    inverse = np.linalg.inv(inertia)
    columns = inverse @ axes
    signs, solvers = map(jnp.asarray, _faces(axes, columns))
    normal = across(body)
    other = np.cross(body, normal)

    def residual(offset: Any, limits: Any) -> Any:
        """Smallest rate that some momenta of the wheels leave, (3,), rad/s."""

        def face(k: Any, best: Any) -> Any:
            at_limit = jnp.where(signs[k] == 0.0, 0.0, signs[k] * limits)
            rest = inverse @ offset - columns @ jnp.where(jnp.isfinite(at_limit), at_limit, 0.0)
            momenta = solvers[k] @ rest
            is_possible = jnp.all(jnp.abs(momenta) <= limits * (1.0 + _SLACK))
            is_possible &= jnp.all(jnp.isfinite(at_limit))
            left = rest - columns @ momenta
            size = left @ left
            is_better = is_possible & (size < best[0])
            return jnp.where(is_better, size, best[0]), jnp.where(is_better, left, best[1])

        return jax.lax.fori_loop(0, len(signs), face, (jnp.inf, jnp.zeros(3)))[1]

    def certificate(momentum: Any, limits: Any, frozen: Any) -> tuple[Any, Any, Any]:
        direction = inverse @ residual(momentum - frozen, limits)
        length = jnp.sqrt(direction @ direction)
        direction = direction / jnp.where(length > 0.0, length, 1.0)
        across_axes = jnp.abs(direction @ axes)
        reach = jnp.where(across_axes > TOLERANCE, across_axes * limits, 0.0)
        excess = direction @ (momentum - frozen) - jnp.sum(reach)
        moved = inertia @ direction
        is_bound = (length > 0.0) & (excess > 0.0)
        rate = excess / jnp.where(is_bound, jnp.sqrt(moved @ moved), 1.0)
        rate, excess, direction = (
            jnp.where(is_bound, each, 0.0) for each in (rate, excess, direction)
        )
        return rate, excess, direction

    def at_best_roll(momentum: Any, wanted: Any, limits: Any, frozen: Any) -> tuple[Any, Any, Any]:
        radius = jnp.sqrt(momentum @ momentum)
        cosine = wanted @ momentum / radius
        turn = jnp.cross(wanted, momentum)
        sine = jnp.sqrt(turn @ turn) / radius

        def at(roll: Any) -> Any:
            around = jnp.cos(roll) * normal + jnp.sin(roll) * other
            return certificate(radius * (cosine * body + sine * around), limits, frozen)

        def least(first: Any, step: Any, count: int) -> Any:
            def point(k: Any, best: Any) -> Any:
                roll = first + step * k
                rate = at(roll)[0]
                return jnp.where(rate < best[0], rate, best[0]), jnp.where(
                    rate < best[0], roll, best[1]
                )

            return jax.lax.fori_loop(0, count, point, (jnp.inf, 0.0))[1]

        def refine(_: Any, state: Any) -> Any:
            roll, step = state
            smaller = 2.0 * step / (_POINTS - 1)
            return least(roll - step, smaller, _POINTS), smaller

        step = 2.0 * jnp.pi / ROLLS
        start = least(0.0, step, ROLLS), step
        return at(jax.lax.fori_loop(0, _ROUNDS, refine, start)[0])

    return at_best_roll


def _faces(axes: Matrix, columns: Matrix) -> tuple[np.ndarray, np.ndarray]:
    """Sign of each wheel on each face, (faces, wheels), 0 if it is free; solution of the free ones.

    The solution maps a rate to their momenta, (faces, wheels, 3), zero for the others.
    """
    signs, solvers = [], []
    for face in product((0.0, -1.0, 1.0), repeat=axes.shape[1]):
        free = np.array(face) == 0.0
        if np.linalg.matrix_rank(axes[:, free], tol=RANK_TOLERANCE) == np.sum(free):
            solver = np.zeros((axes.shape[1], 3))
            solver[free] = np.linalg.pinv(columns[:, free])
            signs.append(face)
            solvers.append(solver)
    return np.array(signs), np.array(solvers)
