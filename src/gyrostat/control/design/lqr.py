"""Linear quadratic regulator."""

from collections.abc import Callable, Sequence
from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float
from numpy.typing import ArrayLike

from gyrostat.control.design.controllability import uncontrollable
from gyrostat.control.design.riccati import RiccatiSolution, riccati
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Matrix

DOUBLINGS = 24
"""Number of doublings of a design; larger than in a flight law, since the design is not in real
time."""
ASYMMETRY = 1e-9
"""Largest asymmetry of a weight, relative to its largest element, that counts as rounding."""
NEGATIVE = 1e-12
"""Largest negative eigenvalue of a weight, relative to the largest, that counts as rounding."""


class FeedbackCommand(NamedTuple):
    """Command of a state feedback.

    Attributes:
        torque: Inputs of the plant, (m,), N·m.
        residual: Residual of the Riccati equation, see `RiccatiSolution`.
        valid: Whether the Riccati equation was solved and the loop, linearised at this state, is
            stable.
    """

    torque: Annotated[Float[Array, " m"], "N·m"]
    residual: Annotated[Scalar, "1"]
    valid: Bool[Array, ""]


def check_weight(name: str, weight: ArrayLike, size: int, *, definite: bool) -> Matrix:
    """Validate a weight matrix.

    Args:
        name: Name of the weight in messages.
        weight: Weight matrix, (n, n).
        size: Number of rows n.
        definite: Whether the weight must be positive definite, not only semidefinite.

    Returns:
        Symmetric part of the weight.

    Raises:
        InputError: The shape is wrong, a value is not finite, or the matrix is not symmetric or has
            negative eigenvalues.
    """
    matrix = np.asarray(weight, dtype=float)
    if matrix.shape != (size, size) or not size:
        raise InputError(f"{name}: found shape {matrix.shape}, expected ({size}, {size})")
    if not np.all(np.isfinite(matrix)):
        raise InputError(f"{name}: found a value that is not finite")
    largest = np.max(np.abs(matrix), initial=0.0)
    if np.max(np.abs(matrix - matrix.T)) > ASYMMETRY * largest:
        raise InputError(f"{name}: found a matrix that is not symmetric, expected a symmetric one")
    matrix = 0.5 * (matrix + matrix.T)
    eigenvalue = np.linalg.eigvalsh(matrix)[0]
    # scaled to a unit diagonal, so that a mix of units does not affect the test
    units = np.sqrt(np.abs(np.diag(matrix)))
    units = np.where(units > 0.0, units, 1.0)
    eigenvalues = np.linalg.eigvalsh(matrix / np.outer(units, units))
    if definite and eigenvalues[0] <= NEGATIVE:
        raise InputError(f"{name}: found the eigenvalue {eigenvalue:g}, expected all above 0")
    if eigenvalues[0] < -NEGATIVE * size:
        raise InputError(f"{name}: found the eigenvalue {eigenvalue:g}, expected none below 0")
    return matrix


def lqr(
    dynamics: ArrayLike,
    input: ArrayLike,
    state_weight: ArrayLike,
    input_weight: ArrayLike,
    *,
    states: Sequence[str] | None = None,
) -> RiccatiSolution:
    """Gain K of u = -K x that minimises the integral of x'Qx + u'Ru for x' = A x + B u.

    Args:
        dynamics: Matrix A, (n, n).
        input: Matrix B, (n, m).
        state_weight: Weight Q, (n, n), symmetric, positive semidefinite.
        input_weight: Weight R, (m, m), symmetric, positive definite.
        states: Name of each state for messages; see `uncontrollable`.

    Raises:
        InputError: The shapes do not fit; a weight is not valid; the pair (A, B) cannot be
            stabilised, with the motion that no input affects; or a motion neither decays nor has a
            cost.
    """
    reach = uncontrollable(dynamics, input, states)
    a, b = np.asarray(dynamics, dtype=float), np.asarray(input, dtype=float)
    q = check_weight("state weight Q", state_weight, len(a), definite=False)
    if reach.names:
        raise InputError(
            f"no input controls: {', '.join(reach.names)} (controllability rank {reach.rank}), "
            f"expected inputs that reach every motion that does not decay by itself"
        )
    r = check_weight("input weight R", input_weight, b.shape[1], definite=True)
    solution = riccati(a, b, q, r, doublings=DOUBLINGS)
    if not solution.valid:
        modes = uncontrollable(a.T, q, states).names
        cause = f"no cost in Q on: {', '.join(modes)}" if modes else "no accurate solution"
        raise InputError(f"A, B, Q, R: {cause}; expected a cost on every undamped motion")
    return solution


def _state(measurement: Any) -> Array:
    return measurement.state


class LinearQuadratic(Checked):
    """Sampled state feedback u = -K x; a controller of the loop.

    Attributes:
        gain: Gain K, (m, n), from `lqr`.
        reading: Function from a measurement to x, (n,), the deviations from the target. The default
            takes `state` of the measurement.
    """

    gain: Float[Array, "m n"]
    reading: Callable[[Any], Array] = eqx.field(static=True, default=_state)

    def check_own(self) -> None:
        """Validate the gain.

        Raises:
            InputError: The gain is not a matrix of finite values.
        """
        gain = np.asarray(self.gain, dtype=float)
        if gain.ndim < 2 or not np.all(np.isfinite(gain)):
            raise InputError(
                f"gain: found shape {gain.shape}, expected (inputs, states) of finite values"
            )

    def start(self, period: Scalar) -> tuple[()]:
        """Initial memory; empty."""
        return ()

    def __call__(self, memory: tuple[()], measurement: Any) -> tuple[tuple[()], FeedbackCommand]:
        """Compute the command."""
        torque = -jnp.asarray(self.gain) @ self.reading(measurement)
        return memory, FeedbackCommand(torque, jnp.zeros(()), jnp.array(True))
