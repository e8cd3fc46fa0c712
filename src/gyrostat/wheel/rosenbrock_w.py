"""Rosenbrock-W step: linearly implicit in a stiff part of a system, explicit in the rest.

ROS34PW2: four stages, third order with an embedded second-order error estimate, stiffly accurate
and L-stable, with any matrix in place of the Jacobian. J. Rang, L. Angermann, "New Rosenbrock
W-methods of order 3 for partial differential algebraic equations of index 1", BIT Numerical
Mathematics 45 (2005). A component whose rows and columns of the matrix are zero is integrated
explicitly.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax

GAMMA = 0.43586652150845899941601945
ARGUMENTS = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [0.87173304301691800777, 0.0, 0.0, 0.0],
        [0.84457060015369423945, -0.11299064236484185, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]
)
"""Coefficients of the earlier stages in the argument of each stage."""
MATRIX = np.array(
    [
        [GAMMA, 0.0, 0.0, 0.0],
        [-0.87173304301691800777, GAMMA, 0.0, 0.0],
        [-0.90338057013044082163, 0.054180672388095326, GAMMA, 0.0],
        [0.24212380706095346, -1.2232505839045147, 0.54526025533510214, GAMMA],
    ]
)
"""Coefficients of the stages that the matrix multiplies."""
WEIGHTS = ARGUMENTS[3] + MATRIX[3]
"""Weights of the stages in the new state."""
EMBEDDED = np.array([0.37810903145819369572, -0.096042292212423178, 0.5, 0.21793326075422950])
"""Weights of the stages in the embedded solution of second order."""
ORDER = 3
"""Order of the method; the estimated error is proportional to this power of the step."""

# In the variables MATRIX @ stages, no stage multiplies by the matrix (Hairer and Wanner, "Solving
# Ordinary Differential Equations II", section IV.7).
_INVERSE = np.linalg.inv(MATRIX)
_ARGUMENTS = ARGUMENTS @ _INVERSE
_COUPLING = np.diag(np.diag(_INVERSE)) - _INVERSE
_TIMES = ARGUMENTS.sum(axis=1)
_WEIGHTS = WEIGHTS @ _INVERSE
_ERROR = (WEIGHTS - EMBEDDED) @ _INVERSE


def _plus(tree: Any, shares: np.ndarray, stages: list[Any], factor: Scalar = 1.0) -> Any:
    """Add multiples of some stages to a tree."""
    for share, stage in zip(shares, stages, strict=False):
        if abs(share) > 1e-14:
            tree = jax.tree.map(lambda y, k, s=share: y + (s * factor) * k, tree, stage)
    return tree


def rosenbrock_w_step(
    field: Callable[[Any, Scalar], Any],
    solve: Callable[[Any], Any],
    state: Any,
    rate: Any,
    time: Scalar,
    step: Scalar,
) -> tuple[Any, Any]:
    """Take one step.

    Args:
        field: Function (state, time) -> time derivative of the state.
        solve: Function r -> x with x / (GAMMA step) - A x = r, for the matrix A of the stiff part.
        state: State at the start, any tree of arrays.
        rate: Its time derivative.
        time: Time at the start, s.
        step: Length of the step, s.

    Returns:
        State at the end and its estimated error.
    """
    inverse_step = 1.0 / step
    stages = [solve(rate)]
    for arguments, coupling, share in zip(_ARGUMENTS[1:], _COUPLING[1:], _TIMES[1:], strict=True):
        right = field(_plus(state, arguments, stages), time + share * step)
        stages.append(solve(_plus(right, coupling, stages, inverse_step)))
    zeros = jax.tree.map(lambda y: 0.0 * y, state)
    return _plus(state, _WEIGHTS, stages), _plus(zeros, _ERROR, stages)
