"""State-dependent factorisations x' = A(x) x + B(x) u of a rigid body under torque."""

from typing import Annotated

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import product, solve
from gyrostat.core.rotations import cross_matrix, error, mrp_rate_matrix, to_mrp
from gyrostat.spacecraft.spacecraft import of_a_body

Pair = tuple[Float[Array, "6 6"], Float[Array, "6 3"]]

AXES = tuple(f"rotation about body {axis}" for axis in "xyz")
EULER_STATES = tuple(name for name in AXES for _ in range(2))
"""Names of the states of `EulerCube` near the target, for `lqr`."""
ERROR_STATES = AXES * 2
"""Names of the states of `MRPBody` and `QuaternionBody`, for `lqr`."""

PRINTED = (1.0, 1.0, 1.0, 0.0, 1.0)
"""Split of the products as in eq. (17) of Carvalho and Fenili, corrected."""
HALVES = (0.5, 0.5, 0.5, 0.5, 0.5)
"""Every product in halves."""


class EulerCube(Checked):
    """A cube under body torques, in 3-1-3 angles and their rates.

    Carvalho and Fenili, eqs. (17), (18) with A(2,4), A(6,4) and A(6,6) corrected. The state is
    (theta - pi/2, theta', phi, phi', psi, psi'), rad and rad/s: the columns of the angles in A are
    zero, so that theta may count from where it is wanted. Infinite where sin(theta) is zero.

    Attributes:
        inertia: about every axis, kg·m².
        split: share of each product of two rates that stands in the column of the first, the rest
            in that of the second: phi' psi' in theta''; phi' theta' and psi' theta' in phi'';
            psi' theta' and phi' theta' in psi''.
    """

    inertia: Annotated[Scalar, positive("inertia", "kg·m²")]
    split: tuple[float, ...] = eqx.field(static=True, default=PRINTED)

    def check_own(self) -> None:
        """Refuse a split of another length or with values that are not finite, by `InputError`."""
        if len(self.split) != len(PRINTED) or not np.all(np.isfinite(self.split)):
            raise InputError(f"split: found {self.split}, expected {len(PRINTED)} finite shares")

    def __call__(self, state: Float[Array, "6"]) -> Pair:
        """A and B at a state; torques about the body axes, N·m."""
        height, theta, _, phi, psi, spin = state  # the rates of theta, phi and psi
        sine, cosine = jnp.cos(height), -jnp.sin(height)  # of theta itself
        over, cot = 1.0 / sine, cosine / sine
        s, c, one = jnp.sin(psi) / self.inertia, jnp.cos(psi) / self.inertia, 1.0 / self.inertia
        k = self.split
        r = [1.0 - share for share in k]
        of_theta = [0.0, 0.0, 0.0, -k[0] * sine * spin, 0.0, -r[0] * sine * phi]
        of_phi = [
            *(0.0, -r[1] * cot * phi + r[2] * over * spin),
            *(0.0, -k[1] * cot * theta),
            *(0.0, k[2] * over * theta),
        ]
        of_psi = [
            *(0.0, -r[3] * cot * spin + r[4] * over * phi),
            *(0.0, k[4] * over * theta),
            *(0.0, -k[3] * cot * theta),
        ]
        rest = [0.0, 0.0, 0.0]
        dynamics = [
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            of_theta,
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            of_phi,
            [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            of_psi,
        ]
        torque = [[c, -s, 0.0], [s * over, c * over, 0.0], [-s * cot, -c * cot, one]]
        inputs = [row for now in torque for row in (rest, now)]
        return jnp.array(dynamics), jnp.array(inputs)


def _body(
    kinematics: Float[Array, "3 3"],
    inertia: Float[Array, "3 3"],
    rate: Vector3,
    momentum: Vector3 | float,
    split: Scalar,
) -> Pair:
    """Attitude error and rate, from J w' = u - w x (J w + h) and (error)' = kinematics w."""
    turning = split * cross_matrix(inertia @ rate) + cross_matrix(momentum * jnp.ones(3))
    turning = turning - (1.0 - split) * product(cross_matrix(rate), inertia)
    inverse, _ = solve(inertia, jnp.eye(3))
    nothing = jnp.zeros((3, 3))
    dynamics = jnp.block([[nothing, kinematics], [nothing, product(inverse, turning)]])
    return dynamics, jnp.concatenate([nothing, inverse])


class MRPBody(Checked):
    """A rigid body with wheels under body torques: MRP of the attitude error, and the rate.

    The state is (sigma, w): sigma = axis tan(angle / 4) of the turn from the target, at rest, to
    the body; w in body axes, rad/s. J w' = u - w x (J w + h). Singular only a full turn away.

    Attributes:
        inertia: J, (3, 3), wheels included as far as they turn with the body, kg·m².
        split: share of w x J w that is written as a matrix of J w times w, the rest as a matrix of
            w times J w.
    """

    inertia: Annotated[Float[Array, "3 3"], of_a_body]
    split: Scalar = 1.0

    def __call__(self, state: Float[Array, "6"], momentum: Vector3 | float = 0.0) -> Pair:
        """A and B at a state.

        Args:
            state: (6,) sigma and w.
            momentum: h, (3,) of the wheels in body axes, N·m·s.
        """
        inertia = jnp.asarray(self.inertia)
        return _body(mrp_rate_matrix(state[:3]), inertia, state[3:], momentum, self.split)

    def state(self, attitude: Quaternion, rate: Vector3, target: Quaternion) -> Float[Array, "6"]:
        """State of a body with respect to a target at rest."""
        return jnp.concatenate([to_mrp(error(attitude, target)), rate])


class QuaternionBody(Checked):
    """The same body with the vector part of the error quaternion in place of the MRP.

    The error is the shorter turn; half a turn away, where the scalar part is zero, one direction of
    the error cannot be reached and a solution is not valid.

    Attributes:
        inertia: as in `MRPBody`; so is `split`.
        split: as there.
    """

    inertia: Annotated[Float[Array, "3 3"], of_a_body]
    split: Scalar = 1.0

    def __call__(self, state: Float[Array, "6"], momentum: Vector3 | float = 0.0) -> Pair:
        """A and B at a state (vector part, w); see `MRPBody`."""
        vector = state[:3]
        scalar = jnp.sqrt(jnp.maximum(1.0 - vector @ vector, 0.0))
        kinematics = 0.5 * (scalar * jnp.eye(3) + cross_matrix(vector))
        return _body(kinematics, jnp.asarray(self.inertia), state[3:], momentum, self.split)

    def state(self, attitude: Quaternion, rate: Vector3, target: Quaternion) -> Float[Array, "6"]:
        """State of a body with respect to a target at rest."""
        return jnp.concatenate([error(attitude, target)[1:], rate])
