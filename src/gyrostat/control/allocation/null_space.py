"""Null-space control: wheel speeds shaped by torques that cancel on the body."""

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
"""Square of a direction in the null space below which there is none."""
KEPT = 2.0
"""Weight of the gap that the wheels are in: another must be wider by this factor."""


class NullSpaceControl(Checked):
    """u = k N (h_d - h), N = 1 - A⁺ A: wheels away from zero speed and from saturation.

    The momentum q = A⁺ A h that the body asks for is not to be chosen; h_d adds z d to it, d = N s
    with s a pattern of senses, one for each wheel. Wheel i is at zero where z = c_i = -q_i / d_i,
    and at its largest wanted momentum H_i where z = c_i ± H_i / |d_i|: so z has an interval to
    choose from, cut into gaps by the c_i. The middle of the widest gap is where the worst wheel, in
    units of d, is farthest from both. The gap is only left for one much wider, since wheels cross
    zero on the way. Where the interval is empty, z is where the wheels are least beyond H.

    Attributes:
        pattern: s (wheels,), 1 or -1.
        largest: H (wheels,) wanted momentum at most, N·m·s.
        gain: k, 1/s.
    """

    pattern: PerWheel = eqx.field(converter=listed)
    largest: Annotated[PerWheel, positive("largest wanted wheel momentum", "N·m·s")] = eqx.field(
        converter=listed
    )
    gain: Annotated[Scalar, positive("null-space gain", "1/s")] = 0.05

    def __call__(self, axes: Axes, works: Working, momentum: PerWheel, room: PerWheel) -> PerWheel:
        """Motor torques whose sum over the axes is zero, N·m.

        Args:
            axes: (3, wheels).
            works: (wheels,) which wheels work.
            momentum: (wheels,) relative to the body, N·m·s.
            room: (wheels,) torque that each wheel has left, N·m, not negative.
        """
        across = spread(axes, works)

        def free(value: PerWheel) -> PerWheel:
            return works * value - across @ (axes @ (works * value))

        own = free(momentum)
        direction = free(self.pattern)
        square = direction @ direction
        exists = square > NOTHING
        now = direction @ own / jnp.where(exists, square, 1.0)
        # wheels that the direction does not move have no say
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
        """The control for an array; done once, outside the loop.

        Args:
            axes: (3, wheels), four wheels or more.
            momentum_limit: (wheels,) or one for all, N·m·s.
            share: of the limit that is wanted at most.

        Raises:
            InputError: axes without a null space, or a limit that is not finite.
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
        # the pattern of which most lies in the null space; a first sense is free to choose
        patterns = np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=count - 1)])
        best = patterns[np.argmax(np.round(np.einsum("ki,ij,kj->k", patterns, free, patterns), 9))]
        return cls(jnp.asarray(best), jnp.asarray(share * limit))


def _middle_of_gap(cuts: PerWheel, zero: PerWheel, reach: PerWheel, now: Scalar) -> Scalar:
    """The middle of the gap that is kept or gone to; see `NullSpaceControl`.

    Args:
        cuts: (wheels,) where one is at zero; infinite for one that is not moved.
        zero: (wheels,) the same, finite.
        reach: (wheels,) from there to where it is at its largest wanted momentum.
        now: where the wheels are.
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
