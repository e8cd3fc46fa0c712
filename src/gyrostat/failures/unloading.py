"""Smallest change of the total momentum that makes a target feasible."""

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.failures.attitudes import matrix_of
from gyrostat.failures.momentum_envelope import MomentumSet, box_least_squares
from gyrostat.failures.nearest_attitude import attitude_at_roll, best_roll, momentum_at
from gyrostat.failures.query import Case


def excess_of(held: MomentumSet, momentum: Vector) -> Vector:
    """Difference between a momentum and the nearest one that the wheels can hold, (3,), N·m·s.

    Args:
        held: Momentum envelope of the wheels.
        momentum: Total momentum, body axes, (3,), N·m·s.
    """
    offset = momentum - held.frozen
    return offset - held.axes @ box_least_squares(held.axes, offset, held.limits)


def unload_at(case: Case, target: Vector) -> Vector:
    """Momentum to remove so that a target attitude can be held.

    Args:
        case: Validated query.
        target: Target attitude, (4,), scalar first.

    Returns:
        The smallest such momentum, inertial axes, (3,), N·m·s.
    """
    return matrix_of(target) @ excess_of(case.held, momentum_at(case, target))


def unload_for_boresight(case: Case, body: Vector, wanted: Vector) -> Vector:
    """Momentum to remove so that a boresight can be held on its target, at the best roll angle.

    Args:
        case: Validated query.
        body: Boresight in body axes, unit vector (3,).
        wanted: Inertial direction to point it at, unit vector (3,).

    Returns:
        The smallest such momentum, inertial axes, (3,), N·m·s.
    """

    def size(momentum: Vector) -> float:
        return float(np.linalg.norm(excess_of(case.held, momentum)))

    momentum = best_roll(case, body, wanted, size)
    return unload_at(case, attitude_at_roll(case, body, wanted, momentum))
