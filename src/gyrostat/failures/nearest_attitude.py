"""Feasible attitude nearest to a target attitude or boresight direction."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from gyrostat.core.directions import across
from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.attitudes import matrix_of, triad, turned
from gyrostat.failures.certificate import Certificate, certificate_at
from gyrostat.failures.momentum_envelope import TOLERANCE
from gyrostat.failures.query import Case
from gyrostat.failures.sky_map import angles, at_angle

ROLLS = 72
"""Number of roll angles tried if the boresight leaves the roll free."""


@dataclass(frozen=True)
class Rest:
    """Feasible attitude.

    Attributes:
        momentum: Total momentum in body axes at this attitude, (3,), N·m·s.
        angle: Angle from the wanted attitude or direction, rad.
        attitude: Attitude quaternion, (4,).
        direction: Inertial unit vector along the boresight, (3,); None without a boresight.
    """

    momentum: Vector
    angle: float
    attitude: Vector
    direction: Vector | None = None


def momentum_at(case: Case, attitude: Vector) -> Vector:
    """Total momentum in body axes, (3,), N·m·s, at an attitude (4,)."""
    return matrix_of(attitude).T @ case.momentum if case.radius else np.zeros(3)


def nearest_attitude(case: Case, target: Vector) -> Rest | None:
    """Feasible attitude at the smallest angle from a target (4,); None if there is none."""
    momentum = momentum_at(case, target)
    points = case.held.on_sphere(case.radius, momentum) if case.radius else _zero(case)
    if not len(points):
        return None
    away = angles(points, momentum)
    point = least_loaded(case, points[away <= np.min(away) + TOLERANCE])
    angle = float(angles(point, momentum))
    # shortest rotation, in body axes, from the target's momentum direction to the feasible one
    axis = np.cross(point, momentum)
    if np.linalg.norm(axis) <= TOLERANCE * case.radius**2:
        axis = across(momentum)
    return Rest(point, angle, turned(target, axis / np.linalg.norm(axis), angle))


def nearest_direction(case: Case, body: Vector, wanted: Vector) -> Rest | None:
    """Feasible attitude that points a boresight best, with the largest margin among those.

    Args:
        case: Validated query.
        body: Boresight in body axes, unit vector (3,).
        wanted: Inertial direction to point it at, unit vector (3,).

    Returns:
        The attitude; None if no attitude is feasible.
    """
    envelope, radius = case.held, case.radius
    if not radius:
        points = _zero(case)
        attitude = attitude_at_roll(case, body, wanted, np.zeros(3))
        return Rest(points[0], 0.0, attitude, wanted) if len(points) else None
    axis = case.momentum / radius
    polar = angle = float(angles(wanted, axis))
    points = at_angle(envelope, radius, body, polar)
    if not len(points):
        points = nearest_extremes(case, body, polar)
        if not len(points):
            return None
        angle = float(angles(points[0], body))
    elif envelope.rank == 3:
        every = _rolls(body, radius, polar, np.arange(10 * ROLLS) * np.pi / (5 * ROLLS))
        points = np.concatenate([points, every[envelope.holds(every, TOLERANCE * radius)]])
    point = least_loaded(case, points)
    direction, attitude = pointed(body, point, wanted, case.momentum, angle)
    return Rest(point, abs(angle - polar), attitude, direction)


def nearest_extremes(case: Case, body: Vector, polar: float) -> Matrix:
    """Momenta that the wheels hold, at the angle to a boresight nearest to a wanted one.

    Args:
        case: Validated query.
        body: Boresight in body axes, unit vector (3,).
        polar: Wanted angle between the momentum and the boresight, rad.

    Returns:
        Momenta in body axes, (M, 3), N·m·s; none if no attitude is feasible.
    """
    points = case.held.on_sphere(case.radius, body)
    if not len(points):
        return points
    away = np.abs(angles(points, body) - polar)
    return points[away <= np.min(away) + TOLERANCE]


def pointed(
    body: Vector, point: Vector, wanted: Vector, momentum: Vector, angle: Any
) -> tuple[Vector, Vector]:
    """Boresight at an angle to the momentum, turned from it towards a direction.

    Args:
        body: Boresight in body axes, unit vector (3,).
        point: Total momentum in body axes, (3,), N·m·s.
        wanted: Direction, inertial axes, unit vector (3,).
        momentum: Total momentum, inertial axes, (3,), N·m·s.
        angle: Angle between `point` and `body`, rad.

    Returns:
        Direction of the boresight, inertial axes, unit vector (3,); attitude, (4,).
    """
    axis = momentum / np.linalg.norm(momentum)
    perpendicular = wanted - np.cos(angles(wanted, axis)) * axis
    is_along = np.linalg.norm(perpendicular) <= TOLERANCE
    perpendicular = np.where(is_along, across(axis), perpendicular)
    unit = perpendicular / np.linalg.norm(perpendicular)
    direction = np.cos(angle) * axis + np.sin(angle) * unit
    return direction, triad(body, point, direction, momentum)


def certificate_of_roll(case: Case, body: Vector, wanted: Vector) -> Certificate:
    """Certificate at the roll angle with the lowest bound, for a boresight on its target."""
    certificate = partial(certificate_at, case.held, case.inertia)
    return certificate(best_roll(case, body, wanted, lambda momentum: certificate(momentum).rate))


def best_roll(case: Case, body: Vector, wanted: Vector, cost: Callable[[Vector], float]) -> Vector:
    """Total momentum, body axes, (3,), N·m·s, at the roll angle with the lowest cost.

    Args:
        case: Validated query.
        body: Boresight in body axes, unit vector (3,), pointed at its target.
        wanted: Inertial direction of the target, unit vector (3,).
        cost: Function of the total momentum in body axes, (3,), N·m·s.
    """
    if not case.radius:
        return np.zeros(3)
    polar = float(angles(wanted, case.momentum / case.radius))

    def momentum(roll: float) -> Vector:
        return _rolls(body, case.radius, polar, np.array([roll]))[0]

    from scipy.optimize import minimize_scalar  # slow to import

    step = 2.0 * np.pi / ROLLS
    centre = step * int(np.argmin([cost(momentum(step * k)) for k in range(ROLLS)]))
    bounds = (centre - step, centre + step)
    refined = minimize_scalar(lambda roll: cost(momentum(roll)), bounds=bounds, method="bounded")
    return momentum(float(refined.x))


def attitude_at_roll(case: Case, body: Vector, wanted: Vector, momentum: Vector) -> Vector:
    """Attitude (4,) that points a boresight at its target, at the roll angle of `best_roll`."""
    if not case.radius:
        return triad(body, across(body), wanted, across(wanted))
    return triad(body, momentum, wanted, case.momentum)


def _zero(case: Case) -> Matrix:
    """Solution without momentum: b = 0, if the wheels can hold it."""
    slack = TOLERANCE * float(np.linalg.norm(case.held.frozen))
    return np.zeros((1, 3))[case.held.holds(np.zeros((1, 3)), slack)]


def least_loaded(case: Case, points: Matrix) -> Vector:
    """Momentum of (M, 3), N·m·s, with the largest margin of the most loaded wheel."""
    return points[int(np.argmin(case.held.load(points)))]


def _rolls(body: Vector, radius: float, polar: float, roll: Vector) -> Matrix:
    """Momenta (M, 3) in body axes at a polar angle to the boresight and roll angles (M,)."""
    normal = across(body)
    around = np.outer(np.cos(roll), normal) + np.outer(np.sin(roll), np.cross(body, normal))
    return radius * (np.cos(polar) * body + np.sin(polar) * around)
