"""Estimate of a total momentum that an external torque changes."""

from typing import NamedTuple

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jnp


class MomentumEstimate(NamedTuple):
    """Total momentum and external torque, estimated by an observer with two equal poles.

    Attributes:
        momentum: Total momentum, inertial axes, (3,), N·m·s.
        torque: External torque, inertial axes, (3,), N·m.
        period: Control period, s.
    """

    momentum: Vector3
    torque: Vector3
    period: Scalar

    @classmethod
    def start(cls, momentum: Vector3, period: Scalar) -> "MomentumEstimate":
        """Estimate before the first sample."""
        return cls(jnp.asarray(momentum), jnp.zeros(3), jnp.asarray(period, dtype=float))

    def predicted(self) -> "MomentumEstimate":
        """Estimate after a period without a sample."""
        return self._replace(momentum=self.momentum + self.period * self.torque)

    def updated(self, attitude: Quaternion, measured: Vector3, time: Scalar) -> "MomentumEstimate":
        """Estimate after a sample.

        A constant torque leaves no error. An inertia error disturbs the measured momentum while
        the body turns; the observer reduces this disturbance.

        Args:
            attitude: Attitude quaternion, (4,).
            measured: Measured total momentum, body axes, (3,), N·m·s.
            time: Time constant of both poles, s.
        """
        # poles exp(-period / time) of the sampled observer
        pole = jnp.exp(-self.period / time)
        prior = self.predicted()
        residual = rotations.to_inertial(attitude, measured) - prior.momentum
        return MomentumEstimate(
            prior.momentum + (1.0 - pole**2) * residual,
            prior.torque + (1.0 - pole) ** 2 / self.period * residual,
            self.period,
        )
