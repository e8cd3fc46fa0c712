"""Boresight pointing with two wheels: body rate towards a direction, and wheel speeds for it."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, positive_share
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.spacecraft import Spacecraft

Pair = Float[Array, "2"]

LEAST_SINE = 1e-12
"""Sine of the pointing error below which, at half a turn, the body turns about x."""


class WheelMap(NamedTuple):
    """Body rates about x and y from momentum b and wheel speeds u: w_xy = P b - Q u.

    Attributes:
        momentum: Matrix P, (2, 3), 1/(kg·m²).
        wheels: Matrix Q, (2, 2), 1.
        inverse: Inverse of Q, (2, 2), 1.
    """

    momentum: Float[Array, "2 3"]
    wheels: Float[Array, "2 2"]
    inverse: Float[Array, "2 2"]

    @classmethod
    def of(cls, spacecraft: Spacecraft, scale: Pair | float = 1.0) -> "WheelMap":
        """Map of a spacecraft with two wheels whose axes have independent parts across z.

        Args:
            spacecraft: Model of body and wheels.
            scale: True inertia of each rotor over that of the model, (2,).
        """
        wheels = spacecraft.wheels
        across = inverse_definite(spacecraft.inertia_locked())[:2]
        matrix = across @ (jnp.asarray(wheels.axes) * (wheels.inertia * scale))
        (a, b), (c, d) = matrix
        inverse = jnp.array([[d, -b], [-c, a]]) / (a * d - b * c)
        return cls(across, matrix, inverse)

    def rate(self, momentum: Vector3, speed: Pair) -> Pair:
        """Body rates about x and y, (2,), rad/s.

        Args:
            momentum: Total momentum in body axes, (3,), N·m·s.
            speed: Wheel speeds relative to the body, (2,), rad/s.
        """
        return self.momentum @ momentum - self.wheels @ speed

    def speed(self, momentum: Vector3, rate: Pair) -> Pair:
        """Wheel speeds, (2,), rad/s, that give body rates about x and y, (2,), rad/s."""
        return self.inverse @ (self.momentum @ momentum - rate)


class BoresightLaw(Checked):
    """Turn of body z to a direction p at the rate w = g(theta) n, n = z x p / |z x p|.

    Body z moves along the great circle to p. The rate is g = k theta near the target, and g =
    sqrt(2 a (theta - a / 2k^2)) from theta = a/k^2 on, with the same value and slope there; the
    body brakes with the deceleration a. The law is singular only at half a turn, where every path
    has the same length; there the body turns about its x axis. The deceleration a is a share of the
    acceleration about n that the torque of the weaker wheel gives. The rate g is limited by the
    momentum of the wheels. The direction is assumed to be at rest: if it moves at a constant rate
    W, body z lags by W / k.

    Attributes:
        gain: Gain k, 1/s.
        braking: Fraction of the torque that is used for braking.
        top_share: Fraction of the wheels' largest speed that is used for turning.
    """

    gain: Annotated[Scalar, positive("boresight gain", "1/s")] = 0.1
    braking: Annotated[Scalar, positive_share("boresight braking")] = 0.9
    top_share: Annotated[Scalar, positive_share("boresight top_share")] = 0.97

    def __call__(
        self, direction: Vector3, resting: Pair, map: WheelMap, limits: tuple[Pair, Pair]
    ) -> Pair:
        """Commanded body rates about x and y, (2,), rad/s.

        Args:
            direction: Target direction of body z, a unit vector in body axes, (3,).
            resting: Wheel speeds at which the body would not turn, (2,), rad/s.
            map: Map from momentum and wheel speeds to body rates.
            limits: Largest accelerations of the wheels, (2,), rad/s², and largest speeds, (2,),
                rad/s.
        """
        across = jnp.stack([-direction[1], direction[0]])
        sine = jnp.sqrt(across @ across)
        theta = jnp.arctan2(sine, direction[2])
        at_odds = sine < LEAST_SINE
        axis = jnp.where(at_odds, jnp.array([1.0, 0.0]), across / jnp.where(at_odds, 1.0, sine))
        share = jnp.maximum(jnp.abs(map.inverse @ axis), 1e-12)
        braking = self.braking * jnp.min(limits[0] / share)
        distance = theta - 0.5 * braking / self.gain**2
        fast = jnp.sqrt(2.0 * braking * jnp.maximum(distance, 0.5 * braking / self.gain**2))
        room = jnp.maximum(self.top_share * limits[1] - jnp.abs(resting), 0.0)
        speed = jnp.minimum(self.gain * theta, fast)
        return jnp.minimum(speed, jnp.min(room / share)) * axis


def governed(before: Pair, wanted: Pair, step: Pair) -> tuple[Pair, Scalar]:
    """Move commands towards their targets along a straight line, with limited steps.

    Args:
        before: Last commands, (n,).
        wanted: Target commands, (n,).
        step: Largest change of each command, (n,), above zero.

    Returns:
        New commands, and the share of the distance that they move: 1 if no step is limited.
    """
    way = wanted - before
    share = 1.0 / jnp.maximum(jnp.max(jnp.abs(way) / step), 1.0)
    return before + share * way, share
