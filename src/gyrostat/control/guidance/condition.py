"""Conditions under which a mode of a reference ends."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class Condition(NamedTuple):
    """Conditions under which a mode ends: all of them must hold. The defaults always hold.

    Attributes:
        after: Least time since the start of the mode, s.
        rate_below: Upper limit of the body rate, rad/s.
        momentum_above: Lower limit of the total momentum, N·m·s.
        error_below: Upper limit of the pointing error, rad.
        view: Number of a view of the reference, from 1, that lasts; negative: that does not last;
            0: none.
    """

    after: Scalar = 0.0
    rate_below: Scalar = np.inf
    momentum_above: Scalar = -1.0
    error_below: Scalar = np.inf
    view: Scalar = 0


NEVER = Condition(after=np.inf)
"""Condition that never holds."""


def is_in_view(
    views: Sequence[Callable[[Scalar], Scalar]], wanted: Scalar, time: Scalar
) -> Bool[Array, ""]:
    """Whether a condition on a view holds at a time.

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
    return jnp.all(jnp.stack(holds))
