"""Attitude as angles relative to the total angular momentum."""

from typing import NamedTuple

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jnp


class MomentumFrame(NamedTuple):
    """Components of the total momentum b relative to a body axis n, in body axes.

    Attributes:
        along: Component n.b, N·m·s.
        across: Component |n x b|, N·m·s.
        angle: Angle between n and b, rad.
        radial: Unit vector of the part of b orthogonal to n, (3,).
        tangent: Vector n x radial, (3,); a positive rotation about it turns n towards b.
    """

    along: Scalar
    across: Scalar
    angle: Scalar
    radial: Vector3
    tangent: Vector3


class MomentumAngles(NamedTuple):
    """Angles of an attitude relative to another attitude.

    Attributes:
        roll: Rotation about the total momentum, rad.
        spin: Rotation about the axis, rad.
        tilt: Rotation of the axis towards the momentum, rad.
    """

    roll: Scalar
    spin: Scalar
    tilt: Scalar


def momentum_frame(axis: Vector3, momentum: Vector3) -> MomentumFrame:
    """Components of a momentum along and across a unit vector, both in body axes."""
    along = axis @ momentum
    plane = momentum - along * axis
    # avoids a division by zero if axis and momentum are parallel
    across = jnp.sqrt(plane @ plane + 1e-24)
    radial = plane / across
    return MomentumFrame(along, across, jnp.arctan2(across, along), radial, jnp.cross(axis, radial))


def momentum_angles(
    attitude: Quaternion, target: Quaternion, total_momentum: Vector3, axis: Vector3
) -> MomentumAngles:
    """Roll, spin and tilt from a target to an attitude, with R_target exp(e) = R.

    exp(e) = exp(roll b_d/|b_d|) exp(tilt t_d) exp(spin n), with the momentum b_d and the tangent
    t_d in body axes at the target. These are 3-1-3 angles between an axis fixed in space and the
    axis n fixed in the body (P. C. Hughes, "Spacecraft Attitude Dynamics", section 2.3).

    Args:
        attitude: Attitude quaternion, scalar first, (4,).
        target: Target quaternion, scalar first, (4,).
        total_momentum: Total momentum in inertial axes, not zero, (3,), N·m·s.
        axis: Axis n in body axes, of unit length and not along the momentum at the target, (3,).

    Returns:
        Roll, spin and tilt; roll and spin are in (-pi, pi].
    """
    target_momentum = rotations.to_body(target, total_momentum)
    frame = momentum_frame(axis, rotations.to_body(attitude, total_momentum))
    goal = momentum_frame(axis, target_momentum)
    tilt = goal.angle - frame.angle
    spin = -jnp.arctan2(jnp.cross(goal.radial, frame.radial) @ axis, goal.radial @ frame.radial)
    rotation = rotations.product(
        rotations.from_rotation_vector(tilt * goal.tangent),
        rotations.from_rotation_vector(spin * axis),
    )
    turn = rotations.product(rotations.conjugate(target), attitude)
    turn = rotations.product(turn, rotations.conjugate(rotation))
    size = jnp.sqrt(target_momentum @ target_momentum)
    roll = 2.0 * jnp.arctan2(turn[1:] @ target_momentum / size, turn[0])
    return MomentumAngles(jnp.arctan2(jnp.sin(roll), jnp.cos(roll)), spin, tilt)
