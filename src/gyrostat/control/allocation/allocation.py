"""Torque allocation over wheels: pseudo-inverse (least squares) and minimax.

An allocation is called with the axes (3, wheels), the torque limits (wheels,), N·m, which wheels
work (wheels,), and the torque (3,), N·m, that they shall take up together; it gives the motor
torques u (wheels,), with sum a_i u_i = torque. Which wheels work may change from call to call. Of a
torque that the working axes do not span they give the nearest, u beyond the limits is left to
`within_limits`.
"""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite

Axes = Float[Array, "3 wheels"]
Working = Bool[Array, " wheels"]

SINGULAR = 1e-10
"""Square of a singular value of the working axes: directions well below it are not spanned."""
ALIGNED = 1e-6
"""Sine of an angle between axes, or of an axis with a plane, that counts as none."""


def spread(axes: Axes, works: Working) -> Float[Array, "wheels 3"]:
    """Pseudo-inverse of the working axes; rows of wheels that do not work are zero.

    Directions that are not spanned get nothing, the others what is theirs within a share of
    `SINGULAR`.
    """
    working = axes * works
    return working.T @ inverse_definite(working @ working.T + SINGULAR * jnp.eye(3))


def largest_share(torque: PerWheel, limit: PerWheel) -> Scalar:
    """The largest torque over its limit."""
    return jnp.max(jnp.abs(torque) / limit)


def within_limits(torque: PerWheel, limit: PerWheel) -> PerWheel:
    """The torques, all smaller by one factor where one is beyond its limit.

    Their sum keeps its direction.
    """
    return torque / jnp.maximum(largest_share(torque, limit), 1.0)


class PseudoInverse(eqx.Module):
    """u = A⁺ torque: the pseudo-inverse, whose sum of squares is the least."""

    def __call__(self, axes: Axes, limit: PerWheel, works: Working, torque: Vector3) -> PerWheel:
        """Share a torque; see the module."""
        del limit
        return spread(axes, works) @ torque


class _Share(NamedTuple):
    """What is decided so far.

    Attributes:
        given: (wheels,) torques of decided wheels, N·m; zero for the others.
        rest: (3,) torque that the open wheels have still to give, N·m.
        open: (wheels,) which wheels are not decided.
    """

    given: PerWheel
    rest: Vector3
    open: Working


class MinimaxAllocation(eqx.Module):
    """The least max |u_i| / limit_i: the whole torque envelope of the wheels is in reach.

    Minimise t over |u_i| <= t l_i, A u = T: a linear program. Its dual is to maximise y.T over
    sum l_i |a_i.y| <= 1, and the corners of that polyhedron lie along the normals n of the planes
    that two axes span. So

        t = max over pairs (j, k) of |n.T| / sum_i l_i |n.a_i|,   n = a_j x a_k,

    with n(n-1)/2 pairs for n wheels. At the best pair every wheel out of its plane is at u_i = t
    l_i sign(n.a_i); those in the plane give what is left, by the same rule one dimension lower,
    and those along one line the last. F. L. Markley, R. G. Reynolds, F. X. Liu, K. L. Lebsock,
    "Maximum torque and momentum envelopes for reaction wheel arrays", Journal of Guidance, Control,
    and Dynamics 33 (2010), has the envelope of whose faces these are.
    """

    def __call__(self, axes: Axes, limit: PerWheel, works: Working, torque: Vector3) -> PerWheel:
        """Share a torque; see the module."""
        axes = jnp.asarray(axes)
        first, second = np.triu_indices(axes.shape[1], 1)
        if not len(first):  # a single wheel
            return works * (axes.T @ torque)
        normals = jnp.cross(axes[:, first].T, axes[:, second].T)
        usable = works[first] & works[second]
        share = _Share(jnp.zeros(axes.shape[1]), jnp.asarray(torque), works)
        share, plane = _decide(share, axes, limit, normals, usable)
        share, _ = _decide(share, axes, limit, jnp.cross(plane, axes.T), share.open)
        weight = share.open * limit
        line = axes[:, jnp.argmax(weight)]
        along = axes.T @ line
        total = jnp.sum(weight * jnp.abs(along))
        last = share.rest @ line / jnp.where(total > 0.0, total, 1.0)
        return share.given + last * weight * jnp.sign(along)


def _decide(
    share: _Share, axes: Axes, limit: PerWheel, normals: Any, usable: Any
) -> tuple[_Share, Vector3]:
    """Bring all wheels to the level at which they just give the rest along the worst normal.

    Args:
        share: so far.
        axes: of the wheels.
        limit: of their torques, N·m.
        normals: (candidates, 3) of the faces that may bound the level.
        usable: (candidates,) which are made of open wheels.

    Returns:
        The share, in which all wheels but those in the face are decided, and the unit normal of
        the face.
    """
    length = jnp.sqrt(jnp.sum(normals**2, axis=1))
    real = usable & (length > ALIGNED)
    normals = jnp.where(real, 1.0 / jnp.where(real, length, 1.0), 0.0)[:, None] * normals
    heights = jnp.where(share.open, normals @ axes, 0.0)
    heights = jnp.where(jnp.abs(heights) > ALIGNED, heights, 0.0)
    reach = jnp.abs(heights) @ limit
    bounds = real & (reach > 0.0)
    level = normals @ share.rest / jnp.where(bounds, reach, 1.0)
    # where every open wheel lies in one face there is nothing to decide: that face goes on
    best = jnp.argmax(jnp.where(bounds, 1.0 + jnp.abs(level), jnp.where(real, length, 0.0) / 2.0))
    sense = jnp.sign(heights[best])
    given = level[best] * limit * sense
    left = _Share(share.given + given, share.rest - axes @ given, share.open & (sense == 0.0))
    return left, normals[best]
