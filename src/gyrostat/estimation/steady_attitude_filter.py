"""Complementary filter for attitude and gyro bias, from star tracker and gyro, with fixed gains."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Bool

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import (
    error,
    from_rotation_vector,
    normalised,
    product,
    rotation_vector,
)


class SteadyAttitudeEstimate(NamedTuple):
    """State of the filter.

    Attributes:
        attitude: Attitude quaternion, (4,), scalar first.
        rate: Gyro rate minus bias, (3,), rad/s.
        bias: Gyro bias, (3,), rad/s.
        begun: Whether a first sample has been processed.
    """

    attitude: Quaternion
    rate: Vector3
    bias: Vector3
    begun: Bool[Array, ""]


class SteadyAttitudeFilter(Checked):
    """Propagate the attitude by the gyro; correct attitude and bias by the star tracker.

    With the bandwidth w, the errors obey e' = -2 w e - (bias error), (bias error)' = w^2 e. These
    are the steady gains of `AttitudeFilter` with both poles at -w: F. L. Markley, J. L. Crassidis,
    "Fundamentals of Spacecraft Attitude Determination and Control", section 6.2. For white noise
    sigma_s of the tracker and sigma_g of the gyro, w = sigma_g / (2 sigma_s) is near the optimum
    while the bias is constant.

    Attributes:
        bandwidth: Bandwidth w, rad/s.
    """

    bandwidth: Annotated[Scalar, positive("attitude filter bandwidth", "rad/s")] = 0.05

    def start(self) -> SteadyAttitudeEstimate:
        """Initial state, before the first sample."""
        unit = jnp.array([1.0, 0.0, 0.0, 0.0])
        return SteadyAttitudeEstimate(unit, jnp.zeros(3), jnp.zeros(3), jnp.array(False))

    def __call__(
        self, estimate: SteadyAttitudeEstimate, attitude: Quaternion, rate: Vector3, period: Scalar
    ) -> SteadyAttitudeEstimate:
        """Update with a sample of star tracker and gyro.

        Args:
            estimate: State at the previous sample.
            attitude: Attitude from the star tracker, (4,); the first one is used directly.
            rate: Rate from the gyro, (3,), rad/s.
            period: Time since the previous sample, s.
        """
        mean = 0.5 * (estimate.rate + rate - estimate.bias)
        prediction = product(estimate.attitude, from_rotation_vector(period * mean))
        innovation = rotation_vector(error(attitude, prediction))
        q = product(prediction, from_rotation_vector(2.0 * self.bandwidth * period * innovation))
        bias = estimate.bias - self.bandwidth**2 * period * innovation
        update = SteadyAttitudeEstimate(normalised(q), rate - bias, bias, jnp.array(True))
        start = SteadyAttitudeEstimate(attitude, rate, estimate.bias, jnp.array(True))
        return jax.tree.map(lambda a, b: jnp.where(estimate.begun, a, b), update, start)
