"""Attitude as angles relative to the total angular momentum."""

from typing import NamedTuple

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jnp


class MomentumFrame(NamedTuple):
    """The total momentum b in body axes, seen from a body axis n.

    Attributes:
        along: n.b, N·m·s.
        across: |n x b|, N·m·s.
        angle: between n and b, rad.
        radial: (3,) unit vector of b across n.
        tangent: (3,) n x radial: turning about it brings n towards b.
    """

    along: Scalar
    across: Scalar
    angle: Scalar
    radial: Vector3
    tangent: Vector3


class MomentumAngles(NamedTuple):
    """An attitude against another.

    Attributes:
        roll: turn about the total momentum, rad.
        spin: turn about the axis, rad.
        tilt: turn of the axis towards the momentum, rad.
    """

    roll: Scalar
    spin: Scalar
    tilt: Scalar


def momentum_frame(axis: Vector3, momentum: Vector3) -> MomentumFrame:
    """The frame of an axis, unit length, and a momentum, both in body axes."""
    along = axis @ momentum
    plane = momentum - along * axis
    # both along one line: no direction is marked out, and none is divided by zero
    across = jnp.sqrt(plane @ plane + 1e-24)
    radial = plane / across
    return MomentumFrame(along, across, jnp.arctan2(across, along), radial, jnp.cross(axis, radial))


def momentum_angles(
    attitude: Quaternion, target: Quaternion, total_momentum: Vector3, axis: Vector3
) -> MomentumAngles:
    """Roll, spin and tilt that lead from a target to an attitude; R_target exp(e) = R.

    exp(e) = exp(roll b_d/|b_d|) exp(tilt t_d) exp(spin n) with the momentum b_d and the tangent t_d
    in body axes at the target: 3-1-3 angles between an axis fixed in space and one fixed in the
    body (P. C. Hughes, "Spacecraft Attitude Dynamics", section 2.3), with n as the third.

    Args:
        attitude: (4,) quaternion, scalar first.
        target: (4,) quaternion.
        total_momentum: (3,) in inertial axes, not zero, N·m·s.
        axis: (3,) n in body axes, unit length, not along the momentum at the target.

    Returns:
        Angles of which roll and spin are in (-pi, pi].
    """
    wanted = rotations.to_body(target, total_momentum)
    now = momentum_frame(axis, rotations.to_body(attitude, total_momentum))
    then = momentum_frame(axis, wanted)
    tilt = then.angle - now.angle
    spin = -jnp.arctan2(jnp.cross(then.radial, now.radial) @ axis, then.radial @ now.radial)
    others = rotations.product(
        rotations.from_rotation_vector(tilt * then.tangent),
        rotations.from_rotation_vector(spin * axis),
    )
    turn = rotations.product(rotations.conjugate(target), attitude)
    turn = rotations.product(turn, rotations.conjugate(others))
    size = jnp.sqrt(wanted @ wanted)
    roll = 2.0 * jnp.arctan2(turn[1:] @ wanted / size, turn[0])
    return MomentumAngles(jnp.arctan2(jnp.sin(roll), jnp.cos(roll)), spin, tilt)
