"""Torque allocation over wheels: pseudo-inverse (least squares) and minimax.

An allocation is called with the axes (3, wheels), the torque limits (wheels,), N·m, the flags of
working wheels (wheels,), and the total torque (3,), N·m, that the wheels shall take up. It returns
the motor torques u (wheels,), N·m, with sum a_i u_i = torque. The set of working wheels may change
from call to call. If the working axes do not span the torque, u gives the nearest torque in their
span. Torques beyond the limits are reduced by `within_limits`, not here.
"""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.traced_once import one_function

Axes = Float[Array, "3 wheels"]
Working = Bool[Array, " wheels"]

SINGULAR = 1e-10
"""Regularisation of the square of the working axes. Directions with a singular value below its cube
root count as not spanned."""
ALIGNED = 1e-6
"""Sine of an angle between two axes, or between an axis and a plane, that counts as zero."""


@one_function
def spread(axes: Axes, works: Working) -> Float[Array, "wheels 3"]:
    """Pseudo-inverse of the working axes; rows of wheels that do not work are zero.

    Directions that the axes do not span get no torque. In the other directions the relative error
    is about e² over the square of the singular value, with e `SINGULAR` over the same square.
    """
    columns = axes * works
    square = columns @ columns.T
    # Projector onto the directions that are not spanned. With it the matrix is well conditioned: a
    # small diagonal instead would amplify rounding errors by its inverse.
    projector = SINGULAR * inverse_definite(square + SINGULAR * jnp.eye(3))
    return columns.T @ inverse_definite(square + projector @ projector)


def largest_share(torque: PerWheel, limit: PerWheel) -> Scalar:
    """Largest ratio of a torque to its limit."""
    return jnp.max(jnp.abs(torque) / limit)


def within_limits(torque: PerWheel, limit: PerWheel) -> PerWheel:
    """Torques scaled by one factor, so that none is beyond its limit.

    The sum of the torques keeps its direction.
    """
    return torque / jnp.maximum(largest_share(torque, limit), 1.0)


class PseudoInverse(eqx.Module):
    """Pseudo-inverse allocation u = A⁺ torque, with the least sum of squares."""

    def __call__(self, axes: Axes, limit: PerWheel, works: Working, torque: Vector3) -> PerWheel:
        """Allocate a torque; see the module."""
        del limit
        return spread(axes, works) @ torque


class _Share(NamedTuple):
    """Partial result of the allocation.

    Attributes:
        given: Torques of the wheels that are already determined, (wheels,), N·m; zero for the
            others.
        rest: Torque that the other wheels still have to give, (3,), N·m.
        open: Flags of the wheels whose torques are not yet determined, (wheels,).
    """

    given: PerWheel
    rest: Vector3
    open: Working


class MinimaxAllocation(eqx.Module):
    """Minimax allocation: least max |u_i| / limit_i, which reaches the whole torque envelope.

    The allocation minimises t subject to |u_i| <= t l_i and A u = T, which is a linear program. Its
    dual maximises y.T subject to sum l_i |a_i.y| <= 1. The vertices of this polyhedron lie along
    the normals n of the planes that two axes span. Therefore

        t = max over pairs (j, k) of |n.T| / sum_i l_i |n.a_i|,   n = a_j x a_k,

    with n(n-1)/2 pairs for n wheels. At the pair with the maximum, every wheel outside its plane
    has u_i = t l_i sign(n.a_i). The wheels in the plane give the rest by the same rule, one
    dimension lower, and the wheels along one line give the last part. The envelope with these faces
    is in F. L. Markley, R. G. Reynolds, F. X. Liu, K. L. Lebsock, "Maximum torque and momentum
    envelopes for reaction wheel arrays", Journal of Guidance, Control, and Dynamics 33 (2010).
    """

    def __call__(self, axes: Axes, limit: PerWheel, works: Working, torque: Vector3) -> PerWheel:
        """Allocate a torque; see the module."""
        axes = jnp.asarray(axes)
        first, second = np.triu_indices(axes.shape[1], 1)
        if not len(first):  # a single wheel
            return works * (axes.T @ torque)
        normals = jnp.cross(axes[:, first].T, axes[:, second].T)
        usable = works[first] & works[second]
        share = _Share(jnp.zeros(axes.shape[1]), jnp.asarray(torque), works)
        wheels = np.arange(axes.shape[1])
        in_face = (first[:, None] == wheels) | (second[:, None] == wheels)
        share, plane = _decide(share, axes, limit, normals, usable, in_face)
        normals, in_face = jnp.cross(plane, axes.T), wheels[:, None] == wheels
        share, _ = _decide(share, axes, limit, normals, share.open, in_face)
        weight = share.open * limit
        line = axes[:, jnp.argmax(weight)]
        along = axes.T @ line
        total = jnp.sum(weight * jnp.abs(along))
        level = share.rest @ line / jnp.where(total > 0.0, total, 1.0)
        return share.given + level * weight * jnp.sign(along)


def _decide(
    share: _Share, axes: Axes, limit: PerWheel, normals: Any, usable: Any, in_face: Any
) -> tuple[_Share, Vector3]:
    """Load all wheels to the level at which they just give the remaining torque along one normal.

    The normal is the one that needs the highest level.

    Args:
        share: Partial result so far.
        axes: Spin axes of the wheels, (3, wheels).
        limit: Torque limits of the wheels, (wheels,), N·m.
        normals: Normals of the faces that may determine the level, (candidates, 3).
        usable: Flags of the candidates that are formed by open wheels, (candidates,).
        in_face: Flags of the wheels that form a candidate, (candidates, wheels): their axes are
            perpendicular to its normal.

    Returns:
        Partial result in which all wheels are determined but those in the face, and the unit normal
        of the face.
    """
    length = jnp.sqrt(jnp.sum(normals**2, axis=1))
    real = usable & (length > ALIGNED)
    normals = jnp.where(real, 1.0 / jnp.where(real, length, 1.0), 0.0)[:, None] * normals
    heights = jnp.where(share.open & ~in_face, normals @ axes, 0.0)
    heights = jnp.where(jnp.abs(heights) > ALIGNED, heights, 0.0)
    reach = jnp.abs(heights) @ limit
    bounds = real & (reach > 0.0)
    level = normals @ share.rest / jnp.where(bounds, reach, 1.0)
    # if every open wheel lies in one face, no torque is determined and that face is returned
    index = jnp.argmax(jnp.where(bounds, 1.0 + jnp.abs(level), jnp.where(real, length, 0.0) / 2.0))
    sense = jnp.sign(heights[index])
    torque = level[index] * limit * sense
    part = _Share(share.given + torque, share.rest - axes @ torque, share.open & (sense == 0.0))
    return part, normals[index]
