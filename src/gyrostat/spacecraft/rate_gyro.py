"""Rate-integrating gyro of a spacecraft."""

from typing import Annotated, NamedTuple

import numpy as np
from jaxtyping import PRNGKeyArray

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, Rule, limit, share, signed, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error, from_rotation_vector, rotation_vector, to_body
from gyrostat.core.validation import require
from gyrostat.wheel.array import zeros


class BodyMotion(NamedTuple):
    """Attitude and rate of a body at one time.

    Attributes:
        attitude: (4,) quaternion, body in inertial space, scalar first.
        rate: (3,) in body axes, rad/s; without the jitter of wheels out of balance, which is far
            faster than any sampling.
    """

    attitude: Quaternion
    rate: Vector3


def integrated_rate(turn: Vector3, before: Vector3, now: Vector3, period: Scalar) -> Vector3:
    """Integral of the body rate over a period, from the turn and the rates at both ends.

    The integral of the rate in body axes is not the rotation vector of the turn: the axis of the
    rate turns meanwhile (coning). With the rotation vector p(t) from the start of the period,
    Bortz's equation (J. E. Bortz, "A new mathematical formulation for strapdown inertial
    navigation", IEEE Transactions on Aerospace and Electronic Systems 7, 1971), solved for the
    rate, is

        w = p' - p x p' / 2 + p x (p x p') / 6 - ...,

    and p(t) is the cubic polynomial that has its values and derivatives at both ends. The error is
    of the fifth order of the period: at 0.1 rad/s and 0.02 rad/s², at most 3e-8 rad in 0.5 s, where
    turn and integral differ by up to 6e-5 rad (100 random motions against DOP853).

    Args:
        turn: (3,) rotation vector from the attitude before to that now, rad.
        before: (3,) body rate at the start, rad/s.
        now: (3,) body rate at the end, rad/s.
        period: s.

    Returns:
        (3,) integral, rad.
    """
    bent = jnp.cross(turn, now)
    end = now + 0.5 * bent + (1.0 / 12.0 + turn @ turn / 720.0) * jnp.cross(turn, bent)
    swept = jnp.cross(turn, end - before)
    first = period / 5.0 * swept - period**2 / 30.0 * jnp.cross(before, end)
    second = period / 8.0 * jnp.cross(turn, swept)
    return turn - first / 2.0 + second / 6.0


_above_minus_one = Rule(
    "above -1",
    lambda value: require("1 + gyro scale factor", 1.0 + np.asarray(value), positive=True),
)


class RateGyro(Checked):
    """Integral of the body rate over the period, divided by the period, with the gyro's errors.

    Scale factor and misalignment act on the true mean rate; bias and noise are added; the sum is
    cut at the limit. R. L. Farrenkopf, "Analytic steady-state accuracy solutions for two common
    spacecraft attitude estimators", Journal of Guidance and Control 1 (1978): white noise and a
    random walk of the rate, integrated exactly over the period.

    The integral differs from the rotation vector of the turn where the axis of the rate moves
    (`integrated_rate`). A unit that compensates for coning at its own, higher rate gives the
    rotation vector: `coning_compensation` 1. See `gyrostat.estimation.AttitudeFilter` for what the
    difference does to an attitude filter.

    Attributes:
        angle_walk: sigma_v, of the integrated noise, rad/√s.
        bias_walk: sigma_u, of the bias in the square root of a second, rad/s/√s.
        bias: (3,) at time 0, rad/s.
        scale_factor: (3,) relative error of each axis, 1.
        misalignment: (3,) rotation vector from the body axes to those of the gyro, rad.
        rate_limit: largest rate of an axis that is measured, rad/s; infinite: none.
        coning_compensation: share of the coning that the unit itself compensates for, 0 to 1.
    """

    angle_walk: Annotated[Scalar, size("gyro angle walk", "rad/√s")] = 0.0
    bias_walk: Annotated[Scalar, size("gyro bias walk", "rad/s/√s")] = 0.0
    bias: Annotated[Vector3, signed("size of the gyro bias", "rad/s")] = zeros()
    scale_factor: Annotated[Vector3, _above_minus_one] = zeros()
    misalignment: Annotated[Vector3, signed("size of the gyro misalignment", "rad")] = zeros()
    rate_limit: Annotated[Scalar, limit("gyro rate limit", "rad/s")] = np.inf
    coning_compensation: Annotated[Scalar, share("gyro coning compensation")] = 0.0

    def __call__(
        self, before: BodyMotion, now: BodyMotion, bias: Vector3, period: Scalar, key: PRNGKeyArray
    ) -> tuple[Vector3, Vector3]:
        """Measure.

        Args:
            before: motion at the last sample.
            now: motion.
            bias: (3,) at the last sample, rad/s.
            period: between both, s.
            key: of the noise.

        Returns:
            The measured mean rate (3,) over the period, and the bias (3,) now, rad/s.
        """
        white, walk = jax.random.normal(key, (2, 3))
        after = bias + self.bias_walk * jnp.sqrt(period) * walk
        sigma = jnp.sqrt(self.angle_walk**2 / period + self.bias_walk**2 * period / 12.0)
        turn = rotation_vector(error(now.attitude, before.attitude))
        angle = integrated_rate(turn, before.rate, now.rate, period)
        angle = angle + self.coning_compensation * (turn - angle)
        mounted = to_body(from_rotation_vector(jnp.asarray(self.misalignment)), angle / period)
        rate = (1.0 + jnp.asarray(self.scale_factor)) * mounted
        rate = rate + 0.5 * (bias + after) + sigma * white
        return jnp.clip(rate, -self.rate_limit, self.rate_limit), after
