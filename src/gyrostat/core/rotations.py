"""Rotations of a body: quaternions, direction cosines, rotation vectors, MRP and 3-1-3 angles.

A quaternion q = (q0, q1, q2, q3) is scalar first and of unit length. It gives the attitude of the
body with respect to inertial space: v_inertial = R(q) v_body. q and -q are the same attitude. A
body rate is the angular velocity of the body relative to inertial space, in body axes, rad/s. Every
function takes one attitude; use `vmap` for many. H. Schaub, J. L. Junkins, "Analytical Mechanics of
Space Systems", chapter 3; their [BN] is the transpose of R.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.traced_once import traced_once

SMALL_ANGLE = 1e-4
"""Angle below which series replace sin(x)/x and similar terms, rad. Series error: below 1e-17."""
UNIT_TOLERANCE = 1e-6
"""Largest deviation of the length of a given quaternion from 1."""
LEAST_SINE = 1e-9
"""Smallest sin(theta) at which phi and psi of 3-1-3 angles can be distinguished."""


class EulerAngles(NamedTuple):
    """Classical 3-1-3 Euler angles, or their time derivatives.

    Attributes:
        phi: First angle, about z, rad (or rad/s).
        theta: Second angle, about x, rad (or rad/s).
        psi: Third angle, about z, rad (or rad/s).
    """

    phi: Scalar
    theta: Scalar
    psi: Scalar


def cross_matrix(vector: Vector3) -> Float[Array, "3 3"]:
    """Cross-product matrix [v]x: [v]x u = v x u."""
    x, y, z = vector
    zero = jnp.zeros_like(x)
    return jnp.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


def direction_at(longitude: Scalar, latitude: Scalar) -> Vector3:
    """Unit vector at a longitude, about z from x, and a latitude, rad."""
    level = jnp.cos(latitude)
    up = jnp.sin(latitude) * jnp.ones(())
    return jnp.stack([level * jnp.cos(longitude), level * jnp.sin(longitude), up])


@traced_once
def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """Hamilton product: R(first second) = R(first) R(second)."""
    a, u = first[0], first[1:]
    b, v = second[0], second[1:]
    return jnp.concatenate([(a * b - u @ v)[None], a * v + b * u + jnp.cross(u, v)])


@traced_once
def conjugate(quaternion: Quaternion) -> Quaternion:
    """Conjugate of a quaternion: the inverse rotation."""
    return quaternion * jnp.array([1.0, -1.0, -1.0, -1.0])


@traced_once
def normalised(quaternion: Quaternion) -> Quaternion:
    """Quaternion scaled to unit length."""
    return quaternion / jnp.sqrt(quaternion @ quaternion)


def check_unit(quaternion: Float[Array, "... 4"]) -> None:
    """Validate that quaternions have unit length.

    Raises:
        InputError: The length of a quaternion is not 1.
    """
    lengths = np.linalg.norm(np.asarray(quaternion, dtype=float), axis=-1)
    bad = ~(np.abs(lengths - 1.0) < UNIT_TOLERANCE)
    if np.any(bad):
        raise InputError(
            f"attitude: found a quaternion of length {lengths[bad].flat[0]:g}, expected unit length"
        )


@traced_once
def to_inertial(quaternion: Quaternion, vector: Vector3) -> Vector3:
    """Transform a vector from body axes to inertial axes: R v."""
    scalar, axis = quaternion[0], quaternion[1:]
    twice = 2.0 * jnp.cross(axis, vector)
    return vector + scalar * twice + jnp.cross(axis, twice)


@traced_once
def to_body(quaternion: Quaternion, vector: Vector3) -> Vector3:
    """Transform a vector from inertial axes to body axes: R' v."""
    return to_inertial(conjugate(quaternion), vector)


@traced_once
def rotation_matrix(quaternion: Quaternion) -> Float[Array, "3 3"]:
    """Rotation matrix R of a quaternion. Its columns are the body axes in inertial axes."""
    q0, q1, q2, q3 = quaternion
    return jnp.array(
        [
            [1.0 - 2.0 * (q2**2 + q3**2), 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)],
            [2.0 * (q1 * q2 + q0 * q3), 1.0 - 2.0 * (q1**2 + q3**2), 2.0 * (q2 * q3 - q0 * q1)],
            [2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), 1.0 - 2.0 * (q1**2 + q2**2)],
        ]
    )


