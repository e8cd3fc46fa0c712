"""Rotations of a body: quaternions, direction cosines, rotation vectors, MRP and 3-1-3 angles.

A quaternion q = (q0, q1, q2, q3) is scalar first, of unit length, and gives the attitude of the
body with respect to inertial space: v_inertial = R(q) v_body. q and -q are the same attitude. Rates
are those of the body in inertial space, in body axes, rad/s. Every function takes one attitude;
`vmap` gives many. H. Schaub, J. L. Junkins, "Analytical Mechanics of Space Systems", chapter 3,
whose [BN] is the transpose of R here.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp

SMALL_ANGLE = 1e-4
"""rad: below it series stand for sin(x)/x and its kin; their next terms are below 1e-17."""
UNIT_TOLERANCE = 1e-6
"""Of the length of a quaternion that is given."""
LEAST_SINE = 1e-9
"""Of theta: below it phi and psi of 3-1-3 angles cannot be told apart."""


class EulerAngles(NamedTuple):
    """Classical 3-1-3 angles, or their rates in time.

    Attributes:
        phi: first, about z, rad.
        theta: second, about x, rad.
        psi: third, about z, rad.
    """

    phi: Scalar
    theta: Scalar
    psi: Scalar


def cross_matrix(vector: Vector3) -> Float[Array, "3 3"]:
    """[v]x, so that [v]x u = v x u."""
    x, y, z = vector
    zero = jnp.zeros_like(x)
    return jnp.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """Hamilton product: R(first second) = R(first) R(second)."""
    a, u = first[0], first[1:]
    b, v = second[0], second[1:]
    return jnp.concatenate([(a * b - u @ v)[None], a * v + b * u + jnp.cross(u, v)])


def conjugate(quaternion: Quaternion) -> Quaternion:
    """The inverse rotation."""
    return quaternion * jnp.array([1.0, -1.0, -1.0, -1.0])


def normalised(quaternion: Quaternion) -> Quaternion:
    """The quaternion at unit length."""
    return quaternion / jnp.sqrt(quaternion @ quaternion)


def check_unit(quaternion: Float[Array, "... 4"]) -> None:
    """Refuse quaternions that are no attitudes.

    Raises:
        InputError: a length that is not 1.
    """
    lengths = np.linalg.norm(np.asarray(quaternion, dtype=float), axis=-1)
    bad = ~(np.abs(lengths - 1.0) < UNIT_TOLERANCE)
    if np.any(bad):
        raise InputError(
            f"attitude: found a quaternion of length {lengths[bad].flat[0]:g}, expected unit length"
        )


def to_inertial(quaternion: Quaternion, vector: Vector3) -> Vector3:
    """A vector in body axes, in inertial axes: R v."""
    scalar, axis = quaternion[0], quaternion[1:]
    twice = 2.0 * jnp.cross(axis, vector)
    return vector + scalar * twice + jnp.cross(axis, twice)


def to_body(quaternion: Quaternion, vector: Vector3) -> Vector3:
    """A vector in inertial axes, in body axes: R' v."""
    return to_inertial(conjugate(quaternion), vector)


def rotation_matrix(quaternion: Quaternion) -> Float[Array, "3 3"]:
    """R: its columns are the body axes in inertial space."""
    q0, q1, q2, q3 = quaternion
    return jnp.array(
        [
            [1.0 - 2.0 * (q2**2 + q3**2), 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)],
            [2.0 * (q1 * q2 + q0 * q3), 1.0 - 2.0 * (q1**2 + q3**2), 2.0 * (q2 * q3 - q0 * q1)],
            [2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), 1.0 - 2.0 * (q1**2 + q2**2)],
        ]
    )


