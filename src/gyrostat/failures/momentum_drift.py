"""Drift of the feasible attitudes under a constant external torque."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.failures.attitudes import matrix_of
from gyrostat.failures.feasibility import Holdable
from gyrostat.failures.nearest_attitude import nearest_attitude
from gyrostat.failures.query import Case
from gyrostat.spacecraft import Spacecraft


@dataclass(frozen=True)
class MomentumDrift(Described):
    """Effect of an external torque on the attitude that is feasible at the failure.

    Attributes:
        torque: External torque, body axes, (3,), N·m.
        momentum: Change of the total momentum in the simulated time, torque times time, N·m·s.
        angle: Angle from the attitude that is feasible at the failure to the nearest one that is
            feasible at the end, rad; None if none is feasible then.
    """

    torque: tuple[float, ...]
    momentum: float
    angle: float | None


def momentum_drift(
    spacecraft: Spacecraft,
    start: Vector,
    failed: Mapping[int, float],
    answer: Holdable,
    torque: Vector,
    duration: float,
) -> MomentumDrift | None:
    """Drift while the body rests at the nearest feasible attitude.

    The momentum in body axes there is b + T t with the torque T. With two directions of wheel
    torque, normal n and failed momentum c along n, the feasible attitudes have n.b = c. Within the
    limits of the wheels the nearest one is then |acos(n.(b + T t)/|b + T t|) - acos(c/|b + T t|)|
    away, to first order |n.T| t over the momentum across n.

    Args:
        spacecraft: Spacecraft.
        start: Total momentum at the failure, inertial axes, (3,), N·m·s.
        failed: Index of each failed wheel -> the momentum that it keeps, N·m·s.
        answer: Feasibility at the failure.
        torque: External torque T, body axes, (3,), N·m.
        duration: Time t, s.

    Returns:
        The drift; None without torque, or if no attitude is feasible at the failure.
    """
    if answer.attitude is None or not np.any(torque):
        return None
    change = matrix_of(answer.attitude) @ torque * duration
    case = Case.of(spacecraft, np.asarray(start) + change, failed)
    rest = nearest_attitude(case, answer.attitude)
    angle = None if rest is None else rest.angle
    return MomentumDrift(tuple(torque.tolist()), float(np.linalg.norm(change)), angle)


def feasible_attitudes(
    spacecraft: Spacecraft, momenta: Matrix, failed: Mapping[int, float], target: Vector
) -> Matrix:
    """Feasible attitude nearest to a target for each momentum, (samples, 4).

    Args:
        spacecraft: Spacecraft.
        momenta: Total momenta, inertial axes, (samples, 3), N·m·s.
        failed: Index of each failed wheel -> the momentum that it keeps, N·m·s.
        target: Target, (4,), scalar first.

    Returns:
        The attitudes; NaN where none is feasible.
    """
    case = Case.of(spacecraft, momenta[0], failed)
    rests = [nearest_attitude(case.at(each), target) for each in momenta]
    return np.array([np.full(4, np.nan) if rest is None else rest.attitude for rest in rests])


def rates_of(attitudes: Matrix, period: float) -> Vector:
    """Rate of turn of a history of attitudes, (samples,), rad/s; at least two samples.

    Args:
        attitudes: Attitudes, (samples, 4), without a change of sign.
        period: Time between two samples, s.
    """
    return 2.0 * np.linalg.norm(np.gradient(attitudes, period, axis=0), axis=1)