@traced_once
def from_matrix(matrix: Float[Array, "3 3"]) -> Quaternion:
    """Quaternion of a rotation matrix, with scalar part >= 0 (Shepperd's method)."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    # four multiples 4 q_k q of the quaternion: the row of the largest q_k is well conditioned
    rows = jnp.array(
        [
            [1.0 + a + e + i, h - f, c - g, d - b],
            [h - f, 1.0 + a - e - i, b + d, c + g],
            [c - g, b + d, 1.0 - a + e - i, f + h],
            [d - b, c + g, f + h, 1.0 - a - e + i],
        ]
    )
    best, largest = rows[0], rows[0, 0]
    for k in (1, 2, 3):
        is_larger = rows[k, k] > largest
        best = jnp.where(is_larger, rows[k], best)
        largest = jnp.where(is_larger, rows[k, k], largest)
    best = normalised(best)
    return jnp.where(best[0] < 0.0, -best, best)


@traced_once
def from_rotation_vector(vector: Vector3) -> Quaternion:
    """Quaternion of a rotation about the direction of `vector` by its length, rad."""
    squared = vector @ vector
    small = squared < SMALL_ANGLE**2
    angle = jnp.sqrt(jnp.where(small, 1.0, squared))
    scale = jnp.where(small, 0.5 - squared / 48.0, jnp.sin(0.5 * angle) / angle)
    scalar = jnp.where(small, 1.0 - squared / 8.0, jnp.cos(0.5 * angle))
    return jnp.concatenate([scalar[None], scale * vector])


@traced_once
def rotation_vector(quaternion: Quaternion) -> Vector3:
    """Rotation vector (axis times angle) of the shortest rotation, rad, of length at most pi."""
    shortest = jnp.where(quaternion[0] < 0.0, -quaternion, quaternion)
    scalar, axis = shortest[0], shortest[1:]
    squared = axis @ axis
    small = squared < SMALL_ANGLE**2
    length = jnp.sqrt(jnp.where(small, 1.0, squared))
    scale = jnp.where(small, 2.0 + squared / 3.0, 2.0 * jnp.arctan2(length, scalar) / length)
    return scale * axis


@traced_once
def rate_of_quaternion(quaternion: Quaternion, rate: Vector3) -> Quaternion:
    """Time derivative of a quaternion at a given body rate, 1/s."""
    return 0.5 * product(quaternion, jnp.concatenate([jnp.zeros(1), rate]))


@traced_once
def error(quaternion: Quaternion, target: Quaternion) -> Quaternion:
    """Error quaternion: rotation from target to actual attitude, body axes, scalar part >= 0."""
    turn = product(conjugate(target), quaternion)
    return jnp.where(turn[0] < 0.0, -turn, turn)


@traced_once
def error_angle(quaternion: Quaternion, target: Quaternion) -> Scalar:
    """Angle of the shortest rotation between two attitudes, rad, in [0, pi]."""
    turn = error(quaternion, target)
    return 2.0 * jnp.arctan2(jnp.sqrt(turn[1:] @ turn[1:]), turn[0])


@traced_once
def angle_between(first: Vector3, second: Vector3) -> Scalar:
    """Angle between two vectors, rad, accurate for small angles too; 0 if a vector is zero."""
    normal = jnp.cross(first, second)
    return jnp.arctan2(jnp.sqrt(normal @ normal), first @ second)


@traced_once
def to_mrp(quaternion: Quaternion) -> Vector3:
    """Modified Rodrigues parameters axis tan(angle / 4), of length 1 or less."""
    shortest = jnp.where(quaternion[0] < 0.0, -quaternion, quaternion)
    return shortest[1:] / (1.0 + shortest[0])


@traced_once
def from_mrp(mrp: Vector3) -> Quaternion:
    """Quaternion of modified Rodrigues parameters."""
    squared = mrp @ mrp
    return jnp.concatenate([(1.0 - squared)[None], 2.0 * mrp]) / (1.0 + squared)


def mrp_rate_matrix(mrp: Vector3) -> Float[Array, "3 3"]:
    """Kinematic matrix G of modified Rodrigues parameters: d(mrp)/dt = G w at body rate w."""
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
    """3-1-3 Euler angles of a quaternion: theta in [0, pi], phi and psi in (-pi, pi].

    Returns:
        The angles, and whether phi and psi are unique. If theta is 0 or pi, only their sum or
        difference is defined; psi is then 0.
    """
    q0, q1, q2, q3 = quaternion
    across, along = jnp.hypot(q1, q2), jnp.hypot(q0, q3)
    valid = 2.0 * across * along >= LEAST_SINE
    total, difference = jnp.arctan2(q3, q0), jnp.arctan2(q2, q1)
    # where one pair of components is zero, only the sum or only the difference is defined
    total = jnp.where(along * 2.0 >= LEAST_SINE, total, difference)
    difference = jnp.where(across * 2.0 >= LEAST_SINE, difference, total)

    def wrapped(angle):
        return jnp.arctan2(jnp.sin(angle), jnp.cos(angle))

    angles = EulerAngles(
        wrapped(total + difference), 2.0 * jnp.arctan2(across, along), wrapped(total - difference)
    )
    return angles, valid


def rate_of_euler(angles: EulerAngles, rates: EulerAngles) -> Vector3:
    """Body rate for given 3-1-3 angles and their rates, rad/s.

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
    """Rates of 3-1-3 angles at a given body rate.

    Returns:
        The rates, and whether they exist. They do not exist where sin(theta) is zero; zeros are
        returned there.
    """
    sine, cosine = jnp.sin(angles.psi), jnp.cos(angles.psi)
    height = jnp.sin(angles.theta)
    valid = jnp.abs(height) >= LEAST_SINE
    across = rate[0] * sine + rate[1] * cosine
    phi = jnp.where(valid, across / jnp.where(valid, height, 1.0), 0.0)
    theta = jnp.where(valid, rate[0] * cosine - rate[1] * sine, 0.0)
    psi = jnp.where(valid, rate[2] - phi * jnp.cos(angles.theta), 0.0)
    return EulerAngles(phi, theta, psi), valid
