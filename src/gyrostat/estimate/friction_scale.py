"""Extended Kalman filter on a wheel whose friction model may be wrong by a slow factor."""

from typing import NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat._jax import jax, jnp
from gyrostat.friction import Friction, Scalar, static_curve
from gyrostat.require import require
from gyrostat.wheel import Wheel, advance

Covariance = Float[Array, "2 2"]


class _Scaled(Friction):
    """A friction curve times a factor."""

    curve: Friction
    factor: Scalar

    def torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        return self.factor * self.curve.torque(speed, direction)

    def speed_scale(self) -> Scalar:
        return self.curve.speed_scale()

    @classmethod
    def from_coulomb(cls, viscous: float, coulomb: float) -> "_Scaled":
        raise NotImplementedError("a scaled curve is not a model of its own")


class FrictionScaleEstimate(NamedTuple):
    """What the filter knows.

    Attributes:
        state: (2,) speed, rad/s, and friction of the wheel over friction of the model.
        covariance: (2, 2).
        innovation: of the last measured speed, rad/s.
        innovation_variance: rad²/s².
        missed: measurements that were no numbers, and were left out.
    """

    state: Float[Array, " 2"]
    covariance: Covariance
    innovation: Scalar
    innovation_variance: Scalar
    missed: Scalar

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


class FrictionScaleFilter(eqx.Module):
    """Speed and friction scale of a wheel from its current and tachometer.

    The wheel model, dry friction and all, carries the speed; its friction is multiplied by a scale
    that walks slowly. The derivative of the model comes from the located crossings themselves. The
    friction torque follows with far less noise than a filter without a model can give.

    Attributes:
        wheel: as identified; of bristles, the curve of steady rotation is used.
        speed_sigma: noise of a measured speed, rad/s.
        scale_drift: of the scale in the square root of a second, 1/√s.
        torque_sigma: white torque noise that the model is granted, N·m √s.
        initial_scale_sigma: of the scale before the first measurement.
    """

    wheel: Wheel
    speed_sigma: Scalar
    scale_drift: Scalar
    torque_sigma: Scalar = 0.0
    initial_scale_sigma: Scalar = 0.3

    def check(self) -> None:
        """Refuse what is no covariance.

        Raises:
            InputError: the noise or the drift is not above zero.
        """
        for name in ("speed_sigma", "scale_drift", "initial_scale_sigma"):
            require(name, getattr(self, name), positive=True)

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
        )

    def _carried(self, state: Array, current: Scalar, slope: Scalar, period: Scalar) -> Array:
        friction = _Scaled(static_curve(self.wheel.friction), state[1])
        wheel = Wheel(self.wheel.inertia, self.wheel.motor_constant, friction)
        return jnp.stack([advance(wheel, state[0], current, slope, period).speed, state[1]])

    def predict(
        self,
        estimate: FrictionScaleEstimate,
        current: Scalar,
        period: Scalar,
        slope: Scalar = 0.0,
    ) -> FrictionScaleEstimate:
        """Carry over a period, s, in which the current, A, is held or runs with a slope, A/s."""

        def carried(state):
            return self._carried(state, current, slope, period)

        state = carried(estimate.state)
        transition = jax.jacfwd(carried)(estimate.state)
        shake = (self.torque_sigma / self.wheel.inertia) ** 2 * period
        spread = jnp.diag(jnp.stack([shake + 0.0 * period, self.scale_drift**2 * period]))
        covariance = transition @ estimate.covariance @ transition.T + spread
        return estimate._replace(state=state, covariance=covariance)

    def correct(self, estimate: FrictionScaleEstimate, speed: Scalar) -> FrictionScaleEstimate:
        """Take in a measured speed, rad/s; one that is no number is counted and left out."""
        seen = jnp.isfinite(speed)
        noise = self.speed_sigma**2
        prior = estimate.covariance
        variance = prior[0, 0] + noise
        innovation = jnp.where(seen, speed, estimate.speed) - estimate.speed
        gain = prior[:, 0] / variance
        keeps = jnp.eye(2) - jnp.outer(gain, jnp.array([1.0, 0.0]))
        posterior = keeps @ prior @ keeps.T + noise * jnp.outer(gain, gain)  # Joseph form
        return FrictionScaleEstimate(
            state=estimate.state + gain * innovation,
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
