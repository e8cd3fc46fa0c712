"""Rate gyro with the errors of a data sheet."""

from typing import Annotated, NamedTuple

import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, limit, signed, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.limiting import quantised
from gyrostat.spacecraft.rate_gyro import BodyMotion, RateGyro
from gyrostat.wheel.array import zeros

DECADES = 7
"""Number of Gauss-Markov processes that flicker noise is approximated by, one in each decade."""
_FLICKER_KEY = 0xF11C


class GyroMemory(NamedTuple):
    """Memory of a `DataSheetGyro`.

    Attributes:
        bias: Bias, (3,), rad/s.
        flicker: Gauss-Markov processes of the bias instability, (processes, 3), rad/s.
        passed: Body rate behind the low-pass filter, (3,), rad/s.
        rest: Angle that is not yet given out, (3,), rad.
    """

    bias: Vector3
    flicker: Float[Array, "processes 3"]
    passed: Vector3
    rest: Vector3


class DataSheetGyro(Checked):
    """Rate-integrating gyro with bandwidth, bias instability and resolution, as data sheets state.

    The body rate passes a low-pass filter of first order. Its mean over the period is exact for a
    rate that is quadratic in the period, with the rates at both ends and the mean. The errors of
    `RateGyro` follow, with the axes of the gyro not at right angles: y has a part of the rate about
    x, z of those about x and y. The bias instability is added, the rate limit applied, and the
    output is rounded: the integrated angle to `angle_resolution`, without loss from sample to
    sample, then the rate to `rate_resolution`.

    Flicker noise of the spectrum B² / (2 pi f) is the sum of Gauss-Markov processes of equal
    variance B² ln(10) / pi, whose time constants are 0.5, 5, ..., 5e5 periods: one in each decade.
    Its Allan deviation is within 2 % of the flat 0.664 B from 30 to 1e5 periods, 3 % above at 10, a
    third above at 1, and below after 1e5. The processes begin at zero, so that `bias` is the bias
    at time 0.

    Sensitivity to acceleration is left out: a spacecraft in orbit is in free fall.

    Attributes:
        gyro: Noise, bias, scale factor, mounting and rate limit.
        bias_instability: Bias instability B of IEEE Std 952, rad/s: the lowest part of an Allan
            deviation over 0.664.
        bandwidth: Frequency at which the low-pass filter has lost 3 dB, Hz; infinite: no filter.
        nonorthogonality: Deviations from right angles between the axes x and y, x and z, y and z,
            (3,), rad; small angles.
        angle_resolution: Step of the integrated angle, rad; 0: none.
        rate_resolution: Step of the rate, rad/s; 0: none.
    """

    gyro: RateGyro
    bias_instability: Annotated[Scalar, size("gyro bias instability", "rad/s")] = 0.0
    bandwidth: Annotated[Scalar, limit("gyro bandwidth", "Hz")] = np.inf
    nonorthogonality: Annotated[Vector3, signed("size of the gyro nonorthogonality", "rad")] = (
        zeros()
    )
    angle_resolution: Annotated[Scalar, size("gyro angle resolution", "rad")] = 0.0
    rate_resolution: Annotated[Scalar, size("gyro rate resolution", "rad/s")] = 0.0

    def start(self, motion: BodyMotion) -> GyroMemory:
        """Memory before the first sample, for a rate that was constant before."""
        return GyroMemory(
            self.gyro.start(motion), jnp.zeros((DECADES, 3)), motion.rate, jnp.zeros(3)
        )

    def __call__(
        self,
        before: BodyMotion,
        now: BodyMotion,
        memory: GyroMemory,
        period: Scalar,
        key: PRNGKeyArray,
    ) -> tuple[Vector3, GyroMemory]:
        """Measure the mean rate over the last period; arguments as of `RateGyro`.

        Returns:
            The measured mean rate, (3,), rad/s, and the memory at this sample.
        """
        mean = self.gyro.mean_rate(before, now, period)
        passed, behind = self._low_pass(before.rate, mean, now.rate, memory.passed, period)
        mounted = self.gyro.in_gyro_axes(passed)
        skew = jnp.asarray(self.nonorthogonality)
        mounted = mounted + jnp.stack(
            [jnp.zeros(()), skew[0] * mounted[0], skew[1] * mounted[0] + skew[2] * mounted[1]]
        )
        rate, bias = self.gyro.with_errors(mounted, memory.bias, period, key)
        flicker = self._flicker(memory.flicker, jax.random.fold_in(key, _FLICKER_KEY))
        rate = self.gyro.limited(rate + jnp.sum(flicker, axis=0))
        angle = memory.rest + period * rate
        given = quantised(angle, self.angle_resolution)
        rest = jnp.where(self.angle_resolution > 0.0, angle - given, 0.0)
        rate = jnp.where(self.angle_resolution > 0.0, given / period, rate)
        return quantised(rate, self.rate_resolution), GyroMemory(bias, flicker, behind, rest)

    def _low_pass(
        self, first: Vector3, mean: Vector3, last: Vector3, passed: Vector3, period: Scalar
    ) -> tuple[Vector3, Vector3]:
        """Mean rate over the period behind the low-pass filter, and the rate at its end.

        From y' = (w - y) / T, the mean of y is that of w less T (y(h) - y(0)) / h.

        Args:
            first: Body rate at the start of the period, (3,), rad/s.
            mean: Mean body rate, (3,), rad/s.
            last: Body rate at the end, (3,), rad/s.
            passed: Rate behind the filter at the start, (3,), rad/s.
            period: Period h, s.
        """
        lag = 1.0 / (2.0 * jnp.pi * jnp.asarray(self.bandwidth, dtype=float))
        # w(t) = first + linear t / h + square (t / h)² with the given mean
        square = 3.0 * (first + last - 2.0 * mean)
        linear = last - first - square
        share = lag / period
        kept = jnp.exp(-1.0 / jnp.where(share > 0.0, share, 1.0)) * (share > 0.0)
        ramp = 1.0 - share * (1.0 - kept)
        end = kept * passed + (1.0 - kept) * first + ramp * linear
        end = end + (1.0 - 2.0 * share * ramp) * square
        return mean - share * (end - passed), end

    def _flicker(
        self, before: Float[Array, "processes 3"], key: PRNGKeyArray
    ) -> Float[Array, "processes 3"]:
        """Gauss-Markov processes one period later, (processes, 3), rad/s."""
        kept = jnp.asarray(np.exp(-2.0 / 10.0 ** np.arange(DECADES)))[:, None]
        sigma = self.bias_instability * np.sqrt(np.log(10.0) / np.pi)
        steps = jax.random.normal(key, (DECADES, 3))
        return kept * before + sigma * jnp.sqrt(1.0 - kept**2) * steps
