"""Slews that lead boresights around keep-out cones, in the shortest time that was found."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float
from numpy.typing import ArrayLike

from gyrostat.control.guidance.bowed_path import BowedPath
from gyrostat.control.guidance.keep_out_cones import KeepOutCones
from gyrostat.control.guidance.path_timing import SHARES, fastest
from gyrostat.control.guidance.slew import SlewLimits
from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.control.guidance.wheel_envelope import WheelRoom
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import Tracer, jax, jnp

SAMPLES = 33, 65
"""Samples of a path in the search and of the path that is taken."""
SIZES = np.geomspace(0.02, 2.4, 12)
"""Sizes of the bows of the coarse search, rad."""
SIDES = 20
"""Directions of the bows of the coarse search, all around the eigenaxis."""
ROUNDS = 18
"""Rounds of the refinement."""
BLOCKED = 1e9
"""Cost of a path that enters a cone, s, times 1 plus its excess."""
TINY = 1e-9
"""Angle of a slew below which it has no axis, rad."""


class PlannedSlew(NamedTuple):
    """Path and timing of a slew from rest to rest.

    Attributes:
        path: Attitude over the progress.
        profile: Progress over time.
        is_clear: Whether the whole path is outside of all cones.
        ends_blocked: Whether the start and the end are inside a cone, (2,); then no path is clear.
        has_room: Whether the wheels have room for the momentum of the body along the path, at rest
            and at 1e-4 rad/s; if not, the slew asks for more than their limits.
        crossings: Number of wheels that pass through zero speed.
    """

    path: BowedPath
    profile: SlewProfile
    is_clear: Bool[Array, ""]
    ends_blocked: Bool[Array, " 2"]
    has_room: Bool[Array, ""]
    crossings: Scalar

    @property
    def duration(self) -> Scalar:
        """Duration, s."""
        return self.profile.duration

    def __call__(self, time: Scalar) -> Quaternion:
        """Attitude at a time after the start, s; constant before the start and after the end."""
        return self.path(self.profile(time))


class SlewCase(NamedTuple):
    """Slew to plan.

    Attributes:
        start: Attitude at the start, (4,).
        end: Attitude at the end, (4,).
        cones: Cones that boresights stay out of.
        limits: Limits of the slew.
        room: Wheels that it may use; None: they are not considered.
        crossing_time: Time that may be lost to avoid a zero crossing of a wheel, s; None: no time.
    """

    start: Quaternion
    end: Quaternion
    cones: KeepOutCones
    limits: SlewLimits
    room: WheelRoom | None
    crossing_time: Scalar | None = None

    @property
    def turn(self) -> Vector3:
        """Rotation vector of the eigenaxis slew, (3,), rad."""
        return rotations.rotation_vector(rotations.error(self.end, self.start))

    def eigenaxis(self) -> PlannedSlew:
        """Eigenaxis slew, whether it is clear or not."""
        return self.planned(BowedPath.eigenaxis(self.start, self.turn))

    def planned(self, path: BowedPath) -> PlannedSlew:
        """Slew along a path."""
        samples = path.sampled(SAMPLES[1])
        timing = fastest(path, samples, self.limits, self.room, self.crossing_time, SHARES[1])
        profile = timing.profile(samples, self.limits.jerk)
        ends = jnp.stack([jnp.any(self.cones.clearance(q) < 0.0) for q in (self.start, self.end)])
        is_clear = jnp.asarray(self.cones.excess(path, samples) <= 0.0)
        return PlannedSlew(path, profile, is_clear, ends, timing.has_room, timing.crossings)

    def bowed(self) -> PlannedSlew:
        """Fastest clear slew of a search over bows; if none is clear, the one with least excess.

        A grid of bows across the axis, on the shorter and on the longer way around, gives the
        first paths; the best of each way and half of the sides, so that they differ, are refined by
        a pattern search over both bows. The number of operations is fixed, and both parts take
        their costs in one loop, as compiling them twice takes longer than the search.
        """
        turn = self.turn
        angle = jnp.sqrt(turn @ turn)
        axis = jnp.where(angle > TINY, turn / jnp.maximum(angle, TINY), jnp.eye(3)[0])
        sides = _across(axis)
        ways = jnp.repeat(jnp.stack([angle, angle - 2.0 * jnp.pi]), 2)

        def path(way: Scalar, shape: Float[Array, " 4"]) -> BowedPath:
            eigenaxis = BowedPath.eigenaxis(self.start, way * axis)
            return eigenaxis._replace(bow=shape[:2] @ sides, twist=shape[2:] @ sides)

        def cost(way: Scalar, shape: Float[Array, " 4"]) -> Scalar:
            bowed = path(way, shape)
            sampled = bowed.sampled(SAMPLES[0])
            timing = fastest(bowed, sampled, self.limits, self.room, self.crossing_time)
            excess = self.cones.excess(bowed, sampled)
            time = timing.duration
            if self.crossing_time is not None:
                time = time + self.crossing_time * timing.crossings
            time = jnp.where(timing.has_room, time, 0.5 * BLOCKED)
            return jnp.where(excess <= 0.0, time, BLOCKED * (1.0 + excess))

        costs = jax.vmap(lambda way, shapes: jax.vmap(lambda shape: cost(way, shape))(shapes))
        grid, moves = jnp.asarray(_grid()), jnp.concatenate([jnp.eye(4), -jnp.eye(4)])

        def once(k: Any, state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
            shape, least, step = state
            is_coarse = k < len(grid)
            tried = shape[:, None] + step[:, None, None] * moves
            tried = jnp.where(is_coarse, grid[jnp.minimum(k, len(grid) - 1)], tried)
            found = jnp.asarray(costs(ways, tried))
            best = jnp.argmin(found, axis=1)[:, None]
            lower = jnp.take_along_axis(found, best, 1)[:, 0]
            better = lower < least
            chosen = jnp.take_along_axis(tried, best[..., None], 1)[:, 0]
            shape = jnp.where(better[:, None], chosen, shape)
            first = 0.3 * jnp.sqrt(jnp.sum(shape**2, axis=1))
            step = jnp.where(is_coarse, first, jnp.where(better, 1.2 * step, 0.5 * step))
            return shape, jnp.where(better, lower, least), step

        seeds = jnp.zeros((4, 4)), jnp.full(4, jnp.inf), jnp.zeros(4)
        shapes, refined, _ = jax.lax.fori_loop(0, len(grid) + ROUNDS, once, seeds)
        best = jnp.argmin(refined)
        return self.planned(path(ways[best], shapes[best]))


def _across(axis: Vector3) -> Float[Array, "2 3"]:
    """Two unit vectors across an axis and each other."""
    least = jnp.eye(3)[jnp.argmin(jnp.abs(axis))]
    first = jnp.cross(axis, least)
    first = first / jnp.sqrt(first @ first)
    return jnp.stack([first, jnp.cross(axis, first)])


def _grid() -> Float[np.ndarray, "blocks 4 8 4"]:
    """Bows of the coarse search in blocks of 8, for both ways and both halves of the sides."""
    side = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    directions = np.stack([np.cos(side), np.sin(side)], axis=1)
    bows = (directions[:, None] * SIZES[:, None]).reshape(2, -1, 8, 2)  # halves, blocks
    bows = np.concatenate([bows, np.zeros_like(bows)], axis=3)
    return np.moveaxis(np.concatenate([bows, bows]), 0, 1)


def plan_slew(
    start: ArrayLike,
    end: ArrayLike,
    cones: KeepOutCones,
    limits: SlewLimits,
    time: Scalar = 0.0,
    crossing_time: Scalar | None = None,
) -> PlannedSlew:
    """Plan a slew from rest to rest that leads boresights around keep-out cones.

    The eigenaxis slew if it is clear, otherwise the fastest clear path of a deterministic search;
    can be traced by JAX. If no path is clear, `PlannedSlew.is_clear` is false.

    Args:
        start: Attitude at the start, (4,).
        end: Attitude at the end, (4,).
        cones: Cones that boresights stay out of.
        limits: Limits of the slew.
        time: Time of its start, s; it decides which wheels of the envelope work.
        crossing_time: Time that may be lost to avoid a zero crossing of a wheel, s; None: no time.

    Raises:
        InputError: An attitude that is not traced is not a unit quaternion.
    """
    first, last = (jnp.asarray(each, dtype=float) for each in (start, end))
    for name, attitude in (("start", first), ("end", last)):
        if attitude.shape != (4,):
            raise InputError(f"{name}: found shape {attitude.shape}, expected (4,)")
        if not isinstance(attitude, Tracer):
            rotations.check_unit(attitude)
    return _plan(SlewCase(first, last, cones, limits, limits.room(time), crossing_time))


@jax.jit
def _plan(case: SlewCase) -> PlannedSlew:
    eigenaxis = case.eigenaxis()
    done = eigenaxis.is_clear
    if case.crossing_time is not None:
        # a detour may be worth its time
        done &= (eigenaxis.crossings == 0) | (case.crossing_time <= 0.0)
    done |= jnp.any(eigenaxis.ends_blocked)
    return jax.lax.cond(done, lambda: eigenaxis, case.bowed)
