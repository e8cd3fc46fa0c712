"""Factorisations and triangular solutions of small matrices, as simpler operations.

JAX calls LAPACK for these; compiled code has no library, so that each primitive is expanded into
arithmetic with fixed numbers of passes. A pass works on the first row and column, and then moves
all of them on by one place: so its indices are known beforehand, whether passes are written out or
are those of a loop. Source: Golub and Van Loan, Matrix Computations, 4th edition (sections below).
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Array, Float, Int

from gyrostat.core.jax64 import jax, jnp

Matrix = Float[Array, "m n"]
WRITTEN = 8
"""Largest number of passes that are written out."""
SMALL = 4
"""Largest size of a matrix whose elimination is expanded; `elimination` has loops for others."""
ELIMINATION = ("cholesky", "lu", "triangular_solve")


def _passes(count: int, step: Callable[[Any, Any], Any], carry: Any) -> Any:
    """Carry after `count` steps (number, carry) -> carry."""
    if count > WRITTEN:
        return jax.lax.fori_loop(0, count, step, carry)
    for k in range(count):
        carry = step(k, carry)
    return carry


def _on(array: Any, places: int = -1, axes: int = 2) -> Any:
    """Array whose elements are moved on along its first axes, round its end."""
    return jnp.roll(array, (places,) * axes, range(axes))


def cholesky(matrix: Matrix) -> Matrix:
    """Lower factor L with L L' = `matrix`, of which the lower triangle is read (section 4.2).

    All NaN if the matrix is not positive definite, as in JAX; a NaN spreads as in LAPACK.
    """
    size = len(matrix)
    index = np.arange(size)

    def step(k: Any, carry: Any) -> Any:
        rows, definite = carry
        root = jnp.sqrt(rows[0, 0])
        below = (index > 0) & (index < size - k)
        column = jnp.where(below, rows[:, 0] / root, 0.0)
        rows = jnp.where(below[:, None] & below, rows - column[:, None] * column, rows)
        definite &= ~(rows[0, 0] <= 0.0)
        return _on(rows.at[:, 0].set(column.at[0].set(root))), definite

    factor, definite = _passes(size, step, (matrix, jnp.array(True)))
    return jnp.where(definite, jnp.tril(factor), jnp.nan)


def triangular_solve(
    matrix: Matrix,
    right: Matrix,
    *,
    left_side: bool,
    lower: bool,
    transpose_a: bool,
    unit_diagonal: bool,
    **_: Any,
) -> Matrix:
    """Solution X of op(A) X = B, or of X op(A) = B, by substitution (section 3.1).

    Args:
        matrix: A; the other triangle is not read.
        right: B.
        left_side: Whether A stands on the left.
        lower: Whether A is lower triangular.
        transpose_a: Whether op(A) = A'.
        unit_diagonal: Whether the diagonal of A counts as ones.
    """
    if transpose_a == left_side:
        matrix, lower = matrix.T, not lower
    right = right if left_side else right.T
    turn = slice(None, None, 1 if lower else -1)  # an upper triangle from its end is a lower one
    size = len(matrix)
    index = np.arange(size)[:, None]

    def step(k: Any, carry: Any) -> Any:
        matrix, rows = carry
        row = rows[0] if unit_diagonal else rows[0] / matrix[0, 0]
        below = (index > 0) & (index < size - k)
        rows = jnp.where(below, rows - matrix[:, :1] * row, rows)
        return _on(matrix), _on(rows.at[0].set(row), axes=1)

    _, solution = _passes(size, step, (matrix[turn, turn], right[turn]))
    return solution[turn] if left_side else solution[turn].T


def lu(matrix: Matrix) -> tuple[Matrix, Int[Array, " k"], Int[Array, " m"]]:
    """Triangular factors in one matrix, row exchanged at each step, permutation (section 3.4).

    Partial pivoting; a column without a pivot is left as it is, as in LAPACK.
    """
    height, width = matrix.shape
    index, count = np.arange(height), min(height, width)

    def step(k: Any, carry: Any) -> Any:
        rows, pivots, permutation = carry
        below, after = index < height - k, np.arange(width) < width - k
        best = jnp.argmax(jnp.where(below, jnp.abs(rows[:, 0]), -1.0))
        chosen = below & (index == best)
        rows, permutation = (_first_exchanged(each, chosen) for each in (rows, permutation))
        pivot = rows[0, 0]
        ratio = rows[:, 0] / jnp.where(pivot == 0.0, 1.0, pivot)
        below, after = below & (index > 0), after & (np.arange(width) > 0)
        changed = jnp.where(below[:, None] & after, rows - ratio[:, None] * rows[0], rows)
        rows = changed.at[:, 0].set(jnp.where(below, ratio, rows[:, 0]))
        pivots = pivots.at[0].set((best + k).astype(jnp.int32))
        return _on(rows), _on(pivots, axes=1), _on(permutation, axes=1)

    start = matrix, jnp.zeros(count, jnp.int32), jnp.arange(height, dtype=jnp.int32)
    rows, pivots, permutation = _passes(count, step, start)
    return _on(rows, count), pivots, _on(permutation, count, axes=1)


def _first_exchanged(rows: Any, chosen: Any) -> Any:
    """Rows of which the first is exchanged with the one that is chosen."""
    first = rows[0]
    for k in range(1, len(rows)):
        first = jnp.where(chosen[k], rows[k], first)
    chosen = chosen[(slice(None), *[None] * (rows.ndim - 1))]
    return jnp.where(chosen, rows[0], rows).at[0].set(first)


def lu_pivots_to_permutation(
    pivots: Int[Array, " k"], *, permutation_size: int
) -> Int[Array, " m"]:
    """Permutation of rows after the exchanges of an LU factorisation."""
    index, count = np.arange(permutation_size), len(pivots)

    def step(k: Any, carry: Any) -> Any:
        pivots, permutation = carry
        permutation = _first_exchanged(permutation, index == pivots[0] - k)
        return _on(pivots, axes=1), _on(permutation, axes=1)

    start = pivots, jnp.arange(permutation_size, dtype=jnp.int32)
    return _on(_passes(count, step, start)[1], count, axes=1)


def geqrf(matrix: Matrix) -> tuple[Matrix, Float[Array, " k"]]:
    """Householder vectors below R, and their factors, as in LAPACK (section 5.2).

    A first element of -0 counts as 0.
    """
    height, width = matrix.shape
    index, count = np.arange(height), min(height, width)

    def step(k: Any, carry: Any) -> Any:
        rows, factors = carry
        after = (np.arange(width) > 0) & (np.arange(width) < width - k)
        rest = (index > 0) & (index < height - k)
        first, below = rows[0, 0], jnp.where(rest, rows[:, 0], 0.0)
        # without anything below the diagonal, there is nothing to reflect
        reflects = jnp.any(below != 0.0)
        largest = jnp.maximum(jnp.max(jnp.abs(below)), jnp.abs(first))
        scaled = below.at[0].set(first) / jnp.where(reflects, largest, 1.0)
        norm = jnp.sqrt(jnp.sum(scaled * scaled)) * largest
        beta = jnp.where(reflects, jnp.where(first < 0.0, norm, -norm), first)
        vector = (below / jnp.where(reflects, first - beta, 1.0)).at[0].set(1.0)
        factor = jnp.where(reflects, 2.0 / (vector @ vector), 0.0)
        changed = rows - factor * vector[:, None] * (vector @ rows)
        column = jnp.where(rest, vector, rows[:, 0]).at[0].set(beta)
        rows = jnp.where((index < height - k)[:, None] & after, changed, rows)
        return _on(rows.at[:, 0].set(column)), _on(factors.at[0].set(factor), axes=1)

    rows, factors = _passes(count, step, (matrix, jnp.zeros(count)))
    return _on(rows, count), factors


def householder_product(vectors: Matrix, factors: Float[Array, " k"]) -> Matrix:
    """First columns of the orthogonal matrix of Householder vectors (section 5.1)."""
    height, width = vectors.shape
    index, count = np.arange(height), len(factors)

    def step(number: Any, carry: Any) -> Any:
        product, vectors, factors = carry
        product, factors = (_on(each, 1, axes=1) for each in (product, factors))
        vectors = _on(vectors, 1)
        rest = (index > 0) & (index < height - (count - 1 - number))
        vector = jnp.where(rest, vectors[:, 0], 0.0).at[0].set(1.0)
        return product - factors[0] * vector[:, None] * (vector @ product), vectors, factors

    start = _on(jnp.eye(height, width), -count, axes=1), _on(vectors, -count), factors
    return _passes(count, step, start)[0]


def qr(matrix: Matrix, *, pivoting: bool, full_matrices: bool, **_: Any) -> tuple[Matrix, Matrix]:
    """Orthogonal and upper triangular factor (section 5.2)."""
    if pivoting:
        raise NotImplementedError
    height, width = matrix.shape
    rows, factors = geqrf(matrix)
    size = height if full_matrices else min(height, width)
    vectors = jnp.pad(rows, ((0, 0), (0, max(0, size - width))))[:, :size]
    return householder_product(vectors, factors), jnp.triu(rows[:size])


def batched(
    function: Callable[..., Any], axes: int = 2, *, in_turn: bool = False
) -> Callable[..., Any]:
    """Function of arrays with some axes, for arrays with more axes before these.

    Args:
        function: Function of arrays and parameters.
        axes: Number of its axes.
        in_turn: Whether arrays are passed one after the other, for loops that end by a test.
    """

    def mapped(*arrays: Any, **params: Any) -> Any:
        if any(0 in array.shape for array in arrays):
            raise NotImplementedError
        inner = partial(function, **params)
        for _ in range(arrays[0].ndim - axes):
            inner = partial(jax.lax.map, inner) if in_turn else jax.vmap(inner)
        return inner(*arrays)

    return mapped


COMPOSED: dict[str, Callable[..., Any]] = {
    **{
        each.__name__: batched(each)
        for each in (cholesky, geqrf, householder_product, lu, qr, triangular_solve)
    },
    "lu_pivots_to_permutation": batched(lu_pivots_to_permutation, 1),
}
"""Primitive -> function of its operands and parameters, of simpler operations."""
