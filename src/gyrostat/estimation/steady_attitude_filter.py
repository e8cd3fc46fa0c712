"""Attitude and gyro bias from a star tracker and a gyro, with fixed gains."""

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
    """What the filter knows.

    Attributes:
        attitude: (4,) quaternion, scalar first.
        rate: (3,) of the gyro less its bias, rad/s.
        bias: (3,) of the gyro, rad/s.
        begun: whether a first sample has come.
    """

    attitude: Quaternion
    rate: Vector3
    bias: Vector3
    begun: Bool[Array, ""]


class SteadyAttitudeFilter(Checked):
    """The gyro carries the attitude, the star tracker pulls attitude and bias at a bandwidth w.

    e' = -2 w e - (bias error), (bias error)' = w^2 e: the gains that `AttitudeFilter` comes to
    where both poles are at -w. F. L. Markley, J. L. Crassidis, "Fundamentals of Spacecraft Attitude
    Determination and Control", section 6.2. With white noise sigma_s of the tracker and sigma_g of
    the gyro in samples T apart, w = sigma_g / (2 sigma_s) is near the best while the bias is
    constant.

    Attributes:
        bandwidth: w, rad/s.
    """

    bandwidth: Annotated[Scalar, positive("attitude filter bandwidth", "rad/s")] = 0.05

    def start(self) -> SteadyAttitudeEstimate:
        """Nothing known."""
        unit = jnp.array([1.0, 0.0, 0.0, 0.0])
        return SteadyAttitudeEstimate(unit, jnp.zeros(3), jnp.zeros(3), jnp.array(False))

    def __call__(
        self, estimate: SteadyAttitudeEstimate, attitude: Quaternion, rate: Vector3, period: Scalar
    ) -> SteadyAttitudeEstimate:
        """Take in a sample.

        Args:
            estimate: at the last sample.
            attitude: (4,) of the star tracker; the first one is taken as it is.
            rate: (3,) of the gyro, rad/s.
            period: since the last sample, s.
        """
        mean = 0.5 * (estimate.rate + rate - estimate.bias)
        carried = product(estimate.attitude, from_rotation_vector(period * mean))
        miss = rotation_vector(error(attitude, carried))
        pulled = product(carried, from_rotation_vector(2.0 * self.bandwidth * period * miss))
        bias = estimate.bias - self.bandwidth**2 * period * miss
        goes_on = SteadyAttitudeEstimate(normalised(pulled), rate - bias, bias, jnp.array(True))
        first = SteadyAttitudeEstimate(attitude, rate, estimate.bias, jnp.array(True))
        return jax.tree.map(lambda a, b: jnp.where(estimate.begun, a, b), goes_on, first)
