"""Estimate wheel speed from the momentum of wheel and table, independent of friction."""

from typing import Annotated, NamedTuple

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jnp
from gyrostat.estimation.torque_walk import TorqueWalk, correct, predict

UNKNOWN_TORQUE = 10.0
"""First standard deviation of the external torque over what the tachometer can tell in a second."""

MEMORY = 20.0
"""Samples in the running mean of the innovations."""
SURPRISE = 4.0
"""Standard deviations of that mean at which the external torque is taken to have jumped."""
JUMP = 0.3
"""Standard deviation of such a jump over what the tachometer can tell in a second."""


class MomentumEstimate(NamedTuple):
    """Momentum of table and wheel, and the external torque that changes it.

    Attributes:
        momentum: h, N·m·s.
        torque: external torque T_d, N·m.
        momentum_variance: (N·m·s)².
        covariance: of momentum and torque, N²·m²·s.
        torque_variance: (N·m)².
        surprise: running mean of the innovations over their standard deviation.
        started: 1 once a measurement has been taken, else 0.
    """

    momentum: Scalar
    torque: Scalar
    momentum_variance: Scalar
    covariance: Scalar
    torque_variance: Scalar
    surprise: Scalar
    started: Scalar


class WheelMomentumFilter(Checked):
    """Kalman filter on h = J_w w + (J + J_w) Ω, which only the external torque changes.

    Friction is internal: it does not appear, so that no error of a friction model can bias the
    estimate. The gyro tells (J + J_w) Ω far better than the tachometer tells J_w w; their sum is
    the measurement of h, with the noise of the tachometer. The torque is a random walk. The speed
    follows as w = (h - (J + J_w) Ω) / J_w, as quick as the gyro and as calm as the momentum.

    Attributes:
        wheel_inertia: J_w, kg·m².
        table_inertia: J, without the rotor, kg·m².
        speed_sigma: noise of a sample of the tachometer, rad/s.
        torque_drift: of the external torque in the square root of a second, N·m/√s.
    """

    wheel_inertia: Annotated[Scalar, positive("compensator wheel inertia")]
    table_inertia: Annotated[Scalar, positive("compensator table inertia")]
    speed_sigma: Annotated[Scalar, positive("compensator speed sigma")]
    torque_drift: Scalar

    def start(self) -> MomentumEstimate:
        """Nothing known."""
        zero = jnp.array(0.0)
        return MomentumEstimate(*(zero,) * len(MomentumEstimate._fields))

    def predict(self, estimate: MomentumEstimate, period: Scalar) -> MomentumEstimate:
        """Carry an estimate over a period, s."""
        walk = predict(TorqueWalk(*estimate[:5]), self.torque_drift, period)
        return MomentumEstimate(*walk, *estimate[5:])

    def correct(self, estimate: MomentumEstimate, speed: Scalar, rate: Scalar) -> MomentumEstimate:
        """Take in a sample of tachometer and gyro.

        Args:
            estimate: predicted to the time of the sample.
            speed: of the wheel, rad/s.
            rate: of the table, rad/s.
        """
        measured = self.wheel_inertia * speed + (self.table_inertia + self.wheel_inertia) * rate
        noise = (self.wheel_inertia * self.speed_sigma) ** 2
        walk, innovation, variance = correct(TorqueWalk(*estimate[:5]), measured, noise)
        mean = estimate.surprise + (innovation / jnp.sqrt(variance) - estimate.surprise) / MEMORY
        # a mean of white innovations over this memory has this variance
        surprised = mean**2 > SURPRISE**2 / (2.0 * MEMORY - 1.0)
        jump = jnp.where(surprised, JUMP**2 * noise, 0.0)
        walk = walk._replace(torque_variance=walk.torque_variance + jump)
        zero, one = jnp.zeros_like(innovation), jnp.ones_like(innovation)
        goes_on = MomentumEstimate(*walk, jnp.where(surprised, 0.0, mean), one)
        first = MomentumEstimate(measured, zero, noise, zero, UNKNOWN_TORQUE**2 * noise, zero, one)
        begins = estimate.started == 0.0
        return MomentumEstimate(
            *(jnp.where(begins, a, b) for a, b in zip(first, goes_on, strict=True))
        )

    def speed(self, estimate: MomentumEstimate, rate: Scalar) -> tuple[Scalar, Scalar]:
        """Wheel speed at a table rate, rad/s, and its standard deviation."""
        whole = self.table_inertia + self.wheel_inertia
        speed = (estimate.momentum - whole * rate) / self.wheel_inertia
        return speed, jnp.sqrt(estimate.momentum_variance) / self.wheel_inertia
