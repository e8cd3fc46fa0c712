"""Local controllability of the attitude by the working wheels about an equilibrium.

Linearise about rest with the momentum b = R'H0 in body axes. Small rotations t and changes k of the
momenta of the working wheels obey, with the motor torques u on the body,

    d/dt (t, k) = A (t, k) - (0, u),    A = [[J^-1 [b]x, -J^-1 W], [0, 0]],

because d(b) = b x t. The total momentum is conserved, and the body rate is eliminated by it. The
pair (t, k) is therefore all that can change at constant total momentum, and 3 + N is full rank.
"""

import numpy as np

from gyrostat.core.types import Matrix, Vector

ANGLE_TOLERANCE = 1e-6
"""Sine of the angle below which two directions count as parallel."""


def controllability_matrix(inertia: Matrix, axes: Matrix, momentum: Vector) -> Matrix:
    """Controllability matrix [B, AB, A^2 B, A^3 B]; higher powers add no rank.

    Args:
        inertia: Inertia, (3, 3), kg·m².
        axes: Axes of the working wheels, (3, N).
        momentum: Total momentum in body axes, (3,), N·m·s.

    Returns:
        The matrix, (3 + N, 4 N).
    """
    count = axes.shape[1]
    inverse = np.linalg.inv(inertia)
    system = np.zeros((3 + count, 3 + count))
    system[:3, :3] = inverse @ np.cross(np.eye(3), momentum)
    system[:3, 3:] = -inverse @ axes
    blocks = [np.vstack([np.zeros((3, count)), -np.eye(count)])]
    for _ in range(3):
        blocks.append(system @ blocks[-1])
    return np.hstack(blocks)


def is_controllable(inertia: Matrix, axes: Matrix, rank: int, momentum: Vector) -> bool:
    """Whether the working wheels control the attitude, to first order, about rest.

    By the Hautus test, an uncontrollable mode is a left eigenvector J y of the attitude part with y
    orthogonal to every axis and b x y = -s J y. If the axes span space there is none. If they span
    a plane with normal n, only y = n remains, with s = 0, hence n x b = 0. For one axis a, a real y
    needs s = 0 and y along b, hence a.b = 0. A complex y spans the plane orthogonal to J b, which
    must be the plane orthogonal to a, hence b x J^-1 a = 0. Without momentum only the span of the
    axes is controlled.

    Args:
        inertia: Inertia, (3, 3), kg·m².
        axes: Axes of the working wheels, projected on their span, (3, N).
        rank: Rank of the axes.
        momentum: Total momentum in body axes, (3,), N·m·s; zero if there is none.
    """
    length = float(np.linalg.norm(momentum))
    if rank == 3:
        return True
    if rank == 0 or length == 0.0:
        return False
    along = momentum / length
    basis = np.linalg.svd(axes)[0]
    if rank == 2:
        return bool(np.linalg.norm(np.cross(basis[:, 2], along)) > ANGLE_TOLERANCE)
    axis, response = basis[:, 0], np.linalg.solve(inertia, basis[:, 0])
    sine = np.linalg.norm(np.cross(along, response / np.linalg.norm(response)))
    return bool(min(abs(axis @ along), sine) > ANGLE_TOLERANCE)
