"""Cones that a slew leads around: those of the instruments, with the motion of the bodies."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from gyrostat.codegen.evaluation import evaluated
from gyrostat.control.guidance import KeepOutCones, Profile
from gyrostat.core import rotations
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.spacecraft.sensors.keep_out import BODIES, KeepOut, Sight


class SlewCones(NamedTuple):
    """Cones of a slew in axes of its target attitude.

    Attributes:
        cones: The cones; an angle of 0 is none.
        names: Instrument and body of each cone, for messages.
        motion: Largest angle by which a cone is wider because of the motion of its body, rad.
        wider: Angle by which every cone is wider beside it, rad.
    """

    cones: KeepOutCones
    names: tuple[str, ...]
    motion: float
    wider: float


def slew_cones(
    instruments: Mapping[str, KeepOut],
    names: tuple[str, ...],
    target: Profile,
    times: Vector,
    wider: float,
) -> SlewCones:
    """Cones that enclose what instruments must not see at any of some times.

    In axes of the target, a direction moves with the body and against the target. A cone is about
    the mean of its directions, and reaches as far as the farthest one. The largest step between two
    neighbours is added, for the times between them. Bodies that are hidden are left out, but for
    the time next to one at which they are not.

    Args:
        instruments: Name -> each instrument.
        names: Names of those that the slew leads around.
        target: Attitude over time at the end of the slew.
        times: Equidistant times, s.
        wider: Angle by which every cone is wider, rad.
    """
    sights = _sights(tuple(instruments.values()), target, times)
    boresights, directions, angles, labels, motion = [], [], [], [], 0.0
    for (name, instrument), seen in zip(instruments.items(), sights, strict=True):
        for body, sight, angle in zip(BODIES, seen, instrument.angles, strict=True):
            rows = _with_neighbours(np.asarray(sight.is_visible))
            if name not in names or float(angle) <= 0.0 or not np.any(rows):
                direction, reach = np.array([0.0, 0.0, 1.0]), 0.0
            else:
                radius = np.asarray(sight.radius)
                direction, reach = _enclosing(np.asarray(sight.direction), radius, rows)
                motion = max(motion, reach - float(np.min(radius[rows])))
                reach += float(angle) + wider
            boresights.append(np.asarray(instrument.boresight, dtype=float))
            directions.append(direction)
            angles.append(min(reach, np.pi))
            labels.append(f"{name} and {BODIES[body]}")
    axes = np.array(boresights)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    cones = KeepOutCones(*(jnp.asarray(each) for each in (axes, np.array(directions), angles)))
    return SlewCones(cones, tuple(labels), motion, wider)


@evaluated
def _sights(
    instruments: tuple[KeepOut, ...], target: Profile, times: Vector
) -> list[tuple[Sight, ...]]:
    """Bodies of each instrument at each time; unit vectors in axes of the target."""

    def seen(instrument: KeepOut, time: Scalar) -> tuple[Sight, ...]:
        attitude = rotations.normalised(jnp.asarray(target(time), dtype=float))
        return tuple(
            each._replace(
                direction=rotations.to_body(attitude, rotations.normalised(each.direction))
            )
            for each in instrument.sights(time)
        )

    return [
        jax.vmap(lambda time, each=each: seen(each, time))(jnp.asarray(times))
        for each in instruments
    ]


def _with_neighbours(rows: Bool[np.ndarray, " times"]) -> Bool[np.ndarray, " times"]:
    wider = rows.copy()
    wider[1:] |= rows[:-1]
    wider[:-1] |= rows[1:]
    return wider


def _enclosing(
    directions: Matrix, radii: Vector, rows: Bool[np.ndarray, " times"]
) -> tuple[Float[np.ndarray, " 3"], float]:
    """Axis and half angle of a cone that contains discs about some directions."""
    mean = np.mean(directions[rows], axis=0)
    length = float(np.linalg.norm(mean))
    axis = mean / length if length > 0.0 else directions[rows][0]
    steps = _angles(directions[1:], directions[:-1]) + np.abs(np.diff(radii))
    reach = np.max(_angles(directions[rows], axis) + radii[rows])
    return axis, float(reach + np.max(steps))


def _angles(first: Matrix, second: Matrix | Vector) -> Vector:
    normal = np.linalg.norm(np.cross(first, second), axis=-1)
    return np.arctan2(normal, np.sum(first * second, axis=-1))
