"""Null-space control: changes wheel speeds by torques that cancel on the body."""

from itertools import product
from typing import Annotated, Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float
from numpy.typing import ArrayLike

from gyrostat.control.allocation.allocation import Axes, Working, spread
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, Rule, limit, positive, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix
from gyrostat.wheel.array import listed

NOTHING = 1e-9
"""Smallest squared length of a pattern's null-space part; below it there is no null space."""
BEYOND = 0.1
"""Worth of the part of a gap in which a worn wheel is fast, over that of its slow part."""

Bands = Float[Array, "bands 2 wheels"]


def _check_bands(value: Any) -> None:
    every = np.asarray(value, dtype=float)
    if every.ndim < 3 or every.shape[-2] != 2:
        raise InputError(f"bands: found shape {every.shape}, expected (bands, 2, wheels)")
    low, high = every[..., 0, :], every[..., 1, :]
    mask = ~((low >= 0.0) & (low < high) & np.isfinite(high))
    if np.any(mask):
        raise InputError(
            f"band of wheel momenta: found {low[mask][0]:g} to {high[mask][0]:g} N·m·s, expected a "
            "lower end of 0 or more and a larger upper end"
        )


class NullSpaceControl(Checked):
    """Null-space torque u = k N (h_d - h), which keeps wheels from zero, bands and saturation.

    N = 1 - A⁺ A projects onto the null space of the axes A. The momentum q = A⁺ A h that the body
    needs cannot be chosen. The wanted momentum h_d adds z d to it, where d = N s and s is a pattern
    of signs, one for each wheel. Wheel i is at zero speed where z = c_i = -q_i / d_i, in a band of
    momenta from b to B of either sign where b < |d_i| |z - c_i| < B, and at its largest wanted
    momentum H_i where z = c_i ± H_i / |d_i|. The values z within the limits of all wheels form an
    interval, which the c_i and the bands divide into gaps.

    Wear. A wheel with wear w is wanted within H_i / w, so that its friction power there is that of
    a wheel without wear. The part of a gap that fulfils this for all wheels is its slow part.

    Which gap. The wheels stay in their gap as long as it is wider than `clearance` and has a slow
    part. Otherwise they go to the gap with the largest worth: the width of its slow part, and
    `BEYOND` times the whole width, over 1 + n. On the way there, wheels cross zero speed or bands;
    n is the number of these crossings, each counted as w² of its wheel. A wheel that goes through a
    band at zero crosses zero and the band on both sides of it, three in all. Of several ways, that
    with fewer crossings by less worn wheels is thus taken. Where the c_i differ, the wheels cross
    one after the other. While they cross, k is `crossing_gain`.

    Where in the gap. In its middle, the worst wheel is farthest from zero speed, bands and limits,
    measured in units of d. The wheels are kept at the middle of the slow part, but at `clearance`
    from the ends of the gap, or in the middle of a narrow gap. A worn wheel thus turns slowly, and
    the others take up the momentum that the body needs.

    If the interval is empty, z is the value at which the wheels exceed H least. If the bands leave
    no gap, z stays as it is.

    Attributes:
        pattern: Pattern of signs s, (wheels,), 1 or -1.
        largest: Largest wanted momentum H of each wheel, (wheels,), N·m·s.
        gain: Gain k within a gap, 1/s; 0: no null-space control.
        bands: Bands of the size of the momentum to be avoided, lower and upper ends, (bands, 2,
            wheels), N·m·s: wheel speed times rotor inertia.
        clearance: Distance from the ends of a gap that suffices, in units of d, N·m·s; infinite:
            the wheels are in the middle of their gap, and leave it for any gap of more worth.
        crossing_gain: Gain k while wheels cross zero speed or a band, 1/s.
    """

    pattern: PerWheel = eqx.field(converter=listed)
    largest: Annotated[PerWheel, positive("largest wanted wheel momentum", "N·m·s")] = eqx.field(
        converter=listed
    )
    gain: Annotated[Scalar, size("null-space gain", "1/s")] = 0.05
    bands: Annotated[Bands | None, Rule("0 <= lower < upper end, N·m·s", _check_bands)] = None
    clearance: Annotated[Scalar, limit("null-space clearance", "N·m·s")] = np.inf
    crossing_gain: Annotated[Scalar, positive("crossing gain", "1/s")] = 0.2

    def __call__(
        self,
        axes: Axes,
        works: Working,
        momentum: PerWheel,
        room: PerWheel,
        wear: PerWheel | float = 1.0,
        planned: Scalar | None = None,
    ) -> PerWheel:
        """Motor torques, (wheels,), N·m, whose sum over the axes is zero.

        Args:
            axes: Spin axes of the wheels, (3, wheels).
            works: Whether each wheel works, (wheels,).
            momentum: Momentum of the wheels relative to the body, (wheels,), N·m·s.
            room: Torque that each wheel has left, (wheels,), N·m, not negative.
            wear: Friction of each wheel over that of a wheel without wear, (wheels,), above 0.
            planned: Wanted value of z, N·m·s; None: the best one for this momentum.
        """
        across = spread(axes, works)

        def project(value: PerWheel) -> PerWheel:
            return works * value - across @ (axes @ (works * value))

        free_momentum = project(momentum)
        direction = project(self.pattern)
        square = direction @ direction
        exists = square > NOTHING
        z = direction @ free_momentum / jnp.where(exists, square, 1.0)
        # wheels that the direction does not move are ignored
        moves = works & (jnp.abs(direction) > jnp.sqrt(NOTHING))
        scale = jnp.where(moves, direction, 1.0)
        zero = -(works * momentum - free_momentum) / scale
        state = _Place(
            z,
            zero,
            jnp.where(moves, self.largest / jnp.abs(scale), jnp.inf),
            jnp.ones(moves.shape) * wear,
        )
        starts, ends = [zero], [zero]
        if self.bands is not None:
            inner, outer = jnp.moveaxis(jnp.asarray(self.bands) / jnp.abs(scale), 1, 0)
            starts += [*(zero + inner), *(zero - outer)]
            ends += [*(zero + outer), *(zero - inner)]
        starts, ends = (jnp.where(moves, each, jnp.inf) for each in map(jnp.stack, (starts, ends)))
        if planned is None:
            level, crosses = state.level(starts, ends, self.clearance)
        else:
            level, crosses = jnp.asarray(planned), jnp.asarray(True)
        target = jnp.where(exists, level, 0.0) * direction
        torque = jnp.where(crosses & (self.gain > 0.0), self.crossing_gain, self.gain) * (
            target - free_momentum
        )
        share = jnp.max(jnp.abs(torque) / jnp.maximum(room, 1e-30))
        return jnp.where(exists, torque / jnp.maximum(share, 1.0), 0.0)

    @classmethod
    def plan(
        cls,
        axes: Matrix | Axes,
        momentum_limit: ArrayLike,
        *,
        share: float = 0.9,
        bands: ArrayLike = (),
        clearance: float = np.inf,
    ) -> Self:
        """Design the control for a wheel array; done once, outside the loop.

        Args:
            axes: Spin axes, (3, wheels), of four wheels or more.
            momentum_limit: Momentum limit of the wheels, (wheels,) or one for all, N·m·s.
            share: Largest wanted momentum over the momentum limit.
            bands: Bands of the size of the momentum to be avoided, lower and upper end of each,
                (bands, 2), N·m·s.
            clearance: Distance from bands and limits that suffices, N·m·s.

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
        null = null_projection(axes)
        if np.trace(null) < 0.5:
            raise InputError(
                f"null-space control: found {count} wheels whose torques leave no freedom, "
                "expected more wheels than directions that they span"
            )
        # the pattern with the largest part in the null space; its first sign is arbitrary
        patterns = np.array([(1.0, *signs) for signs in product((1.0, -1.0), repeat=count - 1)])
        best = patterns[np.argmax(np.round(np.einsum("ki,ij,kj->k", patterns, null, patterns), 9))]
        ends = np.asarray(bands, dtype=float).reshape(-1, 2, 1) * np.ones(count)
        return cls(
            jnp.asarray(best),
            jnp.asarray(share * limit),
            bands=jnp.asarray(ends) if len(ends) else None,
            clearance=clearance,
        )


def null_projection(axes: Matrix) -> Matrix:
    """Projection N = 1 - A⁺ A onto the null space of axes, (wheels, wheels).

    Args:
        axes: Spin axes A, (3, wheels).
    """
    return np.eye(axes.shape[1]) - np.linalg.pinv(axes) @ axes


class _Gap(NamedTuple):
    """Gap of allowed values of z; see `NullSpaceControl`.

    Attributes:
        worth: Worth of the gap.
        begin: Lower end.
        end: Upper end.
        middle: Middle of its slow part.
    """

    worth: Scalar
    begin: Scalar
    end: Scalar
    middle: Scalar


class _Place(NamedTuple):
    """Null-space momentum z of the wheels and its limits; see `NullSpaceControl`.

    Attributes:
        now: Present value of z.
        zero: Value of z at which each wheel has zero speed, (wheels,).
        reach: Distance from there to the largest wanted momentum of each wheel, (wheels,); infinite
            for a wheel that z does not move.
        wear: Wear of each wheel, (wheels,).
    """

    now: Scalar
    zero: PerWheel
    reach: PerWheel
    wear: PerWheel

    def level(self, starts: Any, ends: Any, clearance: Scalar) -> tuple[Scalar, Bool[Array, ""]]:
        """Wanted value of z, and whether it is in another gap than the present one.

        Args:
            starts: Lower ends of the forbidden intervals of z, (intervals, wheels); infinite for a
                wheel that z does not move.
            ends: Upper ends of these.
            clearance: Distance from the ends of a gap that suffices.
        """
        z, zero = self.now, self.zero
        low, high = jnp.max(zero - self.reach), jnp.min(zero + self.reach)
        top = jnp.maximum(low, high)
        starts, ends = (jnp.clip(each, low, top).ravel() for each in (starts, ends))
        cost = jnp.tile(self.wear**2, starts.size // self.wear.size)
        slow = self.reach / self.wear
        slowest, fastest = jnp.max(zero - slow), jnp.min(zero + slow)

        # one candidate after the other: all at once would be a square of operations in flight code
        def compare(best: _Gap, begin: Scalar) -> tuple[_Gap, None]:
            # a gap begins at the end of an interval and ends at the next start of another; if that
            # other one has begun before, there is no gap
            end = jnp.minimum(jnp.min(jnp.where(ends > begin, starts, jnp.inf)), top)
            upward = (ends > z) & (ends <= begin)
            downward = (starts < z) & (starts >= end)
            crossings = jnp.sum(jnp.where(upward | downward, cost, 0.0))
            width = jnp.maximum(end - begin, 0.0)
            lower, upper = jnp.clip(slowest, begin, end), jnp.clip(fastest, begin, end)
            overlap = jnp.maximum(upper - lower, 0.0)
            stays = (begin <= z) & (z <= end) & (width > clearance) & (overlap > 0.0)
            worth = jnp.where(width > 0.0, overlap + BEYOND * width, 0.0) / (1.0 + crossings)
            trial = _Gap(jnp.where(stays, jnp.inf, worth), begin, end, 0.5 * (lower + upper))
            better = trial.worth > best.worth
            return _Gap(*(jnp.where(better, n, o) for n, o in zip(trial, best, strict=True))), None

        start = jnp.clip(z, low, top)
        gap = jax.lax.scan(compare, _Gap(0.0 * z, start, start, start), jnp.append(ends, low))[0]
        margin = jnp.minimum(clearance, 0.5 * (gap.end - gap.begin))
        target = jnp.clip(gap.middle, gap.begin + margin, gap.end - margin)
        crosses = jnp.asarray((gap.worth > 0.0) & ((z < gap.begin) | (z > gap.end)))
        return jnp.where(low < high, target, 0.5 * (low + high)), crosses
