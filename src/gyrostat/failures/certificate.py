"""Infeasibility certificate: a lower bound on the body rate, and the dwell time.

Let b = R'H0 be the total momentum in body axes and z the momentum of the wheels. The body rate is
w = J^-1 (b - z). Let s(v) be the largest v.z over all z that the wheels can have (the support
function of the momentum envelope). Every direction v is a certificate: since
v.(J w) = v.b - v.z >= v.b - s(v),

    |w| >= (v.b - s(v)) / |J v|

for every control law. For two wheels without limits, v is the normal n of their plane and s = c is
the frozen momentum along n. The best v is found by least squares. The bound is then evaluated from
v alone, so that it holds even if the search was not exact.
"""

from dataclasses import dataclass
from typing import cast

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.momentum_envelope import TOLERANCE, MomentumSet, box_least_squares, largest


@dataclass(frozen=True)
class Certificate(Described):
    """Direction in which the wheels cannot absorb the total momentum.

    Attributes:
        direction: Unit vector in body axes, (3,); zero if the wheels can absorb everything.
        excess: Momentum along `direction` that the wheels cannot absorb, N·m·s.
        rate: Lower bound of the body rate, rad/s.
    """

    direction: Vector
    excess: float
    rate: float


NOTHING = Certificate(np.zeros(3), 0.0, 0.0)


def certificate_at(held: MomentumSet, inertia: Matrix, momentum: Vector) -> Certificate:
    """Best certificate at one momentum (3,) in body axes, N·m·s.

    The bound is attained: some wheel momenta within the limits give exactly this body rate.
    """
    inverse = np.linalg.inv(inertia)
    offset = momentum - held.frozen
    rate = inverse @ (
        offset - held.axes @ box_least_squares(inverse @ held.axes, inverse @ offset, held.limits)
    )
    return _certificate(held, inertia, inverse @ rate, momentum)


def certificate_for_ever(held: MomentumSet, inertia: Matrix, radius: float) -> Certificate:
    """Certificate at every attitude, if the envelope does not meet the sphere |b| = radius, N·m·s.

    If the smallest momentum of the wheels is too large, v.(J w) <= |b| - v.z bounds the rate from
    below, and the best v belongs to the smallest rate over the ball |b| <= radius. If their largest
    momentum is too small, |J w| >= radius - most; this bound has no direction.
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

    def minimiser(logarithm: float) -> tuple[Vector, Vector]:
        """Momentum and rate that minimise the rate, with a penalty on |b| instead of its bound."""
        penalty = np.exp(logarithm) * np.eye(3, matrix.shape[1])
        rows = np.asarray(np.vstack([matrix, penalty]), dtype=np.float64)
        target = np.concatenate([inverse @ held.frozen, np.zeros(3)])
        solution = box_least_squares(rows, target, limits, size)
        return solution[:3], matrix @ solution - inverse @ held.frozen

    scale = np.log(1.0 / np.linalg.eigvalsh(inertia)[1])
    span = (scale - 18.0, scale + 18.0)

    def overshoot(logarithm: float) -> float:
        return float(np.linalg.norm(minimiser(logarithm)[0])) - radius

    if overshoot(span[0]) <= 0.0:
        return NOTHING
    root = span[1]
    if overshoot(root) < 0.0:
        from scipy.optimize import brentq  # slow to import

        root = float(cast(float, brentq(overshoot, *span, xtol=1e-10)))
    return _certificate(held, inertia, inverse @ minimiser(root)[1], radius)


def _certificate(
    envelope: MomentumSet, inertia: Matrix, direction: Vector, momentum: Vector | float
) -> Certificate:
    """Evaluate the bound of a direction for one momentum, or for all momenta of one magnitude."""
    free_axes = envelope.axes[:, ~np.isfinite(envelope.limits)]
    # rounding errors must not let a wheel without limits absorb everything
    direction = direction - free_axes @ np.linalg.pinv(free_axes, rcond=1e-6) @ direction
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return NOTHING
    direction = direction / length
    component = float(direction @ momentum) if np.ndim(momentum) else -float(momentum)
    excess = component - envelope.support(direction)
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

    While the rotation from the target is at most e, the momentum in body axes is within the angle e
    of b, and the certificate v gives a rate of at least g about the body axis J v. For the vector
    part q of the rotation's quaternion, |q| <= sin(e/2), so that

        d/dt (q.Jv/|Jv|) >= (g cos(e/2) - |w| sin(e/2)) / 2.

    A steady rotation leaves the tolerance after 2 e/g. Coning at the rate |w| can delay this. The
    rate is at most w_max because the wheel momenta are limited. While the attitude stays within e,
    integration by parts gives

        cos(e) int |w|^2 <= sin(e) (2 w_max + T max |dw/dt|),  |dw/dt| <= (|b| |w| + u)/least J

    with the largest torque u of the wheels. To leading order, staying for ever requires an excess
    below e^1.5 sqrt(J u)/2.

    Args:
        held: Momentum envelope of the wheels.
        inertia: Inertia, (3, 3), kg·m².
        momentum: Total momentum b at the target, (3,), body axes, N·m·s.
        certificate: Certificate at the target.
        torque_limits: Torque limits of the working wheels, (N,), N·m.
        tolerance: Tolerance e, rad, below pi/2.

    Returns:
        The bound. None if there is no bound: the attitude is feasible, coning within the tolerance
        is possible, or a wheel has no momentum limit.
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
    torque = largest(held.axes, torque_limits, np.zeros(3))
    # int |w| <= T L with L^2 = grow L + push + 2 tan(e) w_max / T
    grow, push = np.tan(tolerance) * radius / slowest, np.tan(tolerance) * torque / slowest
    # a T - 4 sine <= (sine/2) sqrt(d T^2 + f T): T lies between the roots of a quadratic
    a = drift * cosine - 0.5 * sine * grow
    d, f = grow**2 + 4.0 * push, 8.0 * np.tan(tolerance) * fastest
    leading = a**2 - 0.25 * sine**2 * d
    if a > 0.0 and leading > 0.0:
        half = 4.0 * sine * a + 0.125 * sine**2 * f
        bounds.append((half + np.sqrt(max(half**2 - 16.0 * sine**2 * leading, 0.0))) / leading)
    return min(bounds, default=None)
