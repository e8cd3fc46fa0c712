"""Kalman filter for momentum under an unknown torque modelled as a random walk.

The kernel of the filters here. Two states, one scalar measurement of the momentum; everything in
closed form.
"""

from typing import NamedTuple

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class TorqueWalk(NamedTuple):
    """Momentum and torque with their covariance.

    Attributes:
        momentum: N·m·s.
        torque: N·m, positive where it raises the momentum.
        momentum_variance: (N·m·s)².
        covariance: of both, N²·m²·s.
        torque_variance: (N·m)².
    """

    momentum: Scalar
    torque: Scalar
    momentum_variance: Scalar
    covariance: Scalar
    torque_variance: Scalar


def predict(walk: TorqueWalk, drift: Scalar, period: Scalar, impulse: Scalar = 0.0) -> TorqueWalk:
    """Carry over a period; exact for a continuous random walk.

    Moreira, Lopes and Kuga, eqs. (11)-(13), with a known impulse in place of their control law.

    Args:
        walk: at the start.
        drift: standard deviation of the torque's change in the square root of a second, N·m/√s.
        period: s.
        impulse: of the known torque, N·m·s.
    """
    spread = drift**2 * period
    _, _, own, both, torque = walk
    return TorqueWalk(
        momentum=walk.momentum + impulse + period * walk.torque,
        torque=walk.torque,
        momentum_variance=own + period * (2.0 * both + period * (torque + spread / 3.0)),
        covariance=both + period * (torque + 0.5 * spread),
        torque_variance=torque + spread,
    )


def correct(walk: TorqueWalk, measured: Scalar, noise: Scalar) -> tuple[TorqueWalk, Scalar, Scalar]:
    """Take in a measured momentum. Moreira, Lopes and Kuga, eq. (14), with I - K H.

    Args:
        walk: predicted to the time of the measurement.
        measured: N·m·s.
        noise: its variance, (N·m·s)².

    Returns:
        The estimate, the innovation and its variance. Each variance is written so that it cannot
        lose its sign: as a product, or as what is left of the prior at no less than its share.
    """
    _, _, own, both, torque = walk
    total = own + noise
    innovation = measured - walk.momentum
    corrected = TorqueWalk(
        momentum=walk.momentum + own / total * innovation,
        torque=walk.torque + both / total * innovation,
        momentum_variance=own / total * noise,
        covariance=noise / total * both,
        torque_variance=jnp.maximum(torque - both**2 / total, torque * noise / total),
    )
    return corrected, innovation, total
