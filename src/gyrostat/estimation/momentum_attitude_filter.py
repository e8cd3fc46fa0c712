"""Attitude and body rate without a gyro, from star tracker, tachometers and momentum."""

from typing import Annotated, Any, NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite, symmetric
from gyrostat.core.rotations import cross_matrix
from gyrostat.spacecraft import Spacecraft
from gyrostat.spacecraft.attitude_sensors import whole_periods


class MomentumAttitudeEstimate(NamedTuple):
    """Attitude, total momentum and rotor inertias with their covariance.

    Attributes:
        attitude: Attitude quaternion, (4,), scalar first.
        momentum: Total momentum in inertial axes, (3,), N·m·s.
        scale: Inertia of each rotor over that of the model, (wheels,).
        covariance: Covariance of the rotation error (from this attitude to the true one, body axes,
            rad), of the momentum error, N·m·s, and of the scale error, (6 + wheels, 6 + wheels).
        wheel_speed: Wheel speeds at the last sample, (wheels,), rad/s.
        innovation: Rotation from predicted to measured attitude, (3,), rad; zero without
            measurement.
        surprise: Normalised innovation squared, three degrees of freedom; zero without measurement.
        started: Whether an attitude has been measured yet.
    """

    attitude: Quaternion
    momentum: Vector3
    scale: PerWheel
    covariance: Float[Array, "n n"]
    wheel_speed: PerWheel
    innovation: Vector3
    surprise: Scalar
    started: Bool[Array, ""]


class _Signals(NamedTuple):
    estimated_attitude: Annotated[Quaternion, "1"]
    estimated_rate: Annotated[Vector3, "rad/s"]
    estimated_momentum: Annotated[Vector3, "N·m·s"]
    rotor_scale: Annotated[PerWheel, "1"]
    attitude_sigma: Annotated[Vector3, "rad"]
    innovation: Annotated[Vector3, "rad"]
    surprise: Scalar


