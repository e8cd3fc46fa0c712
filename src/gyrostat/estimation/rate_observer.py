"""Extended state observer of body rate and disturbance torque."""

from typing import Annotated, NamedTuple

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jnp


class RateEstimate(NamedTuple):
    """Rate and unknown torque.

    Attributes:
        rate: rad/s.
        torque: everything that the known torque leaves out, N·m.
    """

    rate: Scalar
    torque: Scalar


class RateObserver(Checked):
    """J dΩ/dt = known torque + d, d constant; both poles at the bandwidth.

    J. Han, "From PID to active disturbance rejection control", IEEE Transactions on Industrial
    Electronics 56 (2009), the linear extended state observer, here with the rate measured.

    Attributes:
        inertia: J, kg·m².
        bandwidth: rad/s.
    """

    inertia: Annotated[Scalar, positive("compensator table inertia")]
    bandwidth: Annotated[Scalar, positive("compensator bandwidth")]

    def start(self) -> RateEstimate:
        """At rest, nothing acting."""
        return RateEstimate(jnp.array(0.0), jnp.array(0.0))

    def predict(self, estimate: RateEstimate, known: Scalar, period: Scalar) -> RateEstimate:
        """Carry an estimate over a period, s, in which a known torque, N·m, acts."""
        step = period * (known + estimate.torque) / self.inertia
        return RateEstimate(estimate.rate + step, estimate.torque)

    def correct(self, estimate: RateEstimate, rate: Scalar, period: Scalar) -> RateEstimate:
        """Take in a measured rate, rad/s, one period after the last."""
        pole = jnp.exp(-self.bandwidth * period)
        innovation = rate - estimate.rate
        return RateEstimate(
            estimate.rate + (1.0 - pole**2) * innovation,
            estimate.torque + (1.0 - pole) ** 2 * self.inertia / period * innovation,
        )
