"""Momenta of the wheels of a spacecraft from gyro, tachometers and conservation of momentum."""

from typing import Annotated, Any, NamedTuple, Self

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import to_body, to_inertial
from gyrostat.estimation.torque_walk import TorqueWalk, correct, predict
from gyrostat.estimation.wheel_momentum import MomentumEstimate, MomentumFilter
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel.friction import static_curve

WHOLE_FREQUENCY = 0.05
"""Natural frequency of the filter of the total momentum in `WheelArrayFilter.tune`, rad/s."""
UNKNOWN_FRICTION = 0.3
"""Initial standard deviation of the unexplained torque over the breakaway torque."""


class WheelArrayEstimate(NamedTuple):
    """Estimate of `WheelArrayFilter`.

    Attributes:
        whole: Total momentum in inertial axes, N·m·s, and external torque, N·m; all fields (3,).
        wheels: Momentum of each rotor about its axis in inertial space, N·m·s, and the torque on it
            that the known torques do not explain, N·m; all fields (wheels,).
    """

    whole: MomentumEstimate
    wheels: TorqueWalk

    def begun(self) -> Bool[Array, ""]:
        """Whether there has been a sample."""
        return jnp.asarray(self.whole.started)[0] > 0.0


class WheelArrayFilter(Checked):
    """Filters of the total momentum and of the momentum of each wheel.

    Only the external torque changes the total momentum H = J w + A h in inertial axes, with h_i =
    J_i (W_i + a_i.w) for rotor i. Errors of a friction model therefore cannot bias its filter. With
    H known, the gyro measures A h = H - J w. Weighted least squares of this and of the tachometers
    give a measured h, and a Kalman filter for each wheel estimates h and the torque d in dh/dt =
    known torque + d. The correlation of the measured h of different wheels is neglected.

    Attributes:
        axes: Spin axes, (3, wheels).
        inertia: Inertia J of the body without the rotors' spin inertia, (3, 3), kg·m².
        rotor_inertia: Spin inertia of the rotors, (wheels,), kg·m².
        whole: Filter of the total momentum, three components.
        weight: Weight of H - J w against the tachometers, (wheels, 3).
        variance: Variance of a measured h, (wheels,), (N·m·s)².
        torque_drift: Random walk of d, (wheels,), N·m/√s.
        initial_sigma: Initial standard deviation of d, (wheels,), N·m.
    """

    axes: Float[Array, "3 wheels"]
    inertia: Float[Array, "3 3"]
    rotor_inertia: Annotated[PerWheel, positive("rotor inertia", "kg·m²")]
    whole: MomentumFilter
    weight: Float[Array, "wheels 3"]
    variance: Annotated[PerWheel, positive("variance of a wheel momentum")]
    torque_drift: PerWheel
    initial_sigma: PerWheel

    @classmethod
    def tune(
        cls,
        spacecraft: Spacecraft,
        speed_sigma: Scalar,
        rate_sigma: Scalar,
        period: Scalar,
        bandwidth: Scalar,
    ) -> Self:
        """Tune the filters to the noise of the sensors.

        Args:
            spacecraft: Spacecraft as the filter knows it.
            speed_sigma: Standard deviation of a tachometer sample, rad/s.
            rate_sigma: Standard deviation of each component of a measured body rate, rad/s.
            period: Control period, s.
            bandwidth: Natural frequency of the filter of a wheel, rad/s: (q / r)^(1/4) for a random
                walk in torque of density q and a measured momentum of density r.
        """
        wheels = spacecraft.wheels
        axes, inertia = jnp.asarray(wheels.axes), jnp.asarray(spacecraft.inertia)
        unit = jnp.ones(wheels.count)
        rotor = unit * wheels.inertia
        tachometer_variance = (rotor * speed_sigma) ** 2
        spread = axes * tachometer_variance
        covariance = spread @ axes.T + rate_sigma**2 * inertia @ inertia.T
        weight = spread.T @ inverse_definite(covariance)
        variance = tachometer_variance - jnp.sum(weight * spread.T, axis=1)
        sigma = jnp.sqrt(jnp.diagonal(covariance))
        return cls(
            axes,
            inertia,
            rotor,
            MomentumFilter(sigma, WHOLE_FREQUENCY**2 * sigma * jnp.sqrt(period)),
            weight,
            variance,
            bandwidth**2 * jnp.sqrt(variance * period),
            jnp.asarray(UNKNOWN_FRICTION * static_curve(wheels.friction).breakaway_torque(unit)),
        )

    # earlier name
    tuned = tune

    def start(self) -> WheelArrayEstimate:
        """Initial estimate, before the first measurement."""
        zero = jnp.zeros(self.axes.shape[-1])
        return WheelArrayEstimate(
            self.whole.start(3), TorqueWalk(*(zero,) * len(TorqueWalk._fields))
        )

    def predict(
        self, estimate: WheelArrayEstimate, torque: PerWheel, period: Scalar
    ) -> WheelArrayEstimate:
        """Predict over a period, s, with known torques on the rotors, (wheels,), N·m."""
        return WheelArrayEstimate(
            self.whole.predict(estimate.whole, period),
            predict(estimate.wheels, self.torque_drift, period, period * torque),
        )

    def correct(self, estimate: WheelArrayEstimate, measurement: Any) -> WheelArrayEstimate:
        """Update with a sample.

        Args:
            estimate: Estimate predicted to the time of the sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, `wheel_speed`
                (wheels,), relative to the body, rad/s, and `wheel_measured` (wheels,). In place of
                a wheel that is not measured, its prediction is used.
        """
        attitude, rate = measurement.attitude, measurement.rate
        rotor_momentum = self.rotor_inertia * (measurement.wheel_speed + self.axes.T @ rate)
        rotor_momentum = jnp.where(
            measurement.wheel_measured, rotor_momentum, estimate.wheels.momentum
        )
        body, rotors = self.inertia @ rate, self.axes @ rotor_momentum
        total = self.whole.correct(estimate.whole, to_inertial(attitude, body + rotors))
        conserved = to_body(attitude, jnp.asarray(total.momentum)) - body
        momentum = rotor_momentum + self.weight @ (conserved - rotors)
        zero = jnp.zeros_like(momentum)
        initial = TorqueWalk(momentum, zero, self.variance, zero, self.initial_sigma**2)
        update, _, _ = correct(estimate.wheels, momentum, self.variance)
        wheels = jax.tree.map(lambda a, b: jnp.where(estimate.begun(), a, b), update, initial)
        return WheelArrayEstimate(total, wheels)
