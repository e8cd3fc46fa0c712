"""Friction torque over speed with its derivatives, by one compiled function for each model."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.stored_function import stored_function
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.prediction import padded
from gyrostat.wheel.friction import Friction


class FrictionTorques(NamedTuple):
    """Friction at m speeds.

    Attributes:
        torque: Torque, (m,), N·m.
        dry: Torque without its viscous part, (m,), N·m.
        by_parameters: Derivatives of the torque by the n parameters of the model, (m, n).
        by_speed: Derivative of the torque by the speed, (m,), N·m·s/rad.
    """

    torque: Vector
    dry: Vector
    by_parameters: Matrix
    by_speed: Vector


@lru_cache
def _program(model: type[Friction]):
    names = tuple(model.dimensions())

    def parts(theta, speed, direction):
        friction = model.of(**dict(zip(names, theta, strict=True)))
        torque = friction.torque(speed, direction)
        return torque, torque - friction.viscous_torque(speed, direction)

    def point(theta, speed, direction):
        slopes, _ = jax.jacfwd(parts, (0, 1))(theta, speed, direction)
        fields: Any = (*parts(theta, speed, direction), *slopes)
        return FrictionTorques(*fields)

    return stored_function(jax.vmap(point, (None, 0, 0)), model)


def friction_torques(
    model: type[Friction], values: Mapping[str, float], speed: Vector
) -> FrictionTorques:
    """Friction torques at some speeds; at speed 0 those of a start in positive direction.

    Args:
        model: Friction model.
        values: Name -> value of its parameters, SI.
        speed: Wheel speeds, (m,), rad/s.
    """
    at = padded(np.asarray(speed, dtype=float), repeat=True)
    theta = np.array([values[n] for n in model.dimensions()], dtype=float)
    torques = _program(model)(theta, at, np.where(at < 0.0, -1.0, 1.0))
    return FrictionTorques(*(np.asarray(part)[: len(speed)] for part in torques))
