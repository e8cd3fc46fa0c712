"""Attitudes in words, to show a user how a quaternion was understood."""

import numpy as np

from gyrostat.core.types import Vector

SMALL = 1e-6
"""Angle, rad, or component of a unit vector that is not shown."""
DEGENERATE = 5e-10
"""Sine or cosine of half the second angle below which the others are not unique."""


def euler_angles(quaternion: Vector) -> Vector:
    """3-1-3 angles of a unit quaternion (4,), scalar first: (3,), rad.

    If the second angle is 0 or pi, only the sum or the difference of the others is defined; the
    third one is then 0. See `gyrostat.core.rotations.to_euler`.
    """
    q0, q1, q2, q3 = quaternion
    across, along = np.hypot(q1, q2), np.hypot(q0, q3)
    total, difference = np.arctan2(q3, q0), np.arctan2(q2, q1)
    if across < DEGENERATE:
        difference = total
    elif along < DEGENERATE:
        total = difference
    first, last = total + difference, total - difference
    angles = np.array([first, 2.0 * np.arctan2(across, along), last])
    wrapped = np.arctan2(np.sin(angles), np.cos(angles))
    wrapped[1] = angles[1]
    return wrapped


def turn_text(quaternion: Vector) -> str:
    """Rotation from inertial axes in words, such as "turned by 180 deg about z".

    Args:
        quaternion: Unit quaternion, (4,), scalar first.
    """
    scalar, vector = quaternion[0], quaternion[1:]
    if scalar < 0.0:
        scalar, vector = -scalar, -vector
    sine = float(np.linalg.norm(vector))
    angle = 2.0 * np.arctan2(sine, scalar)
    if angle < SMALL:
        return "not turned: body axes along the inertial axes"
    axis = vector / sine
    largest = int(np.argmax(np.abs(axis)))
    if np.linalg.norm(np.delete(axis, largest)) < SMALL:
        is_negative = axis[largest] < 0.0 and np.pi - angle > SMALL  # a half turn has no sense
        name = f"{'-' if is_negative else ''}{'xyz'[largest]}"
    else:
        name = f"({_numbers(axis)})"
    return f"turned by {np.degrees(angle):.6g} deg about {name}"


def attitude_text(quaternion: Vector) -> str:
    """Attitude in words: rotation, 3-1-3 angles and quaternion.

    Args:
        quaternion: Unit quaternion, (4,), scalar first.
    """
    return f"{turn_and_angles(quaternion)}; quaternion {_numbers(quaternion)}, scalar first"


def turn_and_angles(quaternion: Vector) -> str:
    """Rotation and 3-1-3 angles of a unit quaternion (4,), scalar first, in words."""
    angles = _numbers(np.degrees(euler_angles(quaternion)))
    return f"{turn_text(quaternion)}; 3-1-3 angles {angles} deg"


def _numbers(values: Vector) -> str:
    components = np.where(np.abs(values) < SMALL, 0.0, values)
    return ", ".join(f"{value:.6g}" for value in components)
