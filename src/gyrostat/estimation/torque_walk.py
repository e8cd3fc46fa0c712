"""Kalman filter for momentum under an unknown torque that is modelled as a random walk.

Common kernel of the momentum filters of this room: two states, one scalar measurement of the
momentum, all in closed form.
"""

from typing import NamedTuple

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class TorqueWalk(NamedTuple):
    """Momentum and torque with their covariance.

    Attributes:
        momentum: Momentum, N·m·s.
        torque: Torque, N·m, positive if it increases the momentum.
        momentum_variance: Variance of the momentum, (N·m·s)².
        covariance: Covariance of momentum and torque, N²·m²·s.
        torque_variance: Variance of the torque, (N·m)².
    """

    momentum: Scalar
    torque: Scalar
    momentum_variance: Scalar
    covariance: Scalar
    torque_variance: Scalar


def predict(walk: TorqueWalk, drift: Scalar, period: Scalar, impulse: Scalar = 0.0) -> TorqueWalk:
    """Predict over a period; exact for a continuous random walk.

    Moreira, Lopes and Kuga, eqs. (11)-(13), with a known impulse in place of their control law.

    Args:
        walk: State at the start of the period.
        drift: Random walk of the torque, N·m/√s.
        period: Period, s.
        impulse: Impulse of the known torque, N·m·s.
    """
    spread = drift**2 * period
    _, _, variance, covariance, torque_variance = walk
    return TorqueWalk(
        momentum=walk.momentum + impulse + period * walk.torque,
        torque=walk.torque,
        momentum_variance=variance
        + period * (2.0 * covariance + period * (torque_variance + spread / 3.0)),
        covariance=covariance + period * (torque_variance + 0.5 * spread),
        torque_variance=torque_variance + spread,
    )


def correct(walk: TorqueWalk, measured: Scalar, noise: Scalar) -> tuple[TorqueWalk, Scalar, Scalar]:
    """Update with a measured momentum. Moreira, Lopes and Kuga, eq. (14), with I - K H.

    Args:
        walk: State predicted to the time of the measurement.
        measured: Measured momentum, N·m·s.
        noise: Variance of the measurement, (N·m·s)².

    Returns:
        Updated state, innovation and innovation variance. Rounding cannot make a variance negative:
            the momentum variance is a product, the torque variance is bounded from below.
    """
    _, _, variance, covariance, torque_variance = walk
    total = variance + noise
    innovation = measured - walk.momentum
    corrected = TorqueWalk(
        momentum=walk.momentum + variance / total * innovation,
        torque=walk.torque + covariance / total * innovation,
        momentum_variance=variance / total * noise,
        covariance=noise / total * covariance,
        torque_variance=jnp.maximum(
            torque_variance - covariance**2 / total, torque_variance * noise / total
        ),
    )
    return corrected, innovation, total
