"""Equation of motion at the bearing of one wheel."""

import abc
from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class Motion(NamedTuple):
    """State of a wheel and its carrier, or the derivative of that state in time.

    Attributes:
        speed: of the wheel relative to its carrier, rad/s; exactly zero is at rest.
        carrier: everything else that moves with it, any tree of arrays; () for a fixed bench.
    """

    speed: Float[Array, ""]
    carrier: Any


class BearingEquation(eqx.Module):
    """Equation of motion at the bearing of one wheel, over one interval of smooth drive.

    J_e dw/dt = L - F and dy/dt = f(y, w, F, t): w is the speed of the wheel relative to its
    carrier, F the friction torque between the two, y the state of the carrier and J_e the inertia
    that F feels. L is the torque that friction must balance to hold the wheel at rest: F = L there.
    """

    friction: eqx.AbstractVar[Any]
    """A static `Friction` for `step_dry_friction`, a `LuGre` for `step_bristles`."""

    @abc.abstractmethod
    def inertia(self) -> Scalar:
        """J_e, kg·m²."""

    @abc.abstractmethod
    def load(self, carrier: Any, time: Scalar) -> Scalar:
        """L, N·m.

        Args:
            carrier: its state.
            time: from the start of the interval, s.
        """

    @abc.abstractmethod
    def carrier_rate(self, carrier: Any, speed: Scalar, friction: Scalar, time: Scalar) -> Any:
        """Derivative of the carrier's state in time.

        Args:
            carrier: its state.
            speed: of the wheel relative to it, rad/s.
            friction: torque F, positive where it slows a wheel of positive speed, N·m.
            time: from the start of the interval, s.
        """

    @abc.abstractmethod
    def longest_segment(self, time: Scalar) -> Scalar:
        """Longest Runge-Kutta step that resolves the drive from here on, s; may be infinite."""

    def rate(self, motion: Motion, direction: Scalar, time: Scalar) -> Motion:
        """Derivative in time while the mode of motion is frozen.

        Args:
            motion: the state.
            direction: sense of rotation ±1, or 0 where the wheel is held at rest.
            time: from the start of the interval, s.
        """
        load = self.load(motion.carrier, time)
        sliding = self.friction.torque(motion.speed, direction)
        friction = jnp.where(direction == 0.0, load, sliding)
        carrier = self.carrier_rate(motion.carrier, motion.speed, friction, time)
        return Motion((load - friction) / self.inertia(), carrier)