class MomentumAttitudeFilter(Checked):
    """Kalman filter of attitude q, total momentum H and scales s of the rotor inertias.

    Conservation of momentum gives the body rate w = J^-1 (R' H - A diag(J_w W) s) from the measured
    wheel speeds W, in place of a gyro. The star tracker corrects q, H and s. H is a random walk in
    inertial axes and s is constant. With the rotation d from estimated to true attitude,
    q* = q exp(d), and b = R' H,

        d' = -w x d + J^-1 (b x d + R' dH - A diag(J_w W) ds).

    After each correction the rotation d is moved into q. E. J. Lefferts, F. L. Markley, M. D.
    Shuster, "Kalman filtering for spacecraft attitude estimation", Journal of Guidance, Control,
    and Dynamics 5 (1982), with this rate in place of gyro and bias. The wheel speeds of the two
    ends of a period are averaged. Momentum that the model does not have, such as that of flexible
    appendages, is an error of the rate. Only the ratio of J_w to J can be found: an error of J has
    the same effect as one of all rotors.

    Attributes:
        spacecraft: Model of body and wheels.
        attitude_sigma: Star-tracker noise about each body axis, rad.
        periods: Control periods from one sample of the star tracker to the next, a whole number.
        speed_sigma: Standard deviation of a tachometer sample, (wheels,), or one value for all,
            rad/s.
        bandwidth: Bandwidth B of the filter, rad/s. The random walk of H is that for which the
            corrections of attitude and momentum have two poles of magnitude B.
        rotor_sigma: Relative standard deviation of each rotor inertia at the start; 0: the rotors
            of the model are trusted.
        rate_sigma: Standard deviation of the body rate at the start about each axis, rad/s.
    """

    spacecraft: Spacecraft
    attitude_sigma: Annotated[Scalar, positive("attitude sigma", "rad")]
    periods: Annotated[Scalar, whole_periods] = 1
    speed_sigma: Annotated[PerWheel | Scalar, size("tachometer sigma", "rad/s")] = 0.0
    bandwidth: Annotated[Scalar, positive("attitude filter bandwidth", "rad/s")] = 0.2
    rotor_sigma: Annotated[Scalar, size("rotor sigma")] = 0.1
    rate_sigma: Annotated[Scalar, positive("initial rate sigma", "rad/s")] = 0.01

    def start(self) -> MomentumAttitudeEstimate:
        """Initial estimate; the first measured attitude initialises the filter."""
        count = self.spacecraft.wheels.count
        return MomentumAttitudeEstimate(
            attitude=jnp.array([1.0, 0.0, 0.0, 0.0]),
            momentum=jnp.zeros(3),
            scale=jnp.ones(count),
            covariance=jnp.eye(6 + count),
            wheel_speed=jnp.zeros(count),
            innovation=jnp.zeros(3),
            surprise=jnp.zeros(()),
            started=jnp.array(False),
        )

    def sample(self, measurement: Any) -> PerWheel:
        """Wheel speeds that `predict` takes, (wheels,), rad/s; a measured rate is not used."""
        return measurement.wheel_speed

    def rate(self, estimate: MomentumAttitudeEstimate, sample: PerWheel) -> Vector3:
        """Body rate with these wheel speeds, (3,), rad/s; zero before the first attitude."""
        inverse = inverse_definite(self.spacecraft.inertia_locked())
        wheel_momentum = self._rotors(sample) @ estimate.scale
        rate = inverse @ (rotations.to_body(estimate.attitude, estimate.momentum) - wheel_momentum)
        return jnp.where(estimate.started, rate, 0.0)

    def signals(self, estimate: MomentumAttitudeEstimate, rate: Vector3) -> _Signals:
        """Signals to record, with the body rate, (3,), rad/s."""
        return _Signals(
            estimate.attitude,
            rate,
            estimate.momentum,
            estimate.scale,
            jnp.sqrt(jnp.diagonal(estimate.covariance)[:3]),
            estimate.innovation,
            estimate.surprise,
        )

    def _rotors(self, wheel_speed: PerWheel) -> Float[Array, "3 wheels"]:
        """Momentum of each rotor of the model in body axes, (3, wheels), N·m·s."""
        wheels = self.spacecraft.wheels
        return jnp.asarray(wheels.axes) * (wheels.inertia * wheel_speed)

    def predict(
        self, estimate: MomentumAttitudeEstimate, wheel_speed: PerWheel, period: Scalar
    ) -> MomentumAttitudeEstimate:
        """Predict over a period.

        Args:
            estimate: Estimate at the last sample.
            wheel_speed: Measured wheel speeds at the end of the period, (wheels,), rad/s.
            period: Period, s.
        """
        inertia = self.spacecraft.inertia_locked()
        inverse = inverse_definite(inertia)
        rotors = self._rotors(0.5 * (estimate.wheel_speed + wheel_speed))
        wheel_momentum = rotors @ estimate.scale
        at_start = inverse @ (
            rotations.to_body(estimate.attitude, estimate.momentum) - wheel_momentum
        )
        # attitude in the middle of the period, whose rate is the mean to second order
        middle = rotations.from_rotation_vector(0.5 * period * at_start)
        matrix = rotations.rotation_matrix(rotations.product(estimate.attitude, middle))
        body = matrix.T @ estimate.momentum
        rate = inverse @ (body - wheel_momentum)
        by_rate = period * (inverse @ cross_matrix(body) - cross_matrix(rate))
        unit = jnp.eye(len(estimate.covariance))
        forward = unit.at[:3].set(
            jnp.concatenate(
                [
                    jnp.eye(3) + by_rate + 0.5 * by_rate @ by_rate,
                    period * inverse @ matrix.T,
                    -period * inverse @ rotors,
                ],
                axis=1,
            )
        )
        walk = self.bandwidth**2 * self.attitude_sigma * matrix @ inertia
        wheels = self.spacecraft.wheels
        momentum_noise = jnp.asarray(wheels.axes) * (wheels.inertia * self.speed_sigma)
        noise = jnp.zeros_like(unit)
        noise = noise.at[3:6, 3:6].set(self.periods * period**2 * walk @ walk.T)
        angle_noise = period * inverse @ momentum_noise
        covariance = forward @ (estimate.covariance + noise) @ forward.T
        q = rotations.product(estimate.attitude, rotations.from_rotation_vector(period * rate))
        return estimate._replace(
            attitude=jnp.where(estimate.started, rotations.normalised(q), estimate.attitude),
            covariance=symmetric(covariance.at[:3, :3].add(angle_noise @ angle_noise.T)),
            wheel_speed=wheel_speed,
        )

    def correct(
        self,
        estimate: MomentumAttitudeEstimate,
        attitude: Quaternion,
        measured: Bool[Array, ""],
    ) -> MomentumAttitudeEstimate:
        """Update with a sample of the star tracker.

        Args:
            estimate: Estimate predicted to the time of the sample.
            attitude: Measured attitude, (4,).
            measured: Whether the sample is valid; otherwise the prediction is returned unchanged.
        """
        variance = self.attitude_sigma**2 * jnp.eye(3)
        covariance = estimate.covariance
        innovation = rotations.rotation_vector(rotations.error(attitude, estimate.attitude))
        information = inverse_definite(covariance[:3, :3] + variance)
        gain = covariance[:, :3] @ information
        # 1 - P / (P + R) as R / (P + R), which loses no digits while the momentum is unknown
        complement = jnp.eye(len(covariance)).at[:3, :3].set(variance @ information)
        complement = complement.at[3:, :3].set(-gain[3:])
        change = gain @ innovation
        q = rotations.product(estimate.attitude, rotations.from_rotation_vector(change[:3]))
        corrected = estimate._replace(
            attitude=rotations.normalised(q),
            momentum=estimate.momentum + change[3:6],
            scale=estimate.scale + change[6:],
            # Joseph form: positive definite in spite of rounding errors in the gain
            covariance=symmetric(complement @ covariance @ complement.T + gain @ variance @ gain.T),
            innovation=innovation,
            surprise=innovation @ information @ innovation,
        )
        prediction = estimate._replace(innovation=jnp.zeros(3), surprise=jnp.zeros(()))
        start = self._initial(attitude, estimate.wheel_speed)

        def select(new: Any, first: Any, old: Any) -> Any:
            return jnp.where(measured, jnp.where(estimate.started, new, first), old)

        return jax.tree.map(select, corrected, start, prediction)

    def _initial(self, attitude: Quaternion, wheel_speed: PerWheel) -> MomentumAttitudeEstimate:
        """Estimate from the first measured attitude, for a body at rest within `rate_sigma`."""
        matrix = rotations.rotation_matrix(attitude)
        rotors = matrix @ self._rotors(wheel_speed)
        count = self.spacecraft.wheels.count
        # what the momentum does not know: the rate, and the scales with the momentum of the rotors
        of_rate = self.rate_sigma * matrix @ self.spacecraft.inertia_locked()
        of_scale = self.rotor_sigma * jnp.concatenate([rotors, jnp.eye(count)])
        covariance = jnp.zeros((6 + count, 6 + count))
        covariance = covariance.at[:3, :3].set(self.attitude_sigma**2 * jnp.eye(3))
        covariance = covariance.at[3:6, 3:6].set(of_rate @ of_rate.T)
        covariance = covariance.at[3:, 3:].add(of_scale @ of_scale.T)
        return self.start()._replace(
            attitude=attitude,
            momentum=rotors @ jnp.ones(count),
            covariance=covariance,
            wheel_speed=wheel_speed,
            started=jnp.array(True),
        )
