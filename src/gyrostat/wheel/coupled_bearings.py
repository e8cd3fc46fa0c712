"""Coupled equations of motion at the bearings of several wheels on one carrier."""

import abc
from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.wheel.bearing_equation import Motion


class Modes(NamedTuple):
    """Which wheels turn and which are held, and what holds them.

    Attributes:
        direction: (wheels,) sense of rotation ±1, or 0 where a wheel is held at rest.
        holding: (wheels, wheels) torques that cancel accelerations of the held wheels, kg·m²; zero
            for the others.
    """

    direction: PerWheel
    holding: Float[Array, "wheels wheels"]


class Changes(NamedTuple):
    """How fast drive and carrier change at a time.

    Attributes:
        drive: (wheels,) derivative in time of m, N·m/s.
        pull: (wheels,) that of the accelerations without friction M m + g, rad/s³.
        turn_squared: square of the fastest rate in carrier and drive, 1/s².
        turn_change_squared: square of the derivative in time of the carrier's rate, 1/s⁴.
    """

    drive: PerWheel
    pull: PerWheel
    turn_squared: Scalar
    turn_change_squared: Scalar


class CoupledBearings(eqx.Module):
    """Equations of motion at the bearings of wheels on one carrier, in smooth drive.

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
    def changes(self, motion: Motion, rate: Motion, time: Scalar) -> Changes:
        """How fast drive and carrier change.

        Args:
            motion: the state.
            rate: its derivative in time.
            time: from the start of the interval, s.
        """

    def modes(self, direction: PerWheel) -> Modes:
        """Modes of motion with these senses of rotation, 0 where held."""
        held = direction == 0.0
        both = held[:, None] & held
        system = jnp.where(both, self.mobility, jnp.eye(len(direction)))
        return Modes(direction, jnp.where(both, inverse_definite(system), 0.0))

    def torques(self, motion: Motion, modes: Modes, time: Scalar) -> PerWheel:
        """F: of the turning wheels from their curve, of the resting ones what holds them, N·m.

        Args:
            motion: the state.
            modes: of motion.
            time: from the start of the interval, s.
        """
        drive, drift = self.drive(motion, time)
        held = modes.direction == 0.0
        sliding = self.friction.torque(motion.speed, modes.direction)
        surplus = jnp.where(held, 0.0, drive - sliding)
        holding = drive + modes.holding @ (self.mobility @ surplus + drift)
        return jnp.where(held, holding, sliding)

    def rate(self, motion: Motion, modes: Modes, time: Scalar) -> Motion:
        """Derivative in time while the modes of motion are frozen; see `torques`."""
        return self.rate_under(motion, self.torques(motion, modes, time), modes, time)

    def rate_under(self, motion: Motion, friction: PerWheel, modes: Modes, time: Scalar) -> Motion:
        """The same, of `torques` that are known."""
        drive, drift = self.drive(motion, time)
        rate = self.mobility @ (drive - friction) + drift
        # held means held: what is left of the solution's rounding would creep
        speed = jnp.where(modes.direction == 0.0, 0.0, rate)
        return Motion(speed, self.carrier_rate(motion, friction, time))
