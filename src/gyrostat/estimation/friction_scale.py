"""Extended Kalman filter for a wheel whose friction model is scaled by a slowly varying factor."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Wheel, advance
from gyrostat.wheel.friction import static_curve

Covariance = Float[Array, "2 2"]


LEAST_SCALE = 0.01
"""What the scale is kept above: no bearing drives its wheel."""
CONTRADICTION = 5.0
"""Standard deviations of the innovation from which on a wheel that should rest is seen to turn."""


class FrictionScaleEstimate(NamedTuple):
    """What the filter knows.

    Attributes:
        state: (2,) speed, rad/s, and friction of the wheel over friction of the model.
        covariance: (2, 2).
        innovation: of the last measured speed, rad/s.
        innovation_variance: rad²/s².
        missed: measurements that were no numbers, and were left out.
        unresolved: periods that the wheel model was not carried through to the end, for want of
            segments; what is known since then cannot be trusted.
    """

    state: Float[Array, " 2"]
    covariance: Covariance
    innovation: Scalar
    innovation_variance: Scalar
    missed: Scalar
    unresolved: Scalar

    @property
    def speed(self) -> Scalar:
        """Of the wheel, rad/s."""
        return self.state[0]

    @property
    def scale(self) -> Scalar:
        """Friction of the wheel over friction of the model: the health of its bearing."""
        return self.state[1]

    @property
    def normalised_innovation_squared(self) -> Scalar:
        """Chi-square with one degree of freedom where the filter is consistent."""
        seen = self.innovation_variance > 0.0
        return self.innovation**2 / jnp.where(seen, self.innovation_variance, 1.0)


class FrictionScaleFilter(Checked):
    """Speed and friction scale of a wheel from its current and tachometer.

    The wheel model, dry friction and all, carries the speed; its friction is multiplied by a scale
    that walks slowly, by a step at the end of each period. The derivative of the model comes from
    the located crossings themselves. The friction torque follows with far less noise than a filter
    without a model can give.

    Where the model holds the wheel at rest, nothing that the scale does changes the speed, and no
    measurement would change the scale. A speed that contradicts the rest is therefore believed.

    Attributes:
        wheel: as identified; of bristles, the curve of steady rotation is used.
        speed_sigma: noise of a measured speed, rad/s.
        scale_drift: of the scale in the square root of a second, 1/√s.
        torque_sigma: white torque noise that the model is granted, N·m √s.
        initial_scale_sigma: of the scale before the first measurement.
    """

    wheel: Wheel
    speed_sigma: Annotated[Scalar, positive("speed_sigma")]
    scale_drift: Annotated[Scalar, positive("scale_drift")]
    torque_sigma: Annotated[Scalar, size("torque_sigma", "N·m √s")] = 0.0
    initial_scale_sigma: Annotated[Scalar, positive("initial_scale_sigma")] = 0.3

    def start(
        self, speed: Scalar = 0.0, speed_sigma: Scalar | None = None
    ) -> FrictionScaleEstimate:
        """Before the first measurement, about a speed, rad/s, known to `speed_sigma`."""
        known = self.speed_sigma if speed_sigma is None else speed_sigma
        zero = jnp.array(0.0)
        return FrictionScaleEstimate(
            state=jnp.stack([jnp.asarray(speed, float), jnp.ones(())]),
            covariance=jnp.diag(jnp.stack([known**2 + zero, self.initial_scale_sigma**2 + zero])),
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
        """Carry over a period, s, in which the current, A, is held or runs with a slope, A/s."""
        curve = static_curve(self.wheel.friction)

        def carried(state):
            speed, scale = state
            # s times the friction is 1/s times the inertia and the motor torque
            wheel = Wheel(self.wheel.inertia / scale, self.wheel.motor_constant / scale, curve)
            after, resolved = advance(wheel, speed, current, slope, period)
            state = jnp.stack([after, scale])
            return state, (state, resolved)

        transition, (state, resolved) = jax.jacfwd(carried, has_aux=True)(estimate.state)
        shake = (self.torque_sigma / self.wheel.inertia) ** 2 * period
        spread = jnp.diag(jnp.stack([shake + 0.0 * period, self.scale_drift**2 * period]))
        covariance = transition @ estimate.covariance @ transition.T + spread
        return estimate._replace(
            state=state,
            covariance=covariance,
            unresolved=estimate.unresolved + jnp.where(resolved, 0.0, 1.0),
        )

    def correct(self, estimate: FrictionScaleEstimate, speed: Scalar) -> FrictionScaleEstimate:
        """Take in a measured speed, rad/s; one that is not finite is counted and left out."""
        seen = jnp.isfinite(speed)
        noise = self.speed_sigma**2
        prior = estimate.covariance
        variance = prior[0, 0] + noise
        innovation = jnp.where(seen, speed, estimate.speed) - estimate.speed
        observed = jnp.array([1.0, 0.0])
        turns = (estimate.speed == 0.0) & (innovation**2 > CONTRADICTION**2 * variance)
        gain = jnp.where(turns, observed, prior[:, 0] / variance)
        keeps = jnp.eye(2) - jnp.outer(gain, observed)
        posterior = keeps @ prior @ keeps.T + noise * jnp.outer(gain, gain)  # Joseph form
        speed, scale = estimate.state + gain * innovation
        return estimate._replace(
            state=jnp.stack([speed, jnp.maximum(scale, LEAST_SCALE)]),
            covariance=jnp.where(seen, posterior, prior),
            innovation=innovation,
            innovation_variance=jnp.where(seen, variance, 0.0),
            missed=estimate.missed + jnp.where(seen, 0.0, 1.0),
        )

    def friction(self, estimate: FrictionScaleEstimate) -> tuple[Scalar, Scalar]:
        """Friction torque of the turning wheel and its standard deviation, N·m."""
        curve = static_curve(self.wheel.friction)

        def torque(state):
            return state[1] * curve.torque(state[0], jnp.sign(state[0]))

        slope = jax.grad(torque)(estimate.state)
        return torque(estimate.state), jnp.sqrt(slope @ estimate.covariance @ slope)
