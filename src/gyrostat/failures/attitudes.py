"""Attitudes by NumPy, for the few of a query.

`gyrostat.core.rotations` would be compiled first, which takes longer than the query, and SciPy's
rotations take longer to import. H. Schaub, J. L. Junkins, "Analytical Mechanics of Space Systems",
section 3.4.
"""

import numpy as np

from gyrostat.core.types import Matrix, Vector


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
    # of q and -q, the one whose first component that is not zero is positive
    sign = next((np.sign(part) for part in product if part != 0.0), 1.0)
    return sign * product / np.linalg.norm(product) + np.zeros(4)
