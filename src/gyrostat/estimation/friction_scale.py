"""Extended Kalman filter for wheel speed and a slowly varying scale of the friction model."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Wheel, advance
from gyrostat.wheel.friction import static_curve

Covariance = Float[Array, "2 2"]


LEAST_SCALE = 0.01
"""Lower limit of the scale: bearing friction never drives the wheel."""
CONTRADICTION = 5.0
"""Innovation, in standard deviations, at which a wheel modelled at rest is taken to turn."""


class FrictionScaleEstimate(NamedTuple):
    """State of the filter.

    Attributes:
        state: Wheel speed, rad/s, and friction of the wheel over friction of the model, (2,).
        covariance: Covariance of the state, (2, 2).
        innovation: Innovation of the last measured speed, rad/s.
        innovation_variance: Variance of the innovation, rad²/s².
        missed: Number of measurements that were not finite and therefore skipped.
        unresolved: Number of periods that the wheel model could not integrate to the end, because
            it ran out of segments. The estimate is not reliable after such a period.
    """

    state: Float[Array, " 2"]
    covariance: Covariance
    innovation: Scalar
    innovation_variance: Scalar
    missed: Scalar
    unresolved: Scalar

    @property
    def speed(self) -> Scalar:
        """Wheel speed, rad/s."""
        return self.state[0]

    @property
    def scale(self) -> Scalar:
        """Friction of the wheel over friction of the model, a health indicator of its bearing."""
        return self.state[1]

    @property
    def normalised_innovation_squared(self) -> Scalar:
        """Normalised innovation squared; chi-square with one degree of freedom if consistent."""
        valid = self.innovation_variance > 0.0
        return self.innovation**2 / jnp.where(valid, self.innovation_variance, 1.0)


class FrictionScaleFilter(Checked):
    """Kalman filter for the speed and friction scale of a wheel, from current and tachometer.

    The wheel model, including dry friction, predicts the speed. Its friction is multiplied by a
    scale, which is a random walk with one step at the end of each period. The prediction is
    differentiated through the located zero crossings. The estimate of the friction torque is far
    less noisy than that of a filter without a friction model.

    While the model holds the wheel at rest, the predicted speed does not depend on the scale, so
    that no measurement could change the scale. A measured speed that contradicts the rest by
    `CONTRADICTION` standard deviations therefore replaces the predicted speed.

    Attributes:
        wheel: Identified wheel. Of a bristle model, the curve of steady rotation is used.
        speed_sigma: Standard deviation of a measured speed, rad/s.
        scale_drift: Random walk of the scale, 1/√s.
        torque_sigma: White torque noise of the model, N·m √s.
        initial_scale_sigma: Standard deviation of the scale before the first measurement.
    """

    wheel: Wheel
    speed_sigma: Annotated[Scalar, positive("speed_sigma")]
    scale_drift: Annotated[Scalar, positive("scale_drift")]
    torque_sigma: Annotated[Scalar, size("torque_sigma", "N·m √s")] = 0.0
    initial_scale_sigma: Annotated[Scalar, positive("initial_scale_sigma")] = 0.3

    def start(
        self, speed: Scalar = 0.0, speed_sigma: Scalar | None = None
    ) -> FrictionScaleEstimate:
        """Initial estimate, with speed `speed`, rad/s, of standard deviation `speed_sigma`."""
        sigma = self.speed_sigma if speed_sigma is None else speed_sigma
        zero = jnp.array(0.0)
        return FrictionScaleEstimate(
            state=jnp.stack([jnp.asarray(speed, float), jnp.ones(())]),
            covariance=jnp.diag(jnp.stack([sigma**2 + zero, self.initial_scale_sigma**2 + zero])),
            innovation=zero,
            innovation_variance=zero,
            missed=zero,
            unresolved=zero,
        )

    def predict(
        self,
        estimate: FrictionScaleEstimate,
        current: Scalar,
        period: Scalar,
        slope: Scalar = 0.0,
    ) -> FrictionScaleEstimate:
        """Predict over a period, s, with a current, A, that is constant or has a slope, A/s."""
        curve = static_curve(self.wheel.friction)

        def propagate(state):
            speed, scale = state
            # friction times s has the same effect as inertia and motor torque times 1/s
            wheel = Wheel(self.wheel.inertia / scale, self.wheel.motor_constant / scale, curve)
            next_speed, resolved = advance(wheel, speed, current, slope, period)
            state = jnp.stack([next_speed, scale])
            return state, (state, resolved)

        transition, (state, resolved) = jax.jacfwd(propagate, has_aux=True)(estimate.state)
        shake = (self.torque_sigma / self.wheel.inertia) ** 2 * period
        spread = jnp.diag(jnp.stack([shake + 0.0 * period, self.scale_drift**2 * period]))
        covariance = transition @ estimate.covariance @ transition.T + spread
        return estimate._replace(
            state=state,
            covariance=covariance,
            unresolved=estimate.unresolved + jnp.where(resolved, 0.0, 1.0),
        )

    def correct(self, estimate: FrictionScaleEstimate, speed: Scalar) -> FrictionScaleEstimate:
        """Update with a measured speed, rad/s; a non-finite value is counted and skipped."""
        valid = jnp.isfinite(speed)
        noise = self.speed_sigma**2
        prior = estimate.covariance
        variance = prior[0, 0] + noise
        innovation = jnp.where(valid, speed, estimate.speed) - estimate.speed
        row = jnp.array([1.0, 0.0])
        turns = (estimate.speed == 0.0) & (innovation**2 > CONTRADICTION**2 * variance)
        gain = jnp.where(turns, row, prior[:, 0] / variance)
        complement = jnp.eye(2) - jnp.outer(gain, row)
        posterior = complement @ prior @ complement.T + noise * jnp.outer(gain, gain)  # Joseph form
        speed, scale = estimate.state + gain * innovation
        return estimate._replace(
            state=jnp.stack([speed, jnp.maximum(scale, LEAST_SCALE)]),
            covariance=jnp.where(valid, posterior, prior),
            innovation=innovation,
            innovation_variance=jnp.where(valid, variance, 0.0),
            missed=estimate.missed + jnp.where(valid, 0.0, 1.0),
        )

    def friction(self, estimate: FrictionScaleEstimate) -> tuple[Scalar, Scalar]:
        """Friction torque of the turning wheel and its standard deviation, N·m."""
        curve = static_curve(self.wheel.friction)

        def torque(state):
            return state[1] * curve.torque(state[0], jnp.sign(state[0]))

        slope = jax.grad(torque)(estimate.state)
        return torque(estimate.state), jnp.sqrt(slope @ estimate.covariance @ slope)
