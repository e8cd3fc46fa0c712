"""Extended state observer of body rate and disturbance torque."""

from typing import Annotated, NamedTuple

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jnp


class RateEstimate(NamedTuple):
    """Body rate and disturbance torque.

    Attributes:
        rate: Body rate, rad/s.
        torque: Disturbance torque: all torque except the known one, N·m.
    """

    rate: Scalar
    torque: Scalar


class RateObserver(Checked):
    """Observer of J dΩ/dt = known torque + d with constant d; both poles at the bandwidth.

    J. Han, "From PID to active disturbance rejection control", IEEE Transactions on Industrial
    Electronics 56 (2009): the linear extended state observer, here with measured rate.

    Attributes:
        inertia: Inertia J, kg·m².
        bandwidth: Bandwidth of the observer, rad/s.
    """

    inertia: Annotated[Scalar, positive("compensator table inertia")]
    bandwidth: Annotated[Scalar, positive("compensator bandwidth")]

    def start(self) -> RateEstimate:
        """Initial estimate: zero rate and zero disturbance torque."""
        return RateEstimate(jnp.array(0.0), jnp.array(0.0))

    def predict(self, estimate: RateEstimate, known: Scalar, period: Scalar) -> RateEstimate:
        """Predict over a period, s, during which a known torque, N·m, acts."""
        step = period * (known + estimate.torque) / self.inertia
        return RateEstimate(estimate.rate + step, estimate.torque)

    def correct(self, estimate: RateEstimate, rate: Scalar, period: Scalar) -> RateEstimate:
        """Update with a measured rate, rad/s, one period, s, after the last one."""
        pole = jnp.exp(-self.bandwidth * period)
        innovation = rate - estimate.rate
        return RateEstimate(
            estimate.rate + (1.0 - pole**2) * innovation,
            estimate.torque + (1.0 - pole) ** 2 * self.inertia / period * innovation,
        )
