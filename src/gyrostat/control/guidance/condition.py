"""Conditions under which a reference changes from one mode to another."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class Condition(NamedTuple):
    """Conditions of a change of mode: all of them must hold. The defaults always hold.

    Attributes:
        after: Least time since the start of the mode, s.
        rate_below: Upper limit of the body rate, rad/s.
        momentum_above: Lower limit of the total momentum, N·m·s.
        error_below: Upper limit of the pointing error, rad.
        view: Number of a view of the reference, from 1, that lasts; negative: that does not last;
            0: none.
        rate_above: Lower limit of the body rate, rad/s.
        error_above: Lower limit of the pointing error, rad.
        momentum_below: Upper limit of the total momentum, N·m·s.
        wheel_momentum_above: Lower limit of the momentum of the wheels, N·m·s.
        wheel_momentum_below: Upper limit of the momentum of the wheels, N·m·s.
        wheels_lost: Least number of wheels that the controller takes to have failed.
        tracker_lost: Least time since the last measurement of the attitude, s.
        at: Time, s: the condition holds from then on, in a mode that started before; negative:
            none.
        held: Time for which all conditions must have held without interruption, s.
        reached: Whether the rotation to the mode must be complete, 0 or 1.
    """

    after: Scalar = 0.0
    rate_below: Scalar = np.inf
    momentum_above: Scalar = -1.0
    error_below: Scalar = np.inf
    view: Scalar = 0
    rate_above: Scalar = -1.0
    error_above: Scalar = -1.0
    momentum_below: Scalar = np.inf
    wheel_momentum_above: Scalar = -1.0
    wheel_momentum_below: Scalar = np.inf
    wheels_lost: Scalar = 0.0
    tracker_lost: Scalar = 0.0
    at: Scalar = -1.0
    held: Scalar = 0.0
    reached: Scalar = 1.0

    @classmethod
    def stacked(cls, conditions: Sequence["Condition"]) -> "Condition":
        """Several conditions as one, whose fields have the shape (conditions,)."""
        if not conditions:
            return cls(*(jnp.zeros(0) for _ in cls._fields))
        return cls(*(jnp.asarray(each, dtype=float) for each in zip(*conditions, strict=True)))

    @property
    def uses_momentum(self) -> Any:
        """Whether it limits a momentum."""
        above = (self.momentum_above >= 0.0) | (self.wheel_momentum_above >= 0.0)
        return above | jnp.isfinite(self.momentum_below) | jnp.isfinite(self.wheel_momentum_below)

    @property
    def needs_measurement(self) -> Any:
        """Whether it limits a measured quantity."""
        below = jnp.isfinite(self.rate_below) | jnp.isfinite(self.error_below)
        above = (self.rate_above >= 0.0) | (self.error_above >= 0.0)
        return below | above | self.uses_momentum


class Measured(NamedTuple):
    """Measured quantities of a sample that conditions limit.

    Attributes:
        rate: Body rate, rad/s.
        error: Pointing error, rad.
        momentum: Total momentum, N·m·s.
        wheel_momentum: Momentum of the wheels, N·m·s.
    """

    rate: Scalar
    error: Scalar
    momentum: Scalar
    wheel_momentum: Scalar

    def meet(self, condition: Condition) -> Bool[Array, ""]:
        """Whether the limits of a condition on them hold."""
        holds = (self.rate < condition.rate_below) & (self.rate > condition.rate_above)
        holds &= (self.error < condition.error_below) & (self.error > condition.error_above)
        holds &= self.momentum < condition.momentum_below
        holds &= self.momentum > condition.momentum_above
        holds &= self.wheel_momentum < condition.wheel_momentum_below
        return jnp.asarray(holds & (self.wheel_momentum > condition.wheel_momentum_above))


NEVER = Condition(after=np.inf)
"""Condition that never holds."""


class ModeChange(NamedTuple):
    """Change to a mode of a reference.

    Attributes:
        to: Number of the mode, from 0.
        condition: Conditions.
        origins: Numbers of the modes from which it is possible; None: from every other mode.
        user: Further condition, a callable (measurement, time) -> a number above 0 while it holds;
            None: there is none.
    """

    to: int
    condition: Condition
    origins: tuple[int, ...] | None = None
    user: Callable[[Any, Scalar], Any] | None = None

    def starts_in(self, mode: int) -> bool:
        """Whether it is possible from a mode."""
        return mode != self.to if self.origins is None else mode in self.origins


def is_in_view(
    views: Sequence[Callable[[Scalar], Scalar]], wanted: Any, time: Scalar
) -> Bool[Array, "*shape"]:
    """Whether conditions on a view hold at a time.

    Args:
        views: Views, at least one.
        wanted: See `Condition.view`.
        time: Time, s.
    """
    lasts = [view(time) > 0.0 for view in views]
    holds = [
        ((wanted != number) | is_on) & ((wanted != -number) | ~is_on)
        for number, is_on in enumerate(lasts, 1)
    ]
    return jnp.all(jnp.stack(holds), axis=0)
