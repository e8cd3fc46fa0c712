"""Equation of motion at the bearing of one wheel."""

import abc
from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class Motion(NamedTuple):
    """State of a wheel and its carrier, or the time derivative of that state.

    Attributes:
        speed: Wheel speed relative to the carrier, rad/s; exactly zero at rest.
        carrier: State of everything else that moves with the wheel, any tree of arrays; () for a
            fixed bench.
    """

    speed: Float[Array, ""]
    carrier: Any


class BearingEquation(eqx.Module):
    """Equation of motion at the bearing of one wheel, over one interval of smooth drive.

    J_e dw/dt = L - F and dy/dt = f(y, w, F, t). Here w is the speed of the wheel relative to its
    carrier, F the friction torque between them, y the state of the carrier, and J_e the effective
    inertia for F. L is the torque that friction must balance to hold the wheel at rest, where F =
    L.
    """

    friction: eqx.AbstractVar[Any]
    """Friction model: a static `Friction` for `step_dry_friction`, a `LuGre` for
    `step_bristles`."""

    @abc.abstractmethod
    def inertia(self) -> Scalar:
        """Effective inertia J_e, kg·m²."""

    @abc.abstractmethod
    def load(self, carrier: Any, time: Scalar) -> Scalar:
        """Load torque L, N·m.

        Args:
            carrier: State of the carrier.
            time: Time since the start of the interval, s.
        """

    @abc.abstractmethod
    def carrier_rate(self, carrier: Any, speed: Scalar, friction: Scalar, time: Scalar) -> Any:
        """Time derivative of the state of the carrier.

        Args:
            carrier: State of the carrier.
            speed: Wheel speed relative to the carrier, rad/s.
            friction: Friction torque F, N·m; positive if it slows a wheel of positive speed.
            time: Time since the start of the interval, s.
        """

    @abc.abstractmethod
    def longest_segment(self, time: Scalar) -> Scalar:
        """Longest Runge-Kutta step that resolves the drive from this time, s; may be infinite."""

    def is_steady(self) -> bool:
        """Whether the wheel is the whole state and its load is constant over the interval.

        Its acceleration then keeps its sign until the speed reaches zero, and a wheel that is held
        at rest stays there.
        """
        return False

    def rate(self, motion: Motion, direction: Scalar, time: Scalar) -> Motion:
        """Time derivative of the state in a fixed mode of motion.

        Args:
            motion: State of wheel and carrier.
            direction: Direction of rotation, ±1, or 0 if the wheel is held at rest.
            time: Time since the start of the interval, s.
        """
        load = self.load(motion.carrier, time)
        sliding = self.friction.torque(motion.speed, direction)
        return self._rate_under(load, jnp.where(direction == 0.0, load, sliding), motion, time)

    def turning_rate(self, motion: Motion, direction: Scalar, time: Scalar) -> Motion:
        """Time derivative of the state while the wheel turns.

        Args:
            motion: State of wheel and carrier.
            direction: Direction of rotation, ±1.
            time: Time since the start of the interval, s.
        """
        load = self.load(motion.carrier, time)
        sliding = self.friction.torque(motion.speed, direction)
        return self._rate_under(load, sliding, motion, time)

    def _rate_under(self, load: Scalar, friction: Any, motion: Motion, time: Scalar) -> Motion:
        carrier = self.carrier_rate(motion.carrier, motion.speed, friction, time)
        return Motion((load - friction) / self.inertia(), carrier)
