"""Attitude and gyro bias from a star tracker and a gyro: the multiplicative Kalman filter."""

from typing import Annotated, NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool, Float

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite, symmetric
from gyrostat.core.rotations import cross_matrix
from gyrostat.wheel.array import listed


class AttitudeEstimate(NamedTuple):
    """Attitude and gyro bias with what is known of their errors.

    Attributes:
        attitude: (4,) quaternion, scalar first.
        bias: (3,) of the gyro, rad/s.
        covariance: (6, 6) of the error turn from this attitude to the true one, in body axes, rad,
            and of the error of the bias, rad/s.
        innovation: (3,) turn from the predicted to the measured attitude, rad; zero where nothing
            was measured.
        surprise: normalised innovation squared, of three degrees of freedom; zero likewise.
        started: whether an attitude has been measured.
        turn: (3,) of the gyro over the last period, rate less bias times period, rad.
    """

    attitude: Quaternion
    bias: Vector3
    covariance: Float[Array, "6 6"]
    innovation: Vector3
    surprise: Scalar
    started: Bool[Array, ""]
    turn: Vector3


class AttitudeFilter(Checked):
    """Kalman filter on the small turn d between the estimated and the true attitude, q* = q exp(d).

    d' = -w x d - (b* - b) - noise, with w the rate of the gyro less the bias b; the turn goes into
    q after each correction. E. J. Lefferts, F. L. Markley, M. D. Shuster, "Kalman filtering for
    spacecraft attitude estimation", Journal of Guidance, Control, and Dynamics 5 (1982); the noise
    is exact for a gyro that integrates over its period (`gyrostat.spacecraft.RateGyro`).

    Coning. The attitude is carried by the rotation vector p of a period; a gyro gives the integral
    a of the body rate. With the sample before, p = a_k + (a_(k-1) x a_k) / 12, exact to the leading
    order of a rate that changes evenly (P. G. Savage, "Strapdown inertial navigation integration
    algorithm design, part 1", Journal of Guidance, Control, and Dynamics 21, 1998). Without this
    term the filter is sure of a wrong attitude and takes coning for bias. Mean normalised error
    squared (6 if consistent) over 64 runs of 200 s, second half, body rate 0.1 rad/s whose axis
    turns in the body at r, samples each 0.5 s, tracker 10" and 82", 2e-5 rad/√s, 3e-6 rad/s/√s:

        r, rad/s    without    with the term    gyro that compensates itself
        0.2         18         6.04             6.05
        0.5         64         6.25             6.02

    With sensors of the finest kind (tracker 2" and 10", 1e-6 rad/√s, 1e-8 rad/s/√s, 16 runs) and r
    of 0.5 rad/s it is 284 000 without and 100 with the term, the error 8.5e-5 and 2.6e-5 rad: such
    gyros need shorter periods, or units that compensate.

    Attributes:
        attitude_sigma: (3,) of the star tracker about each body axis, or one for all, rad.
        angle_walk: of the gyro, rad/√s.
        bias_walk: of the gyro, rad/s/√s.
        bias_sigma: standard deviation of the bias at the start, rad/s.
        coning: share of the coning that is in the gyro's samples and is corrected for: 1 where they
            are integrals of the rate, 0 where the unit has compensated for coning.
    """

    attitude_sigma: Annotated[Vector3 | float, positive("attitude sigma", "rad")] = eqx.field(
        converter=listed
    )
    angle_walk: Annotated[Scalar, positive("gyro angle walk", "rad/√s")]
    bias_walk: Annotated[Scalar, size("gyro bias walk", "rad/s/√s")]
    bias_sigma: Annotated[Scalar, size("bias sigma", "rad/s")]
    coning: Annotated[Scalar, size("coning share")] = 1.0

    def start(self) -> AttitudeEstimate:
        """Nothing known; the first attitude that is measured begins."""
        return AttitudeEstimate(
            attitude=jnp.array([1.0, 0.0, 0.0, 0.0]),
            bias=jnp.zeros(3),
            covariance=jnp.eye(6),
            innovation=jnp.zeros(3),
            surprise=jnp.zeros(()),
            started=jnp.array(False),
            turn=jnp.zeros(3),
        )

    def predict(
        self, estimate: AttitudeEstimate, rate: Vector3, period: Scalar
    ) -> AttitudeEstimate:
        """Carry an estimate over a period, s, in which the gyro measured a mean rate, rad/s."""
        integral = period * (rate - estimate.bias)
        turn = integral + self.coning / 12.0 * jnp.cross(estimate.turn, integral)
        step = rotations.from_rotation_vector(turn)
        own, unit = cross_matrix(turn), jnp.eye(3)
        # mean of exp(-[turn]x s) over the period; the next term is below 1e-6 for 0.3 rad
        squared = turn @ turn
        mean = unit - (0.5 - squared / 24.0) * own + (1.0 - squared / 20.0) / 6.0 * (own @ own)
        forward = jnp.block(
            [[rotations.rotation_matrix(step).T, -period * mean], [jnp.zeros((3, 3)), unit]]
        )
        walk = self.bias_walk**2 * period
        angle = self.angle_walk**2 * period + walk * period**2 / 3.0
        both = -0.5 * walk * period
        noise = jnp.kron(jnp.array([[angle, both], [both, walk]]), unit)
        return estimate._replace(
            attitude=rotations.normalised(rotations.product(estimate.attitude, step)),
            covariance=symmetric(forward @ estimate.covariance @ forward.T + noise),
            turn=integral,
        )

    def correct(
        self, estimate: AttitudeEstimate, attitude: Quaternion, measured: Bool[Array, ""]
    ) -> AttitudeEstimate:
        """Take in a sample of the star tracker.

        Args:
            estimate: predicted to its time.
            attitude: (4,) measured.
            measured: whether it is; else the estimate stays as predicted.
        """
        variance = jnp.ones(3) * jnp.asarray(self.attitude_sigma) ** 2
        noise, covariance = jnp.diag(variance), estimate.covariance
        innovation = rotations.rotation_vector(rotations.error(attitude, estimate.attitude))
        information = inverse_definite(covariance[:3, :3] + noise)
        gain = covariance[:, :3] @ information
        kept = jnp.eye(6) - jnp.concatenate([gain, jnp.zeros((6, 3))], axis=1)
        change = gain @ innovation
        turned = rotations.product(estimate.attitude, rotations.from_rotation_vector(change[:3]))
        corrected = AttitudeEstimate(
            attitude=rotations.normalised(turned),
            bias=estimate.bias + change[3:],
            # Joseph's form: positive definite whatever is rounded in the gain
            covariance=symmetric(kept @ covariance @ kept.T + gain @ noise @ gain.T),
            innovation=innovation,
            surprise=innovation @ information @ innovation,
            started=jnp.array(True),
            turn=estimate.turn,
        )
        first = self.start()._replace(
            attitude=attitude,
            covariance=jnp.diag(jnp.concatenate([variance, self.bias_sigma**2 * jnp.ones(3)])),
            started=jnp.array(True),
            turn=estimate.turn,
        )
        nothing = estimate._replace(innovation=jnp.zeros(3), surprise=jnp.zeros(()))
        begun = (jnp.where(estimate.started, a, b) for a, b in zip(corrected, first, strict=True))
        return AttitudeEstimate(
            *(jnp.where(measured, a, b) for a, b in zip(begun, nothing, strict=True))
        )