def from_matrix(matrix: Float[Array, "3 3"]) -> Quaternion:
    """Quaternion of a rotation matrix, its scalar part not negative (Shepperd's method)."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    # four forms of 4 q_k q: the row of the largest component divides by no small number
    rows = jnp.array(
        [
            [1.0 + a + e + i, h - f, c - g, d - b],
            [h - f, 1.0 + a - e - i, b + d, c + g],
            [c - g, b + d, 1.0 - a + e - i, f + h],
            [d - b, c + g, f + h, 1.0 - a - e + i],
        ]
    )
    best = normalised(rows[jnp.argmax(jnp.diagonal(rows))])
    return jnp.where(best[0] < 0.0, -best, best)


def from_rotation_vector(vector: Vector3) -> Quaternion:
    """Quaternion of a turn about `vector` by its length, rad."""
    squared = vector @ vector
    small = squared < SMALL_ANGLE**2
    angle = jnp.sqrt(jnp.where(small, 1.0, squared))
    scale = jnp.where(small, 0.5 - squared / 48.0, jnp.sin(0.5 * angle) / angle)
    scalar = jnp.where(small, 1.0 - squared / 8.0, jnp.cos(0.5 * angle))
    return jnp.concatenate([scalar[None], scale * vector])


def rotation_vector(quaternion: Quaternion) -> Vector3:
    """Axis times angle of the shortest turn, rad, at most pi long."""
    shortest = jnp.where(quaternion[0] < 0.0, -quaternion, quaternion)
    scalar, axis = shortest[0], shortest[1:]
    squared = axis @ axis
    small = squared < SMALL_ANGLE**2
    length = jnp.sqrt(jnp.where(small, 1.0, squared))
    scale = jnp.where(small, 2.0 + squared / 3.0, 2.0 * jnp.arctan2(length, scalar) / length)
    return scale * axis


def rate_of_quaternion(quaternion: Quaternion, rate: Vector3) -> Quaternion:
    """dq/dt at a body rate, 1/s."""
    return 0.5 * product(quaternion, jnp.concatenate([jnp.zeros(1), rate]))


def error(quaternion: Quaternion, target: Quaternion) -> Quaternion:
    """The turn, in body axes, from a target attitude to this one, its scalar part not negative."""
    turn = product(conjugate(target), quaternion)
    return jnp.where(turn[0] < 0.0, -turn, turn)


def error_angle(quaternion: Quaternion, target: Quaternion) -> Scalar:
    """Angle of the shortest turn between two attitudes, rad, in [0, pi]."""
    turn = error(quaternion, target)
    return 2.0 * jnp.arctan2(jnp.sqrt(turn[1:] @ turn[1:]), turn[0])


def angle_between(first: Vector3, second: Vector3) -> Scalar:
    """Angle between two directions, rad, exact for small angles too; 0 where one has no length."""
    normal = jnp.cross(first, second)
    return jnp.arctan2(jnp.sqrt(normal @ normal), first @ second)


def to_mrp(quaternion: Quaternion) -> Vector3:
    """Modified Rodrigues parameters axis tan(angle / 4), of length 1 or less."""
    shortest = jnp.where(quaternion[0] < 0.0, -quaternion, quaternion)
    return shortest[1:] / (1.0 + shortest[0])


def from_mrp(mrp: Vector3) -> Quaternion:
    """Quaternion of modified Rodrigues parameters."""
    squared = mrp @ mrp
    return jnp.concatenate([(1.0 - squared)[None], 2.0 * mrp]) / (1.0 + squared)


def mrp_rate_matrix(mrp: Vector3) -> Float[Array, "3 3"]:
    """G, so that d(mrp)/dt = G w at a body rate w."""
    eye = jnp.eye(3)
    return 0.25 * ((1.0 - mrp @ mrp) * eye + 2.0 * cross_matrix(mrp) + 2.0 * jnp.outer(mrp, mrp))


def from_euler(angles: EulerAngles) -> Quaternion:
    """Quaternion of 3-1-3 angles: R = R_z(phi) R_x(theta) R_z(psi)."""
    half, total, difference = (
        0.5 * jnp.asarray(angles.theta),
        0.5 * (angles.phi + angles.psi),
        0.5 * (angles.phi - angles.psi),
    )
    return jnp.stack(
        [
            jnp.cos(half) * jnp.cos(total),
            jnp.sin(half) * jnp.cos(difference),
            jnp.sin(half) * jnp.sin(difference),
            jnp.cos(half) * jnp.sin(total),
        ]
    )


def to_euler(quaternion: Quaternion) -> tuple[EulerAngles, Bool[Array, ""]]:
    """3-1-3 angles with theta in [0, pi], phi and psi in (-pi, pi].

    Returns:
        The angles, and whether they are told apart: where theta is 0 or pi only the sum or the
        difference of phi and psi is, and psi is given as 0.
    """
    q0, q1, q2, q3 = quaternion
    across, along = jnp.hypot(q1, q2), jnp.hypot(q0, q3)
    valid = 2.0 * across * along >= LEAST_SINE
    total, difference = jnp.arctan2(q3, q0), jnp.arctan2(q2, q1)
    # where one pair of components is zero, the other holds all that is known
    total = jnp.where(along * 2.0 >= LEAST_SINE, total, difference)
    difference = jnp.where(across * 2.0 >= LEAST_SINE, difference, total)

    def wrapped(angle):
        return jnp.arctan2(jnp.sin(angle), jnp.cos(angle))

    angles = EulerAngles(
        wrapped(total + difference), 2.0 * jnp.arctan2(across, along), wrapped(total - difference)
    )
    return angles, valid


def rate_of_euler(angles: EulerAngles, rates: EulerAngles) -> Vector3:
    """Body rate of 3-1-3 angles that change at `rates`, rad/s.

    Carvalho and Fenili, "Nonlinear attitude control of artificial satellites considering failure in
    momentum wheels", section 2, with the sign in omega_y corrected.
    """
    sine, cosine = jnp.sin(angles.psi), jnp.cos(angles.psi)
    across = rates.phi * jnp.sin(angles.theta)
    return jnp.stack(
        [
            across * sine + rates.theta * cosine,
            across * cosine - rates.theta * sine,
            rates.phi * jnp.cos(angles.theta) + rates.psi,
        ]
    )


def euler_rates(angles: EulerAngles, rate: Vector3) -> tuple[EulerAngles, Bool[Array, ""]]:
    """Rates of 3-1-3 angles at a body rate.

    Returns:
        The rates, and whether they exist: not where sin(theta) is zero; they are zero there, which
        is no rate.
    """
    sine, cosine = jnp.sin(angles.psi), jnp.cos(angles.psi)
    height = jnp.sin(angles.theta)
    valid = jnp.abs(height) >= LEAST_SINE
    across = rate[0] * sine + rate[1] * cosine
    phi = jnp.where(valid, across / jnp.where(valid, height, 1.0), 0.0)
    theta = jnp.where(valid, rate[0] * cosine - rate[1] * sine, 0.0)
    psi = jnp.where(valid, rate[2] - phi * jnp.cos(angles.theta), 0.0)
    return EulerAngles(phi, theta, psi), valid
