"""Null-space control: changes wheel speeds by torques that cancel on the body."""

from itertools import product
from typing import Annotated, Self

import equinox as eqx
import numpy as np
from numpy.typing import ArrayLike

from gyrostat.control.allocation.allocation import Axes, Working, spread
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Matrix
from gyrostat.wheel.array import listed

NOTHING = 1e-9
"""Smallest squared length of a pattern's null-space part; below it there is no null space."""
KEPT = 2.0
"""Factor by which another gap must be wider than the present one before the wheels move to it."""


class NullSpaceControl(Checked):
    """Null-space torque u = k N (h_d - h), which avoids zero speed and saturation of the wheels.

    N = 1 - A⁺ A projects onto the null space of the axes A. The momentum q = A⁺ A h that the body
    needs cannot be chosen. The wanted momentum h_d adds z d to it, where d = N s and s is a pattern
    of signs, one for each wheel. Wheel i is at zero speed where z = c_i = -q_i / d_i, and at its
    largest wanted momentum H_i where z = c_i ± H_i / |d_i|. The values z within the limits of all
    wheels form an interval, which the c_i divide into gaps. In the middle of the widest gap, the
    worst wheel is farthest from zero speed and from its limit, measured in units of d. The control
    leaves the present gap only for a much wider one, since wheels cross zero speed on the way. If
    the interval is empty, z is the value at which the wheels exceed H least.

    Attributes:
        pattern: Pattern of signs s, (wheels,), 1 or -1.
        largest: Largest wanted momentum H of each wheel, (wheels,), N·m·s.
        gain: Gain k, 1/s.
    """

    pattern: PerWheel = eqx.field(converter=listed)
    largest: Annotated[PerWheel, positive("largest wanted wheel momentum", "N·m·s")] = eqx.field(
        converter=listed
    )
    gain: Annotated[Scalar, positive("null-space gain", "1/s")] = 0.05

    def __call__(self, axes: Axes, works: Working, momentum: PerWheel, room: PerWheel) -> PerWheel:
        """Motor torques, (wheels,), N·m, whose sum over the axes is zero.

        Args:
            axes: Spin axes of the wheels, (3, wheels).
            works: Whether each wheel works, (wheels,).
            momentum: Momentum of the wheels relative to the body, (wheels,), N·m·s.
            room: Torque that each wheel has left, (wheels,), N·m, not negative.
        """
        across = spread(axes, works)

        def free(value: PerWheel) -> PerWheel:
            return works * value - across @ (axes @ (works * value))

        own = free(momentum)
        direction = free(self.pattern)
        square = direction @ direction
        exists = square > NOTHING
        now = direction @ own / jnp.where(exists, square, 1.0)
        # wheels that the direction does not move are ignored
        moved = works & (jnp.abs(direction) > jnp.sqrt(NOTHING))
        size = jnp.where(moved, direction, 1.0)
        zero = -(works * momentum - own) / size
        reach = jnp.where(moved, self.largest / jnp.abs(size), jnp.inf)
        level = _middle_of_gap(jnp.where(moved, zero, jnp.inf), zero, reach, now)
        wanted = jnp.where(exists, level, 0.0) * direction
        torque = self.gain * (wanted - own)
        share = jnp.max(jnp.abs(torque) / jnp.maximum(room, 1e-30))
        return jnp.where(exists, torque / jnp.maximum(share, 1.0), 0.0)

    @classmethod
    def plan(cls, axes: Matrix | Axes, momentum_limit: ArrayLike, *, share: float = 0.9) -> Self:
        """Design the control for a wheel array; done once, outside the loop.

        Args:
            axes: Spin axes, (3, wheels), of four wheels or more.
            momentum_limit: Momentum limit of the wheels, (wheels,) or one for all, N·m·s.
            share: Largest wanted momentum over the momentum limit.

        Raises:
            InputError: The axes have no null space, or a limit is not finite.
        """
        axes = np.asarray(axes, dtype=float)
        count = axes.shape[1]
        limit = np.broadcast_to(np.asarray(momentum_limit, dtype=float), (count,))
        if not np.all(np.isfinite(limit)):
            raise InputError(
                "momentum limit of the wheels: found none, expected one for every wheel: the "
                "null-space control keeps below it"
            )
        free = np.eye(count) - np.linalg.pinv(axes) @ axes
        if np.trace(free) < 0.5:
            raise InputError(
                f"null-space control: found {count} wheels whose torques leave no freedom, "
                "expected more wheels than directions that they span"
            )
        # the pattern with the largest part in the null space; its first sign is arbitrary
        patterns = np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=count - 1)])
        best = patterns[np.argmax(np.round(np.einsum("ki,ij,kj->k", patterns, free, patterns), 9))]
        return cls(jnp.asarray(best), jnp.asarray(share * limit))


def _middle_of_gap(cuts: PerWheel, zero: PerWheel, reach: PerWheel, now: Scalar) -> Scalar:
    """Middle of the gap that the wheels stay in or move to; see `NullSpaceControl`.

    Args:
        cuts: Value of z at which each wheel has zero speed, (wheels,); infinite for a wheel that
            the direction does not move.
        zero: The same values, but all finite, (wheels,).
        reach: Distance from there to the largest wanted momentum of each wheel, (wheels,).
        now: Present value of z.
    """
    low, high = jnp.max(zero - reach), jnp.min(zero + reach)
    cuts = jnp.clip(cuts, low, jnp.maximum(low, high))
    starts = jnp.append(cuts, low)
    after = jnp.where(cuts > starts[:, None], cuts, jnp.inf)
    ends = jnp.minimum(jnp.min(after, axis=1), high)
    widths = ends - starts
    here = (starts <= now) & (now <= ends)
    best = jnp.argmax(jnp.where(here, KEPT, 1.0) * widths)
    middle = 0.5 * (starts[best] + ends[best])
    return jnp.where(low < high, middle, 0.5 * (low + high))
