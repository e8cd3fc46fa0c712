"""Friction curve of a law at fixed speeds, with its derivatives, by one program for each law."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.types import Matrix, Vector

POINTS = 160
"""Number of speeds above zero."""
SLOWEST = 1e-3
"""Smallest speed above zero, rad/s; no bearing bends its friction over less."""
BESIDE = 1e-9
"""Distance from zero speed at which a jump is looked for, rad/s."""


class SampledCurve(NamedTuple):
    """Friction in one direction of rotation at m speeds.

    Attributes:
        speed: Speed times direction, (m,), rad/s: just below zero, zero, just above it, and to the
            end of the law's `speed_range`.
        torque: Torque times direction, (m,), N·m.
        slope: Derivative of `torque` by `speed`, (m,), N·m·s/rad.
        bend: Second derivative, (m,), N·m·s²/rad².
        by_parameters: Derivatives of `torque` by the n parameters of the law, (m, n).
    """

    speed: Vector
    torque: Vector
    slope: Vector
    bend: Vector
    by_parameters: Matrix


@lru_cache
def _sampler(law: Any):
    """Program of torque and derivatives at many speeds for a class of laws."""
    names = tuple(law.dimensions())

    def torque(theta, size, direction):
        friction = law.of(**dict(zip(names, theta, strict=True)))
        return direction * friction.torque(direction * size, direction)

    def slopes(theta, size, direction):
        return jax.jacfwd(torque, (0, 1))(theta, size, direction)

    def point(theta, size, direction):
        by_parameters, slope = slopes(theta, size, direction)
        bend = jax.jacfwd(lambda w: slopes(theta, w, direction)[1])(size)
        return torque(theta, size, direction), slope, bend, by_parameters

    return jax.jit(jax.vmap(point, (None, 0, None)))


def sampled_curve(law: Any, theta: Vector, direction: float) -> SampledCurve:
    """Sample the friction curve of a law.

    Args:
        law: Class of a static friction law.
        theta: Its parameters in order, (n,), SI.
        direction: Direction of rotation, +1 or -1.
    """
    above = np.geomspace(SLOWEST, law.speed_range, POINTS)
    speed = np.concatenate([[-BESIDE, 0.0, BESIDE], above])
    # also inside of a function that is being traced
    with jax.ensure_compile_time_eval():
        parts = _sampler(law)(np.asarray(theta, dtype=float), speed, direction)
        return SampledCurve(speed, *(np.asarray(part) for part in parts))
