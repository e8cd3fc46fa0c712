"""Directions in space: spread over the sphere, and across another one."""

import numpy as np

from gyrostat.core.types import Matrix, Vector


def spread_evenly(count: int) -> Matrix:
    """Directions that cover the sphere evenly, (count, 3): the spiral of Fibonacci."""
    number = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * number / count, np.pi * (1.0 + np.sqrt(5.0)) * number
    level = np.sqrt(1.0 - height**2)
    return np.stack([level * np.cos(turn), level * np.sin(turn), height], axis=1)


def across(direction: Vector) -> Vector:
    """Any unit vector orthogonal to a direction; any unit vector if the direction is zero."""
    axis = 1.0 * (np.arange(3) == np.argmin(np.abs(direction)))
    normal = np.cross(direction, axis)
    length = np.linalg.norm(normal)
    return np.where(length > 0.0, normal / np.where(length > 0.0, length, 1.0), np.eye(3)[0])
