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
    """Modes of motion of the wheels: turning or held at rest.

    Attributes:
        direction: Direction of rotation, ±1, or 0 for a wheel that is held at rest, (wheels,).
        holding: Matrix from accelerations of the held wheels to the torques that cancel them,
            (wheels, wheels), kg·m²; zero for the others.
    """

    direction: PerWheel
    holding: Float[Array, "wheels wheels"]


class Changes(NamedTuple):
    """Rates of change of drive and carrier at a time.

    Attributes:
        drive: Time derivative of the drive torques m, (wheels,), N·m/s.
        pull: Time derivative of the accelerations without friction, M m + g, (wheels,), rad/s³.
        turn_squared: Square of the fastest rate in carrier and drive, 1/s².
        turn_change_squared: Square of the time derivative of the carrier's rate, 1/s⁴.
    """

    drive: PerWheel
    pull: PerWheel
    turn_squared: Scalar
    turn_change_squared: Scalar


class CoupledBearings(eqx.Module):
    """Equations of motion at the bearings of several wheels on one carrier, with smooth drive.

    dw/dt = M (m - F) + g and dy/dt = f(y, w, F, t). Here w (wheels,) are the speeds relative to the
    carrier, m the drive torques, F the friction torques, and y the state of the carrier.
    """

    friction: eqx.AbstractVar[Any]
    """Static `Friction` whose parameters are (wheels,) or shared."""
    mobility: eqx.AbstractVar[Float[Array, "wheels wheels"]]
    """Matrix M, symmetric and positive definite, (wheels, wheels), 1/(kg·m²)."""

    @abc.abstractmethod
    def drive(self, motion: Motion, time: Scalar) -> tuple[PerWheel, PerWheel]:
        """Drive torques m, (wheels,), N·m, and accelerations g, (wheels,), rad/s².

        Args:
            motion: State of wheels and carrier.
            time: Time since the start of the interval, s.
        """

    @abc.abstractmethod
    def carrier_rate(self, motion: Motion, friction: PerWheel, time: Scalar) -> Any:
        """Time derivative of the state of the carrier.

        Args:
            motion: State of wheels and carrier.
            friction: Friction torques F, (wheels,), N·m.
            time: Time since the start of the interval, s.
        """

    @abc.abstractmethod
    def breakaway_torque(self, direction: PerWheel) -> PerWheel:
        """Breakaway torques of the wheels in a direction of rotation (±1), (wheels,), N·m."""

    @abc.abstractmethod
    def changes(self, motion: Motion, rate: Motion, time: Scalar) -> Changes:
        """Rates of change of drive and carrier.

        Args:
            motion: State of wheels and carrier.
            rate: Its time derivative.
            time: Time since the start of the interval, s.
        """

    def modes(self, direction: PerWheel) -> Modes:
        """Modes of motion with these directions of rotation, 0 for held wheels."""
        held = direction == 0.0
        held_pairs = held[:, None] & held
        system = jnp.where(held_pairs, self.mobility, jnp.eye(len(direction)))
        return Modes(direction, jnp.where(held_pairs, inverse_definite(system), 0.0))

    def torques(self, motion: Motion, modes: Modes, time: Scalar) -> PerWheel:
        """Friction torques F of turning wheels and holding torques of held ones, (wheels,), N·m.

        Args:
            motion: State of wheels and carrier.
            modes: Modes of motion.
            time: Time since the start of the interval, s.
        """
        drive, drift = self.drive(motion, time)
        held = modes.direction == 0.0
        sliding = self.friction.torque(motion.speed, modes.direction)
        surplus = jnp.where(held, 0.0, drive - sliding)
        holding = drive + modes.holding @ (self.mobility @ surplus + drift)
        return jnp.where(held, holding, sliding)

    def rate(self, motion: Motion, modes: Modes, time: Scalar) -> Motion:
        """Time derivative of the state in fixed modes of motion; see `torques`."""
        return self.rate_under(motion, self.torques(motion, modes, time), modes, time)

    def rate_under(self, motion: Motion, friction: PerWheel, modes: Modes, time: Scalar) -> Motion:
        """Time derivative of the state in fixed modes of motion, for known friction torques."""
        drive, drift = self.drive(motion, time)
        rate = self.mobility @ (drive - friction) + drift
        # exactly zero for held wheels, since rounding errors would let them creep
        speed = jnp.where(modes.direction == 0.0, 0.0, rate)
        return Motion(speed, self.carrier_rate(motion, friction, time))
