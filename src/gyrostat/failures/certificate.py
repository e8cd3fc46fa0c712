"""Infeasibility certificate: a lower bound on the body rate, and the dwell time.

With the momentum b = R'H0 in body axes and z what the wheels hold, the body turns at
w = J^-1 (b - z). A direction v that the set of all z does not exceed, v.z <= s(v), is a
certificate: v.(J w) = v.b - v.z >= v.b - s(v), and so

    |w| >= (v.b - s(v)) / |J v|,

whatever the wheels do. For two wheels without limits v is the normal n of their plane and s = c
the frozen momentum along it. The best v is found by least squares; the bound is then evaluated
from v alone, so that it holds even where the search is not exact.
"""

from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.optimize import brentq

from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.momentum_envelope import TOLERANCE, MomentumSet, box_least_squares, largest


@dataclass(frozen=True)
class Certificate:
    """A direction in which the wheels cannot take the momentum.

    Attributes:
        direction: (3,) unit, body axes; zero where nothing is left over.
        excess: momentum along it that the wheels cannot take, N·m·s.
        rate: least body rate that follows, rad/s.
    """

    direction: Vector
    excess: float
    rate: float


NOTHING = Certificate(np.zeros(3), 0.0, 0.0)


def certificate_at(held: MomentumSet, inertia: Matrix, momentum: Vector) -> Certificate:
    """The best certificate at one momentum (3,) in body axes, N·m·s.

    Exact: some momenta of the wheels within their limits do turn the body as slowly.
    """
    inverse = np.linalg.inv(inertia)
    beside = momentum - held.frozen
    rate = inverse @ (
        beside - held.axes @ box_least_squares(inverse @ held.axes, inverse @ beside, held.limits)
    )
    return _certificate(held, inertia, inverse @ rate, momentum)


def certificate_for_ever(held: MomentumSet, inertia: Matrix, radius: float) -> Certificate:
    """The certificate at every attitude, where the set misses the sphere |b| = radius, N·m·s.

    Where the least that the wheels hold is too much, v.(J w) <= |b| - v.z bounds the rate from
    below: the best v belongs to the smallest rate over the ball |b| <= radius. Where the most is
    too little, |J w| >= radius - most, and no direction is singled out.
    """
    if held.most < radius:
        excess = radius - held.most
        return Certificate(np.zeros(3), excess, excess / np.linalg.eigvalsh(inertia)[-1])
    if radius == 0.0:
        return certificate_at(held, inertia, np.zeros(3))
    inverse = np.linalg.inv(inertia)
    limits = np.concatenate([np.full(3, np.inf), held.limits])
    matrix = np.hstack([inverse, -inverse @ held.axes])
    size = float(np.linalg.norm(matrix))

    def closest(logarithm: float) -> tuple[Vector, Vector]:
        """Momentum and rate, where a penalty on |b| stands for its bound."""
        penalty = np.exp(logarithm) * np.eye(3, matrix.shape[1])
        rows = np.asarray(np.vstack([matrix, penalty]), dtype=np.float64)
        wanted = np.concatenate([inverse @ held.frozen, np.zeros(3)])
        solution = box_least_squares(rows, wanted, limits, size)
        return solution[:3], matrix @ solution - inverse @ held.frozen

    scale = np.log(1.0 / np.linalg.eigvalsh(inertia)[1])
    span = (scale - 18.0, scale + 18.0)

    def beyond(logarithm: float) -> float:
        return float(np.linalg.norm(closest(logarithm)[0])) - radius

    if beyond(span[0]) <= 0.0:
        return NOTHING
    root = span[1]
    if beyond(root) < 0.0:
        root = float(cast(float, brentq(beyond, *span, xtol=1e-10)))
    return _certificate(held, inertia, inverse @ closest(root)[1], radius)


