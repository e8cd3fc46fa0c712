"""Feed-forward of a reference: what a controller needs to follow it without lag."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.guidance.attitude_reference import AttitudeReference
from gyrostat.control.guidance.reference import BoundReference
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jnp

AT_REST: Any = np.array([1.0, 0.0, 0.0, 0.0])
"""Attitude of a body that agrees with its target, in axes of the target."""


class Following(NamedTuple):
    """Motion of a body relative to its reference, and the torque that follows the reference.

    Attributes:
        turn: Rotation from the reference to the body, a quaternion with scalar part >= 0, (4,).
        rate: Body rate relative to the reference, body axes, (3,), rad/s.
        carried: Rate of the reference in body axes, (3,), rad/s.
        change: Change of `carried` because the body turns relative to the reference, (3,), rad/s².
        torque: Torque that the wheels take up while body and momentum follow the reference, mean
            over the period in which the command acts, body axes, (3,), N·m.
    """

    turn: Quaternion
    rate: Vector3
    carried: Vector3
    change: Vector3
    torque: Vector3


class Guide(NamedTuple):
    """Reference at a sample and over the control period in which the sample's command acts.

    With the total momentum H, constant in inertial axes, the wheels of a body that moves with the
    reference hold the momentum p(t) = R(t)' H - J w(t) in its axes. A torque that is constant over
    the acting period, from t_a to t_b, must change it by p(t_b) - p(t_a). The torque (p(t_b) -
    p(t_a)) / T therefore leaves no error of the rate at the samples, for any motion of the
    reference and any command delay. Between the samples the acceleration of the body is constant;
    where that of the reference rises from zero to a, the attitude gets an error of a T² / 12, which
    the feedback then removes.

    Attributes:
        at: Reference as a function of time.
        now: Reference at the time of the sample.
        first: Reference at the start of the acting period.
        last: Reference at its end.
        period: Control period T, s.
    """

    at: BoundReference
    now: AttitudeReference
    first: AttitudeReference
    last: AttitudeReference
    period: Scalar

    @classmethod
    def of(
        cls,
        at: BoundReference,
        now: AttitudeReference,
        time: Scalar,
        period: Scalar,
        delay: int,
    ) -> "Guide":
        """Guide for a sample.

        Args:
            at: Reference in the active mode.
            now: Reference at the time of the sample.
            time: Time of the sample, s.
            period: Control period, s.
            delay: Control periods from a sample to the start of its command.
        """
        first = at(time + period * delay) if delay else now
        last = at(time + period * (delay + 1.0))
        return cls(at, now, first, last, period)

    def follow(
        self,
        attitude: Quaternion,
        rate: Vector3,
        momentum: Vector3,
        inertia: Float[Array, "3 3"] | Any,
    ) -> Following:
        """Relative motion of a body, and the torque that follows the reference.

        Args:
            attitude: Attitude of the body, (4,).
            rate: Body rate, (3,), rad/s.
            momentum: Total momentum in body axes, (3,), N·m·s.
            inertia: Inertia without the spin inertia of the rotors, (3, 3), kg·m².
        """
        turn = rotations.error(attitude, self.now.attitude)
        carried = rotations.to_body(turn, self.now.rate)
        relative = rate - carried
        total = rotations.to_inertial(attitude, momentum)
        first, last = (rotations.to_body(end.attitude, total) for end in (self.first, self.last))
        rate_momentum = rotations.to_body(turn, self.last.rate - self.first.rate)
        change = rotations.to_body(turn, last - first) - inertia @ rate_momentum
        return Following(
            turn, relative, carried, -jnp.cross(relative, carried), change / self.period
        )
