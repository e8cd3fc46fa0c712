"""Kalman filter for the friction torque of a wheel from its momentum, without a friction model."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import require
from gyrostat.estimation.torque_walk import TorqueWalk, correct, predict


class FrictionTorqueEstimate(NamedTuple):
    """State of the filter.

    Attributes:
        walk: Momentum, and the torque on it, which is the negative friction torque.
        innovation: Innovation of the last measurement, N·m·s.
        innovation_variance: Variance of the innovation, (N·m·s)².
        missed: Number of measurements that were not finite and therefore skipped.
    """

    walk: TorqueWalk
    innovation: Scalar
    innovation_variance: Scalar
    missed: Scalar

    @property
    def momentum(self) -> Scalar:
        """Wheel momentum, N·m·s."""
        return self.walk.momentum

    @property
    def friction(self) -> Scalar:
        """Friction torque, N·m."""
        return -self.walk.torque


class FrictionTorqueFilter(Checked):
    """Kalman filter with states momentum h and friction torque N: h' = u - N, N' = noise.

    Moreira, Lopes and Kuga, "Estimation of torque in a reaction wheel using a bristle model for
    friction", eqs. (6)-(7), (11)-(14), (17).

    Attributes:
        momentum_sigma: Standard deviation rho of a measured momentum, N·m·s.
        torque_drift: Random walk rho_1 of the friction torque, N·m/√s.
        initial_sigma: Standard deviation rho_0 of both states before the first measurement, N·m·s
            and N·m.
    """

    momentum_sigma: Annotated[Scalar, positive("momentum_sigma")]
    torque_drift: Annotated[Scalar, positive("torque_drift")]
    initial_sigma: Annotated[Scalar, positive("initial_sigma")]

    def start(self, momentum: Scalar = 0.0, friction: Scalar = 0.0) -> FrictionTorqueEstimate:
        """Initial state, before the first measurement."""
        variance, zero = self.initial_sigma**2, jnp.array(0.0)
        momentum, torque = jnp.asarray(momentum, float), -jnp.asarray(friction, float)
        walk = TorqueWalk(momentum, torque, variance, zero, variance)
        return FrictionTorqueEstimate(walk, zero, zero, zero)

    def predict(
        self, estimate: FrictionTorqueEstimate, impulse: Scalar, period: Scalar
    ) -> FrictionTorqueEstimate:
        """Predict over a period, s, with the impulse of the motor torque, N·m·s."""
        return estimate._replace(walk=predict(estimate.walk, self.torque_drift, period, impulse))

    def correct(self, estimate: FrictionTorqueEstimate, momentum: Scalar) -> FrictionTorqueEstimate:
        """Update with a measured momentum, N·m·s; a non-finite value is counted and skipped."""
        valid = jnp.isfinite(momentum)
        sample = jnp.where(valid, momentum, 0.0)
        walk, innovation, variance = correct(estimate.walk, sample, self.momentum_sigma**2)
        return FrictionTorqueEstimate(
            jax.tree.map(lambda new, old: jnp.where(valid, new, old), walk, estimate.walk),
            jnp.where(valid, innovation, 0.0),
            jnp.where(valid, variance, 0.0),
            estimate.missed + jnp.where(valid, 0.0, 1.0),
        )

    def steady_gain(self, period: float) -> Float[Array, " 2"]:
        """Steady-state gain for momentum and friction torque, in closed form.

        With the delay operator d, the second difference of the measured momentum is
        1 + a d + (1 - K) d² acting on the innovations. It is also the second difference of noise
        and random walk. Equating the spectra at zero frequency and at half the sampling rate gives
        s² = 1 - K, the posterior momentum variance over the variance of a measurement.

        Args:
            period: Time between measurements, s, above 0.

        Returns:
            Gain of h, 1, and of N, 1/s, (2,).

        Raises:
            InputError: The period is not above zero.
        """
        require("period", period, "s", positive=True)
        slow = self.torque_drift * period**1.5 / self.momentum_sigma
        fast = jnp.sqrt(16.0 + slow**2 / 3.0)
        # 2 s² - (slow + fast) s + 2 = 0; K = (1 - s) (1 + s) avoids cancellation
        root = jnp.sqrt(4.0 / 3.0 * slow**2 + 2.0 * slow * fast)
        s = 4.0 / (slow + fast + root)
        complement = (slow + slow**2 / 3.0 / (fast + 4.0) + root) / (slow + fast + root)
        return jnp.stack([complement * (1.0 + s), -s * slow / period])
