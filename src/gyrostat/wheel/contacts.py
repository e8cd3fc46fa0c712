"""What several wheels on one carrier rub against: their coupled equations of motion."""

import abc
from typing import Any

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat._jax import jnp
from gyrostat.friction import Scalar
from gyrostat.wheel.contact import Motion

PerWheel = Float[Array, " wheels"]


def _solved(definite, right):
    """Solution of a small symmetric positive definite system, by elimination without pivots."""
    rows = jnp.concatenate([definite, right[:, None]], axis=1)
    for k in range(len(right)):
        pivot = rows[k] / rows[k, k]
        rows = (rows - rows[:, k, None] * pivot).at[k].set(pivot)
    return rows[:, -1]


class Contacts(eqx.Module):
    """Wheels, what carries them and what drives all, over one interval of smooth drive.

    dw/dt = M (m - F) + g and dy/dt = f(y, w, F, t): w (wheels,) are the speeds relative to the
    carrier, m the torques that drive them, F the friction torques, y the state of the carrier.
    """

    friction: eqx.AbstractVar[Any]
    """A static `Friction` whose parameters are (wheels,) or shared."""
    mobility: eqx.AbstractVar[Float[Array, "wheels wheels"]]
    """M, symmetric and positive definite, 1/(kg·m²)."""

    @abc.abstractmethod
    def drive(self, motion: Motion, time: Scalar) -> tuple[PerWheel, PerWheel]:
        """m, N·m, and g, rad/s².

        Args:
            motion: the state.
            time: from the start of the interval, s.
        """

    @abc.abstractmethod
    def carrier_rate(self, motion: Motion, friction: PerWheel, time: Scalar) -> Any:
        """Derivative of the carrier's state in time.

        Args:
            motion: the state.
            friction: F, N·m.
            time: from the start of the interval, s.
        """

    @abc.abstractmethod
    def breakaway_torque(self, direction: PerWheel) -> PerWheel:
        """Largest torque that each wheel at rest withstands in sense `direction` (±1), N·m."""

    @abc.abstractmethod
    def longest_segment(self, motion: Motion, time: Scalar) -> Scalar:
        """Longest Runge-Kutta step that resolves carrier and drive from here on, s."""

    def torques(self, motion: Motion, direction: PerWheel, time: Scalar) -> PerWheel:
        """F: of the turning wheels from their curve, of the resting ones what holds them, N·m.

        Args:
            motion: the state.
            direction: sense of rotation ±1, or 0 where a wheel is held at rest.
            time: from the start of the interval, s.
        """
        drive, drift = self.drive(motion, time)
        mobility = self.mobility
        held = direction == 0.0
        sliding = self.friction.torque(motion.speed, direction)
        surplus = jnp.where(held, 0.0, drive - sliding)
        missing = jnp.where(held, mobility @ surplus + drift, 0.0)
        both = held[:, None] & held[None, :]
        system = jnp.where(both, mobility, jnp.diag(jnp.where(held, 0.0, 1.0)))
        return jnp.where(held, drive + _solved(system, missing), sliding)

    def rate(self, motion: Motion, direction: PerWheel, time: Scalar) -> Motion:
        """Derivative in time while the modes of motion are frozen; see `torques`."""
        friction = self.torques(motion, direction, time)
        drive, drift = self.drive(motion, time)
        rate = self.mobility @ (drive - friction) + drift
        # held means held: what is left of the solution's rounding would creep
        speed = jnp.where(direction == 0.0, 0.0, rate)
        return Motion(speed, self.carrier_rate(motion, friction, time))
