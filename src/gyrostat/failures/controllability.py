"""Local controllability of attitude by the working wheels about an equilibrium.

About rest with the momentum b = R'H0 in body axes, small turns t and changes k of the momenta of
the working wheels obey, with the motor torques u on the body,

    d/dt (t, k) = A (t, k) - (0, u),    A = [[J^-1 [b]x, -J^-1 W], [0, 0]],

because d(b) = b x t. The total momentum is conserved, and the rate is already eliminated by it: the
pair (t, k) is all that can change on its level set, and 3 + N is full rank.
"""

import numpy as np

from gyrostat.core.types import Matrix, Vector

ANGLE_TOLERANCE = 1e-6
"""Sine of the angle from a direction about which the wheels have no say."""


def controllability_matrix(inertia: Matrix, axes: Matrix, momentum: Vector) -> Matrix:
    """[B, AB, A^2 B, A^3 B] of the pair above; the turns answer within these.

    Args:
        inertia: (3, 3), kg·m².
        axes: (3, N) axes of the working wheels.
        momentum: (3,) in body axes, N·m·s.

    Returns:
        (3 + N, 4 N).
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
    """Whether the working wheels control the attitude, to first order, about a point of rest.

    A left eigenvector of the attitude's part that the wheels do not touch is J y with y orthogonal
    to every axis and b x y = -s J y. With axes that span space there is none; for a plane with the
    normal n only y = n is left, and s = 0: n x b = 0. For one axis a, a real y needs s = 0, y along
    b and so a.b = 0; a complex one spans the plane orthogonal to J b, which must be that orthogonal
    to a: b x J^-1 a = 0. Without momentum no more than the axes themselves is controlled.

    Args:
        inertia: (3, 3), kg·m².
        axes: (3, N) axes of the working wheels, in their span.
        rank: of the axes.
        momentum: (3,) in body axes, N·m·s; zero where there is none.
    """
    length = float(np.linalg.norm(momentum))
    if rank == 3:
        return True
    if rank == 0 or length == 0.0:
        return False
    along = momentum / length
    left = np.linalg.svd(axes)[0]
    if rank == 2:
        return bool(np.linalg.norm(np.cross(left[:, 2], along)) > ANGLE_TOLERANCE)
    axis, turned = left[:, 0], np.linalg.solve(inertia, left[:, 0])
    aside = np.linalg.norm(np.cross(along, turned / np.linalg.norm(turned)))
    return bool(min(abs(axis @ along), aside) > ANGLE_TOLERANCE)
