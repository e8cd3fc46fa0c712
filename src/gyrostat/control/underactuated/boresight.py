"""Boresight pointing with two wheels: turn rate towards a direction, and wheel torques for it."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, positive_share
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.spacecraft import Spacecraft

Pair = Float[Array, "2"]

LEAST_SINE = 1e-12
"""Of the pointing error: below it, half a turn off, the body turns about x."""


class WheelMap(NamedTuple):
    """w_xy = P b - Q u: what body x and y rates momentum and wheel speeds make.

    Attributes:
        momentum: (2, 3) P, 1/(kg·m²).
        wheels: (2, 2) Q.
        inverse: (2, 2) of Q.
    """

    momentum: Float[Array, "2 3"]
    wheels: Float[Array, "2 2"]
    inverse: Float[Array, "2 2"]

    @classmethod
    def of(cls, spacecraft: Spacecraft) -> "WheelMap":
        """That of a spacecraft with two wheels whose axes' parts across z are independent."""
        wheels = spacecraft.wheels
        across = inverse_definite(spacecraft.inertia_locked())[:2]
        turned = across @ (jnp.asarray(wheels.axes) * wheels.inertia)
        (a, b), (c, d) = turned
        inverse = jnp.array([[d, -b], [-c, a]]) / (a * d - b * c)
        return cls(across, turned, inverse)

    def rate(self, momentum: Vector3, speed: Pair) -> Pair:
        """Body rates about x and y, rad/s.

        Args:
            momentum: (3,) total, in body axes, N·m·s.
            speed: (2,) of the wheels relative to the body, rad/s.
        """
        return self.momentum @ momentum - self.wheels @ speed

    def speed(self, momentum: Vector3, rate: Pair) -> Pair:
        """Wheel speeds that make body rates, rad/s."""
        return self.inverse @ (self.momentum @ momentum - rate)


class BoresightLaw(Checked):
    """w = g(theta) n: body z is led to a direction p on the great circle, n = z x p / |z x p|.

    g = k theta near the end, sqrt(2 a (theta - a / 2k^2)) from theta = a/k^2 on, which is the same
    there in value and slope: it brakes with a. Nothing in it is singular but half a turn, where
    every way is as short; then the body turns about its x axis. a is a share of what the weaker
    wheel's torque gives about n, and g is kept to what the wheels' momentum lets. The direction is
    taken to be at rest: behind one that moves at a constant rate W, body z stays by W / k.

    Attributes:
        gain: k, 1/s.
        braking: share of the torque that braking counts on.
        top_share: of the wheels' largest speed, that turning counts on.
    """

    gain: Annotated[Scalar, positive("boresight gain", "1/s")] = 0.1
    braking: Annotated[Scalar, positive_share("boresight braking")] = 0.9
    top_share: Annotated[Scalar, positive_share("boresight top_share")] = 0.97

    def __call__(
        self, direction: Vector3, resting: Pair, map: WheelMap, limits: tuple[Pair, Pair]
    ) -> Pair:
        """Body rates about x and y to turn with, rad/s.

        Args:
            direction: (3,) unit vector that body z is to meet, in body axes.
            resting: (2,) wheel speeds at which the body would not turn, rad/s.
            map: of the wheels.
            limits: (2,) largest accelerations of the wheels, rad/s², and largest speeds, rad/s.
        """
        across = jnp.stack([-direction[1], direction[0]])
        sine = jnp.sqrt(across @ across)
        theta = jnp.arctan2(sine, direction[2])
        at_odds = sine < LEAST_SINE
        axis = jnp.where(at_odds, jnp.array([1.0, 0.0]), across / jnp.where(at_odds, 1.0, sine))
        share = jnp.maximum(jnp.abs(map.inverse @ axis), 1e-12)
        braking = self.braking * jnp.min(limits[0] / share)
        far = theta - 0.5 * braking / self.gain**2
        fast = jnp.sqrt(2.0 * braking * jnp.maximum(far, 0.5 * braking / self.gain**2))
        room = jnp.maximum(self.top_share * limits[1] - jnp.abs(resting), 0.0)
        speed = jnp.minimum(self.gain * theta, fast)
        return jnp.minimum(speed, jnp.min(room / share)) * axis


def governed(before: Pair, wanted: Pair, step: Pair) -> tuple[Pair, Scalar]:
    """Commands that move towards what is wanted, none by more than its step, along a straight line.

    Args:
        before: (n,) the last commands.
        wanted: (n,) commands.
        step: (n,) largest change of each, above zero.

    Returns:
        The commands, and the share of the way that they go: 1 where nothing is cut.
    """
    way = wanted - before
    share = 1.0 / jnp.maximum(jnp.max(jnp.abs(way) / step), 1.0)
    return before + share * way, share
