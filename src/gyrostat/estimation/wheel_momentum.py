"""Wheel speed from the total momentum of wheel and table, independent of friction."""

from typing import Annotated, Any, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation.torque_walk import TorqueWalk, correct, predict

UNKNOWN_TORQUE = 10.0
"""Initial standard deviation of the external torque, in units of the torque that the
tachometer resolves within one second."""

MEMORY = 20.0
"""Time constant of the running mean of the innovations, samples."""
SURPRISE = 4.0
"""Running mean, in its standard deviations, at which a jump of the external torque is declared."""
JUMP = 0.3
"""Standard deviation added at such a jump, in the same units as `UNKNOWN_TORQUE`."""


class MomentumEstimate(NamedTuple):
    """Momentum of table and wheel, and the external torque that changes it.

    Attributes:
        momentum: Total momentum h, N·m·s.
        torque: External torque T_d, N·m.
        momentum_variance: Variance of the momentum, (N·m·s)².
        covariance: Covariance of momentum and torque, N²·m²·s.
        torque_variance: Variance of the torque, (N·m)².
        surprise: Running mean of the innovations, each divided by its standard deviation.
        started: 1 after the first measurement, before that 0.
    """

    momentum: Scalar
    torque: Scalar
    momentum_variance: Scalar
    covariance: Scalar
    torque_variance: Scalar
    surprise: Scalar
    started: Scalar


class MomentumFilter(Checked):
    """Kalman filter of a measured momentum that only an external torque changes.

    The external torque is a random walk. If the mean of the innovations shows that it has jumped,
    its variance grows. Every field may be an array: one filter for each element.

    Attributes:
        momentum_sigma: Standard deviation of a measured momentum, N·m·s.
        torque_drift: Random walk of the external torque, N·m/√s.
    """

    momentum_sigma: Annotated[Scalar | Float[Array, " filters"], positive("momentum sigma")]
    torque_drift: Scalar | Float[Array, " filters"]

    def start(self, *shape: int) -> MomentumEstimate:
        """Initial estimate, before the first measurement, for an array of filters or for one."""
        return MomentumEstimate(*(jnp.zeros(shape),) * len(MomentumEstimate._fields))

    def predict(self, estimate: MomentumEstimate, period: Scalar) -> MomentumEstimate:
        """Predict over a period, s."""
        walk = predict(TorqueWalk(*estimate[:5]), self.torque_drift, period)
        return MomentumEstimate(*walk, *estimate[5:])

    def correct(self, estimate: MomentumEstimate, measured: Any) -> MomentumEstimate:
        """Update with a measured momentum, N·m·s, at the time of the estimate."""
        noise = self.momentum_sigma**2
        walk, innovation, variance = correct(TorqueWalk(*estimate[:5]), measured, noise)
        mean = estimate.surprise + (innovation / jnp.sqrt(variance) - estimate.surprise) / MEMORY
        # variance of an exponential mean of white innovations with this time constant
        surprised = mean**2 > SURPRISE**2 / (2.0 * MEMORY - 1.0)
        jump = jnp.where(surprised, JUMP**2 * noise, 0.0)
        walk = walk._replace(torque_variance=walk.torque_variance + jump)
        zero, one = jnp.zeros_like(innovation), jnp.ones_like(innovation)
        update = MomentumEstimate(*walk, jnp.where(surprised, 0.0, mean), one)
        start = MomentumEstimate(measured, zero, noise, zero, UNKNOWN_TORQUE**2 * noise, zero, one)
        begins = estimate.started == 0.0
        return jax.tree.map(lambda a, b: jnp.where(begins, a, b), start, update)


class WheelMomentumFilter(Checked):
    """Kalman filter for h = J_w w + (J + J_w) Ω, which only the external torque changes.

    Friction is an internal torque and does not appear, so that errors of a friction model cannot
    bias the estimate. The measurement of h is the sum of tachometer and gyro terms; since the gyro
    measures (J + J_w) Ω far better than the tachometer measures J_w w, its noise is that of the
    tachometer. The external torque is a random walk. The wheel speed w = (h - (J + J_w) Ω) / J_w
    follows the gyro without delay and has the low noise of the momentum estimate.

    Attributes:
        wheel_inertia: Rotor inertia J_w, kg·m².
        table_inertia: Inertia J of the table without the rotor, kg·m².
        speed_sigma: Standard deviation of a tachometer sample, rad/s.
        torque_drift: Random walk of the external torque, N·m/√s.
    """

    wheel_inertia: Annotated[Scalar, positive("compensator wheel inertia")]
    table_inertia: Annotated[Scalar, positive("compensator table inertia")]
    speed_sigma: Annotated[Scalar, positive("compensator speed sigma")]
    torque_drift: Scalar

    def _filter(self) -> MomentumFilter:
        return MomentumFilter(self.wheel_inertia * self.speed_sigma, self.torque_drift)

    def start(self) -> MomentumEstimate:
        """Initial estimate, before the first measurement."""
        return self._filter().start()

    def predict(self, estimate: MomentumEstimate, period: Scalar) -> MomentumEstimate:
        """Predict over a period, s."""
        return self._filter().predict(estimate, period)

    def correct(self, estimate: MomentumEstimate, speed: Scalar, rate: Scalar) -> MomentumEstimate:
        """Update with a sample of tachometer and gyro.

        Args:
            estimate: Estimate predicted to the time of the sample.
            speed: Measured wheel speed, rad/s.
            rate: Measured table rate, rad/s.
        """
        momentum = self.wheel_inertia * speed + (self.table_inertia + self.wheel_inertia) * rate
        return self._filter().correct(estimate, momentum)

    def speed(self, estimate: MomentumEstimate, rate: Scalar) -> tuple[Scalar, Scalar]:
        """Wheel speed at a given table rate, rad/s, and its standard deviation, rad/s."""
        total_inertia = self.table_inertia + self.wheel_inertia
        speed = (estimate.momentum - total_inertia * rate) / self.wheel_inertia
        return speed, jnp.sqrt(estimate.momentum_variance) / self.wheel_inertia
