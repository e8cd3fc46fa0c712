"""Total momentum and the true rotor inertias, from body rate and wheel speeds."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite, symmetric
from gyrostat.core.rotations import rotation_matrix
from gyrostat.spacecraft import Spacecraft


class RotorScaleEstimate(NamedTuple):
    """Estimate of total momentum and rotor inertias.

    Attributes:
        momentum: Total momentum in inertial axes, (3,), N·m·s.
        scale: Inertia of each rotor over that of the model, (wheels,).
        covariance: Covariance of both, (3 + wheels, 3 + wheels), N²·m²·s² and 1.
    """

    momentum: Annotated[Vector3, "N·m·s"]
    scale: Annotated[PerWheel, "1"]
    covariance: Float[Array, "n n"]


class RotorScaleFilter(Checked):
    """Kalman filter of the total momentum H and of the scales s of the rotor inertias.

    The rate w of the body and the wheel speeds W give R' H = J w + A diag(J_w W) s at each sample.
    H is a slow random walk in inertial axes and s is constant. A rotation of the body, which
    changes W, thus tells s from H. What the filter finds is the ratio of J_w to J: an error of J
    has the same effect as one of all rotors.

    Attributes:
        spacecraft: Model of body and wheels.
        time: Time constant of the momentum in the steady state, s.
        rate_sigma: Noise of the body rate, rad/s, with errors of the rate that change slowly.
        rotor_sigma: Relative standard deviation of each rotor inertia before the first sample.
    """

    spacecraft: Spacecraft
    time: Annotated[Scalar, positive("momentum time", "s")] = 30.0
    rate_sigma: Annotated[Scalar, positive("noise of the rate", "rad/s")] = 2e-5
    rotor_sigma: Annotated[Scalar, positive("rotor sigma")] = 0.05

    def start(self) -> RotorScaleEstimate:
        """Estimate before the first sample."""
        count = self.spacecraft.wheels.count
        largest = 1e9 * self._variance()
        scale_variance = jnp.full(count, self.rotor_sigma**2)
        covariance = jnp.diag(jnp.concatenate([jnp.full(3, largest), scale_variance]))
        return RotorScaleEstimate(jnp.zeros(3), jnp.ones(count), covariance)

    def _variance(self) -> Scalar:
        """Variance of a momentum computed from one sample of the rate, N²·m²·s²."""
        largest = jnp.max(jnp.diagonal(self.spacecraft.inertia_locked()))
        return (largest * self.rate_sigma) ** 2

    def __call__(
        self,
        estimate: RotorScaleEstimate,
        attitude: Quaternion,
        rate: Vector3,
        wheel_speed: PerWheel,
        period: Scalar,
    ) -> RotorScaleEstimate:
        """Update the estimate by one sample.

        Args:
            estimate: Estimate after the last sample.
            attitude: Attitude quaternion, (4,), scalar first.
            rate: Body rate, body axes, (3,), rad/s.
            wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s.
            period: Time since the last sample, s.
        """
        wheels, variance = self.spacecraft.wheels, self._variance()
        rotors = jnp.asarray(wheels.axes) * (wheels.inertia * wheel_speed)
        # s appears in R' H - A diag(J_w W) s = J w
        rows = jnp.concatenate([rotation_matrix(attitude).T, -rotors], axis=1)
        growth = (
            jnp.zeros(len(estimate.covariance)).at[:3].set(variance * (period / self.time) ** 2)
        )
        prior = estimate.covariance + jnp.diag(growth)
        spread = prior @ rows.T
        gain = spread @ inverse_definite(rows @ spread + variance * jnp.eye(3))
        state = jnp.concatenate([estimate.momentum, estimate.scale])
        state = state + gain @ (self.spacecraft.inertia_locked() @ rate - rows @ state)
        # Joseph form: the difference of two covariances has no digits left after the first sample
        rest = jnp.eye(len(prior)) - gain @ rows
        covariance = symmetric(rest @ prior @ rest.T + variance * gain @ gain.T)
        return RotorScaleEstimate(state[:3], state[3:], covariance)
