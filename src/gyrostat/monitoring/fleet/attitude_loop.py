"""Closed attitude loop of one body axis over several control periods, exactly.

Within a period the command holds, so that J w' = d - Kp theta - Kd w gives, with the state
(theta, w) and the period T,

    x(k+1) = F x(k) + g (d + n(k)),    g = (T²/2, T)/J,    F = [[1, T], [0, 1]] - g [Kp, Kd],

where n is the torque of measurement noise. Over m periods with a constant disturbance d, the
state is x(k+m) = F^m x + (sum F^j g) d + F^(m-1) g n(k) + noise of the other m - 1 samples.
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.fleet.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class AttitudeLoop:
    """Transition of the three axes over one step of m control periods.

    Attributes:
        step: Duration, s.
        stiffness: Gain of the attitude error, (3,), N·m/rad.
        damping: Gain of the rate error, (3,), N·m·s/rad.
        transition: (2, 2, 3).
        disturbance: Answer to a constant torque, (2, 3).
        first_noise: Answer to the noise torque of the first sample, (2, 3).
        later_noise: Factor of the covariance of the other samples' noise, (2, 2, 3).
        null_decay: Factor of the null-space error over the step.
        null_gain: Answer of the null-space momentum to a constant torque, s.
    """

    step: float
    stiffness: Vector
    damping: Vector
    transition: Matrix
    disturbance: Matrix
    first_noise: Matrix
    later_noise: Matrix
    null_decay: float
    null_gain: float


def attitude_loop(vehicle: Vehicle, periods: int) -> AttitudeLoop:
    """Transition over a number of control periods.

    Args:
        vehicle: Spacecraft with its loop.
        periods: Number of control periods in a step.
    """
    period = vehicle.control_period
    stiffness = vehicle.inertia * vehicle.bandwidth**2
    damping = 2.0 * vehicle.damping * vehicle.bandwidth * vehicle.inertia
    axes = [
        _axis(inertia, p, d, period, periods, (vehicle.attitude_sigma, vehicle.rate_sigma))
        for inertia, p, d in zip(vehicle.inertia, stiffness, damping, strict=True)
    ]
    transition, disturbance, first, later = (
        np.stack(parts, axis=-1) for parts in zip(*axes, strict=True)
    )
    decay = (1.0 - period / vehicle.null_time) ** periods
    return AttitudeLoop(
        periods * period,
        stiffness,
        damping,
        transition,
        disturbance,
        first,
        later,
        decay,
        vehicle.null_time * (1.0 - decay),
    )


def _axis(
    inertia: float,
    stiffness: float,
    damping: float,
    period: float,
    periods: int,
    sigmas: tuple[float, float],
) -> tuple[Matrix, Vector, Vector, Matrix]:
    push = np.array([0.5 * period**2, period]) / inertia
    one = np.array([[1.0, period], [0.0, 1.0]]) - np.outer(push, [stiffness, damping])
    answers = [np.linalg.matrix_power(one, k) @ push for k in range(periods)]
    variance = (stiffness * sigmas[0]) ** 2 + (damping * sigmas[1]) ** 2
    later = sum((np.outer(a, a) for a in answers[:-1]), np.zeros((2, 2))) * variance
    values, vectors = np.linalg.eigh(later)
    return (
        np.linalg.matrix_power(one, periods),
        np.sum(answers, axis=0),
        answers[-1],
        vectors * np.sqrt(np.maximum(values, 0.0)),
    )
