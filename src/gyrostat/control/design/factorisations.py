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
"""Split of every product into halves."""


class EulerCube(Checked):
    """Cube under body torques, in 3-1-3 Euler angles and their rates.

    Carvalho and Fenili, eqs. (17), (18) with A(2,4), A(6,4) and A(6,6) corrected. The state is
    (theta - pi/2, theta', phi, phi', psi, psi'), rad and rad/s. The columns of the angles in A are
    zero, so that theta may be measured from its target. Singular where sin(theta) is zero.

    Attributes:
        inertia: Inertia about every axis, kg·m².
        split: Fraction of each product of two rates in the column of the first rate; the rest is in
            the column of the second: phi' psi' in theta''; phi' theta' and psi' theta' in phi'';
            psi' theta' and phi' theta' in psi''.
    """

    inertia: Annotated[Scalar, positive("inertia", "kg·m²")]
    split: tuple[float, ...] = eqx.field(static=True, default=PRINTED)

    def check_own(self) -> None:
        """Validate the split.

        Raises:
            InputError: The split has another length or values that are not finite.
        """
        if len(self.split) != len(PRINTED) or not np.all(np.isfinite(self.split)):
            raise InputError(f"split: found {self.split}, expected {len(PRINTED)} finite shares")

    def __call__(self, state: Float[Array, "6"]) -> Pair:
        """Matrices A and B at a state, for torques about the body axes, N·m."""
        height, theta, _, phi, psi, spin = state  # the rates of theta, phi and psi
        sine, cosine = jnp.cos(height), -jnp.sin(height)  # of theta itself
        cosecant, cot = 1.0 / sine, cosine / sine
        s, c, inverse = jnp.sin(psi) / self.inertia, jnp.cos(psi) / self.inertia, 1.0 / self.inertia
        k = self.split
        r = [1.0 - share for share in k]
        of_theta = [0.0, 0.0, 0.0, -k[0] * sine * spin, 0.0, -r[0] * sine * phi]
        of_phi = [
            *(0.0, -r[1] * cot * phi + r[2] * cosecant * spin),
            *(0.0, -k[1] * cot * theta),
            *(0.0, k[2] * cosecant * theta),
        ]
        of_psi = [
            *(0.0, -r[3] * cot * spin + r[4] * cosecant * phi),
            *(0.0, k[4] * cosecant * theta),
            *(0.0, -k[3] * cot * theta),
        ]
        zero_row = [0.0, 0.0, 0.0]
        dynamics = [
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            of_theta,
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            of_phi,
            [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            of_psi,
        ]
        torque = [[c, -s, 0.0], [s * cosecant, c * cosecant, 0.0], [-s * cot, -c * cot, inverse]]
        inputs = [row for torque_row in torque for row in (zero_row, torque_row)]
        return jnp.array(dynamics), jnp.array(inputs)


def _body(
    kinematics: Float[Array, "3 3"],
    inertia: Float[Array, "3 3"],
    rate: Vector3,
    momentum: Vector3 | float,
    split: Scalar,
) -> Pair:
    """Matrices A and B of (error, w), from J w' = u - w x (J w + h) and (error)' = kinematics w."""
    turning = split * cross_matrix(inertia @ rate) + cross_matrix(momentum * jnp.ones(3))
    turning = turning - (1.0 - split) * product(cross_matrix(rate), inertia)
    inverse, _ = solve(inertia, jnp.eye(3))
    nothing = jnp.zeros((3, 3))
    dynamics = jnp.block([[nothing, kinematics], [nothing, product(inverse, turning)]])
    return dynamics, jnp.concatenate([nothing, inverse])


class MRPBody(Checked):
    """Rigid body with wheels under body torques: attitude error as MRP, and body rate.

    The state is (sigma, w). The modified Rodrigues parameters (MRP) sigma = axis tan(angle / 4)
    describe the rotation from the target, which is at rest, to the body; w is the body rate in body
    axes, rad/s. J w' = u - w x (J w + h). Singular only at a rotation by a full turn.

    Attributes:
        inertia: Inertia J, including the wheels as far as they turn with the body, (3, 3), kg·m².
        split: Fraction of w x J w that is written as a matrix of J w times w; the rest is a matrix
            of w times J w.
    """

    inertia: Annotated[Float[Array, "3 3"], of_a_body]
    split: Scalar = 1.0

    def __call__(self, state: Float[Array, "6"], momentum: Vector3 | float = 0.0) -> Pair:
        """Matrices A and B at a state.

        Args:
            state: State, sigma and w, (6,).
            momentum: Momentum h of the wheels in body axes, (3,), N·m·s.
        """
        inertia = jnp.asarray(self.inertia)
        return _body(mrp_rate_matrix(state[:3]), inertia, state[3:], momentum, self.split)

    def state(self, attitude: Quaternion, rate: Vector3, target: Quaternion) -> Float[Array, "6"]:
        """State of a body relative to a target at rest."""
        return jnp.concatenate([to_mrp(error(attitude, target)), rate])


class QuaternionBody(Checked):
    """Rigid body as in `MRPBody`, with the vector part of the error quaternion as attitude error.

    The error is the shorter rotation. At a rotation by half a turn, where the scalar part is zero,
    one direction of the error cannot be controlled and the solution is not valid.

    Attributes:
        inertia: Inertia J as in `MRPBody`, (3, 3), kg·m².
        split: Fraction of w x J w as in `MRPBody`.
    """

    inertia: Annotated[Float[Array, "3 3"], of_a_body]
    split: Scalar = 1.0

    def __call__(self, state: Float[Array, "6"], momentum: Vector3 | float = 0.0) -> Pair:
        """Matrices A and B at a state (vector part, w); see `MRPBody`."""
        vector = state[:3]
        scalar = jnp.sqrt(jnp.maximum(1.0 - vector @ vector, 0.0))
        kinematics = 0.5 * (scalar * jnp.eye(3) + cross_matrix(vector))
        return _body(kinematics, jnp.asarray(self.inertia), state[3:], momentum, self.split)

    def state(self, attitude: Quaternion, rate: Vector3, target: Quaternion) -> Float[Array, "6"]:
        """State of a body relative to a target at rest."""
        return jnp.concatenate([error(attitude, target)[1:], rate])
