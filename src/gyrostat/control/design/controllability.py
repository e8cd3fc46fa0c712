"""Controllability of a linear system: rank, and uncontrollable directions."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix

SMALLEST = 1e-9
"""Smallest part of an input in a new direction, relative to the size of A, that is not rounding."""
SLOWEST = 1e-7
"""Smallest rate of decay, relative to the size of A, that counts as decay."""
SHARE = 0.3
"""Smallest share of a state in a direction (a cosine) for the state to be named."""


class Controllability(NamedTuple):
    """Controllable space of an input, and the uncontrollable directions that do not decay.

    Attributes:
        rank: Dimension of the controllable space.
        directions: Orthonormal columns w, (n, k), of motions w'x that no input affects and that do
            not decay. Empty if and only if the pair can be stabilised.
        rates: Eigenvalues of these motions, (k,), complex, 1/s.
        names: Names of the states in those directions, each once.
    """

    rank: int
    directions: Matrix
    rates: np.ndarray
    names: tuple[str, ...]


def _new_directions(basis: Matrix, columns: Matrix) -> Matrix:
    """Orthonormal basis of the part of columns, each of length 1 or less, outside a basis."""
    for _ in range(2):  # two passes make the columns orthogonal to rounding
        columns = columns - basis @ (basis.T @ columns)
    vectors, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return vectors[:, sizes > SMALLEST]


def uncontrollable(
    dynamics: ArrayLike, input: ArrayLike, states: Sequence[str] | None = None
) -> Controllability:
    """Controllable space of x' = A x + B u, and uncontrollable directions that do not decay.

    The controllable space is built up from B by repeated products with A, made orthogonal at each
    step (staircase algorithm), so that repeated eigenvalues cause no error. The motion in its
    orthogonal complement is independent of the input; the part of it that does not decay is taken
    from a real Schur form.

    Args:
        dynamics: Matrix A, (n, n).
        input: Matrix B, (n, m).
        states: Name of each state for messages. States of one motion may share a name, such as
            "rotation about body y" for angle and rate.

    Raises:
        InputError: The shapes do not fit, or a value is not finite.
    """
    import scipy.linalg

    a, b = np.asarray(dynamics, dtype=float), np.asarray(input, dtype=float)
    if a.ndim != 2 or a.shape[0] != a.shape[1] or b.ndim != 2 or len(b) != len(a):
        raise InputError(f"A and B: found shapes {a.shape} and {b.shape}, expected (n, n), (n, m)")
    if not (np.all(np.isfinite(a)) and np.all(np.isfinite(b))):
        raise InputError("A and B: found a value that is not finite")
    names = [f"state {k + 1}" for k in range(len(a))] if states is None else list(states)
    if len(names) != len(a):
        raise InputError(f"state names: found {len(names)}, expected {len(a)}")
    size = np.linalg.norm(a, 2) or 1.0
    lengths = np.linalg.norm(b, axis=0)
    reachable = np.zeros((len(a), 0))
    columns = _new_directions(reachable, b[:, lengths > 0.0] / lengths[lengths > 0.0])
    while columns.shape[1]:
        reachable = np.hstack([reachable, columns])
        columns = _new_directions(reachable, a @ columns / size)
    complement = scipy.linalg.null_space(reachable.T) if reachable.shape[1] else np.eye(len(a))
    law, basis, count = np.zeros((0, 0)), np.zeros((0, 0)), 0
    if complement.shape[1]:
        decomposition: Any = scipy.linalg.schur(
            complement.T @ a.T @ complement, sort=lambda real, _: real >= -SLOWEST * size
        )
        law, basis, count = decomposition
    directions = complement @ basis[:, :count]
    shares = np.linalg.norm(directions, axis=1)
    # a direction over many states has no large share; then the largest ones are named
    threshold = min(SHARE, 0.9 * np.max(shares, initial=0.0)) if count else SHARE
    selection = [name for name, share in zip(names, shares, strict=True) if share >= threshold]
    rates = np.linalg.eigvals(law[:count, :count]) if count else np.zeros(0, complex)
    return Controllability(reachable.shape[1], directions, rates, tuple(dict.fromkeys(selection)))