def _certificate(
    held: MomentumSet, inertia: Matrix, direction: Vector, momentum: Vector | float
) -> Certificate:
    """Evaluate the bound of a direction at one momentum, or at all of one magnitude."""
    free = held.axes[:, ~np.isfinite(held.limits)]
    # rounding must not let a wheel without limits take everything
    direction = direction - free @ np.linalg.pinv(free, rcond=1e-6) @ direction
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return NOTHING
    direction = direction / length
    least = float(direction @ momentum) if np.ndim(momentum) else -float(momentum)
    excess = least - held.support(direction)
    if excess <= 0.0:
        return NOTHING
    return Certificate(direction, excess, excess / float(np.linalg.norm(inertia @ direction)))


def longest_dwell(
    held: MomentumSet,
    inertia: Matrix,
    momentum: Vector,
    certificate: Certificate,
    torque_limits: Vector,
    tolerance: float,
) -> float | None:
    """Upper bound of the time that the attitude can stay within a tolerance of the target, s.

    While the turn from the target is at most e, the momentum in body axes is within e of b, and the
    certificate v gives a rate of at least g about the body axis J v. With the vector part q of the
    turn's quaternion, |q| <= sin(e/2),

        d/dt (q.Jv/|Jv|) >= (g cos(e/2) - |w| sin(e/2)) / 2:

    a steady turn leaves after 2 e/g, but coning with the rate |w| makes up for some of it. The rate
    is at most w_max, by the limits of momentum; and while the attitude stays, by parts,

        cos(e) int |w|^2 <= sin(e) (2 w_max + T max |dw/dt|),  |dw/dt| <= (|b| |w| + u)/least J

    with the largest torque u of the wheels. To leading order staying for ever so needs an excess
    below e^1.5 sqrt(J u)/2.

    Args:
        held: what the wheels hold.
        inertia: (3, 3), kg·m².
        momentum: (3,) b at the target, body axes, N·m·s.
        certificate: of the target.
        torque_limits: (N,) of the working wheels, N·m.
        tolerance: e, rad, below pi/2.

    Returns:
        The bound; None where there is none: what can be held, or coned about, within the tolerance,
        and wheels whose momentum has no limit.
    """
    radius, slowest = float(np.linalg.norm(momentum)), float(np.linalg.eigvalsh(inertia)[0])
    direction = certificate.direction
    away = np.arctan2(np.linalg.norm(np.cross(direction, momentum)), float(direction @ momentum))
    excess = radius * np.cos(min(away + tolerance, np.pi)) - held.support(direction)
    if certificate.rate == 0.0 or excess <= TOLERANCE * radius or not np.isfinite(held.most):
        return None
    drift = excess / float(np.linalg.norm(inertia @ direction))
    sine, cosine = np.sin(0.5 * tolerance), np.cos(0.5 * tolerance)
    fastest = (radius + held.most) / slowest
    bounds = []
    if drift * cosine > fastest * sine:
        bounds.append(4.0 * sine / (drift * cosine - fastest * sine))
    torque = (
        largest(held.axes * torque_limits, np.zeros(3))
        if np.all(np.isfinite(torque_limits))
        else np.inf
    )
    # int |w| <= T L with L^2 = grow L + push + 2 tan(e) w_max / T
    grow, push = np.tan(tolerance) * radius / slowest, np.tan(tolerance) * torque / slowest
    # a T - 4 sine <= (sine/2) sqrt(d T^2 + f T): between the roots of a quadratic
    a, d, f = (
        drift * cosine - 0.5 * sine * grow,
        grow**2 + 4.0 * push,
        8.0 * np.tan(tolerance) * fastest,
    )
    first = a**2 - 0.25 * sine**2 * d
    if a > 0.0 and first > 0.0:
        half = 4.0 * sine * a + 0.125 * sine**2 * f
        bounds.append((half + np.sqrt(max(half**2 - 16.0 * sine**2 * first, 0.0))) / first)
    return min(bounds, default=None)
