"""Estimate of the external torque from the change of the total momentum."""

from typing import NamedTuple

from jaxtyping import Array, Bool

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jnp


class ExternalTorqueMemory(NamedTuple):
    """Estimate of the external torque and what its next update needs.

    Attributes:
        momentum: Total momentum at the last sample, inertial axes, (3,), N·m·s.
        torque: Estimate of the external torque, body axes, (3,), N·m.
        begun: Whether there was a sample one period ago.
        period: Control period, s.
    """

    momentum: Vector3
    torque: Vector3
    begun: Bool[Array, ""]
    period: Scalar

    @classmethod
    def start(cls, period: Scalar) -> "ExternalTorqueMemory":
        """Memory before the first sample."""
        period = jnp.asarray(period, dtype=float)
        return cls(jnp.zeros(3), jnp.zeros(3), jnp.array(False), period)

    def missed(self) -> "ExternalTorqueMemory":
        """Memory after a period without a sample; the estimate is unchanged."""
        return self._replace(begun=jnp.array(False))

    def updated(
        self,
        attitude: Quaternion,
        momentum: Vector3,
        time: Scalar,
        given: Vector3 | float = 0.0,
    ) -> "ExternalTorqueMemory":
        """Memory after a sample.

        The external torque is the change of the total momentum in inertial axes, after a low-pass
        filter. Unlike an integral of the attitude error, it cannot wind up.

        Args:
            attitude: Attitude quaternion, (4,).
            momentum: Total momentum in body axes, (3,), N·m·s.
            time: Time constant of the filter, s; infinite: the estimate stays zero.
            given: Known external torque since the last sample, body axes, (3,), N·m, which is not
                part of the estimate.
        """
        in_space = rotations.to_inertial(attitude, momentum)
        mean_torque = rotations.to_body(attitude, in_space - self.momentum) / self.period
        share = jnp.where(self.begun, self.period / (time + self.period), 0.0)
        torque = self.torque + share * (mean_torque - given - self.torque)
        return ExternalTorqueMemory(in_space, torque, jnp.array(True), self.period)
