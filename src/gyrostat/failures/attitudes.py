"""Attitudes by NumPy, for the few of a query.

`gyrostat.core.rotations` would be compiled first, which takes longer than the query, and SciPy's
rotations take longer to import. H. Schaub, J. L. Junkins, "Analytical Mechanics of Space Systems",
section 3.4.

Functions without a branch are also compiled, for pages: `gyrostat.codegen.numpy_tracing`.
"""

import numpy as np

from gyrostat.core.directions import across
from gyrostat.core.types import Matrix, Vector

PARALLEL = 1e-9
"""Sine of the angle below which two directions count as one."""


def matrix_of(quaternion: Vector) -> Matrix:
    """Rotation matrix, (3, 3), from body to inertial axes.

    Args:
        quaternion: Attitude, (4,), scalar first; it is normalised.
    """
    scalar, *axis = quaternion / np.linalg.norm(quaternion)
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * (scalar * cross + cross @ cross)


def turned(quaternion: Vector, axis: Vector, angle: float) -> Vector:
    """Attitude after a rotation about an axis of the body; the scalar part is not negative.

    Args:
        quaternion: Attitude before, (4,), scalar first; it is normalised.
        axis: Unit vector, body axes, (3,).
        angle: Angle of the rotation, rad.
    """
    scalar, vector = quaternion[0], quaternion[1:]
    cosine, half = np.cos(0.5 * angle), np.sin(0.5 * angle) * axis
    vector_part = scalar * half + cosine * vector + np.cross(vector, half)
    product = np.array([scalar * cosine - vector @ half, *vector_part])
    return _unit(product)


def quaternion_of(matrix: Matrix) -> Vector:
    """Attitude, (4,), of a rotation matrix from body to inertial axes (Shepperd's method).

    Args:
        matrix: Rotation matrix, (3, 3).
    """
    (a, b, c), (d, e, f), (g, h, i) = ([matrix[j, k] for k in range(3)] for j in range(3))
    # four multiples of the quaternion: the row of its largest component is well conditioned
    rows = [
        [1.0 + a + e + i, h - f, c - g, d - b],
        [h - f, 1.0 + a - e - i, b + d, c + g],
        [c - g, b + d, 1.0 - a + e - i, f + h],
        [d - b, c + g, f + h, 1.0 - a - e + i],
    ]
    largest = np.argmax(np.stack([rows[k][k] for k in range(4)]))
    return _unit((1.0 * (np.arange(4) == largest)) @ np.stack([np.stack(row) for row in rows]))


def _unit(q: Vector) -> Vector:
    """Unit quaternion; of q and -q, the one whose first component that is not zero is positive."""
    first = q[3]
    for k in (2, 1, 0):
        first = np.where(q[k] != 0.0, q[k], first)
    return np.where(first < 0.0, -1.0, 1.0) * q / np.linalg.norm(q) + np.zeros(4)


def triad(body: Vector, body_other: Vector, inertial: Vector, inertial_other: Vector) -> Vector:
    """Attitude, (4,), that aligns one direction exactly and another as well as possible (TRIAD).

    Args:
        body: Unit vector in body axes, (3,).
        body_other: Other vector in body axes, (3,).
        inertial: Unit vector in inertial axes that `body` is aligned with, (3,).
        inertial_other: Other vector in inertial axes, (3,).
    """
    frames = []
    for first, second in ((body, body_other), (inertial, inertial_other)):
        normal = np.cross(first, second)
        is_parallel = np.linalg.norm(normal) <= PARALLEL * np.linalg.norm(second)
        normal = np.where(is_parallel, across(first), normal)
        normal = normal / np.linalg.norm(normal)
        frames.append(np.stack([first, np.cross(normal, first), normal], axis=1))
    return quaternion_of(frames[1] @ np.transpose(frames[0]))
