"""Dense linear algebra for batches of small matrices.

A library call for each 6×6 matrix costs more than its arithmetic, and a batch would pay that for
each of its members. Here sizes are small and fixed: loops have fixed counts, pivots are selected
without branches.
"""

from jaxtyping import Array, Float

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.traced_once import traced_once

Square = Float[Array, "n n"]


@traced_once
def product(left: Float[Array, "n k"], right: Float[Array, "k m"]) -> Float[Array, "n m"]:
    """Matrix product as a sum of outer products, which XLA fuses with neighbouring operations.

    Use it for the last product of a chain. For a product that is a factor of another one, plain `@`
    is faster.
    """
    total = left[:, 0, None] * right[0]
    for k in range(1, left.shape[1]):
        total = total + left[:, k, None] * right[k]
    return total


def symmetric(matrix: Square) -> Square:
    """Symmetric part of a matrix."""
    return 0.5 * (matrix + matrix.T)


@traced_once
def whiten(positive: Square, right: Float[Array, "n m"]) -> Float[Array, "n m"]:
    """C^-1 `right`, where `positive` = C C' with C lower triangular (Cholesky factor).

    The result w satisfies w' w = right' positive^-1 right.

    Args:
        positive: Symmetric positive definite matrix, (n, n); otherwise the result is NaN.
        right: Right-hand side, (n, m).
    """
    solution = []
    rows = jnp.concatenate([positive, right], axis=1)
    size = len(positive)
    for k in range(size):
        row = rows[0] * jax.lax.rsqrt(rows[0, 0])
        solution.append(row[size - k :])
        rows = rows[1:, 1:] - row[1 : size - k, None] * row[1:]
    return jnp.stack(solution)


@traced_once
def factor(semidefinite: Square, drop: float = 1e-13) -> Square:
    """Lower triangular L with L L' = `semidefinite`, which may be singular.

    Args:
        semidefinite: Symmetric positive semidefinite matrix, (n, n).
        drop: Pivots up to this fraction of the largest diagonal element are treated as rounding
            errors; their column is zero.
    """
    index = jnp.arange(len(semidefinite))
    threshold = drop * jnp.max(semidefinite)  # the largest element is on the diagonal
    remainder, columns = semidefinite, []
    for k in range(len(semidefinite)):
        pivot = remainder[k, k]
        # a compiler may round the two uses of the pivot differently: keep the argument positive
        scale = jnp.where(pivot > threshold, jax.lax.rsqrt(jnp.maximum(pivot, threshold)), 0.0)
        column = jnp.where(index >= k, remainder[:, k] * scale, 0.0)
        columns.append(column)
        remainder = remainder - column[:, None] * column
    return jnp.stack(columns, axis=1)


@traced_once
def inverse_definite(matrix: Square) -> Square:
    """Inverse of a symmetric positive definite matrix, by elimination without pivoting."""
    size = len(matrix)
    unit = jnp.eye(size)
    rows = jnp.concatenate([matrix, unit], axis=1)
    for k in range(size):
        pivot = rows[k] / rows[k, k]
        rows = jnp.where(unit[:, k, None] == 1.0, pivot, rows - rows[:, k, None] * pivot)
    return rows[:, size:]


@traced_once
def solve(
    matrix: Square, right: Float[Array, "n m"]
) -> tuple[Float[Array, "n m"], Float[Array, ""]]:
    """Solution X of `matrix` X = `right`, and log |det matrix|.

    Gaussian elimination with partial pivoting. Rows are not swapped; `order` records the pivot row
    of each column. A singular matrix gives infinities or NaN.

    Args:
        matrix: Matrix, (n, n).
        right: Right-hand side, (n, m); m may be 0 if only the determinant is wanted.
    """
    size = len(matrix)
    index = jnp.arange(size)

    def step(k, carry):
        rows, eliminated, order, logarithm = carry
        column = rows[:, k]
        best = jnp.argmax(jnp.where(eliminated, -1.0, jnp.abs(column)))
        is_pivot = index == best
        pivot = column[best]
        row = rows[best] / pivot
        rows = jnp.where(is_pivot[:, None], row, rows - column[:, None] * row)
        order = jnp.where(index == k, best, order)
        return rows, eliminated | is_pivot, order, logarithm + jnp.log(jnp.abs(pivot))

    rows = jnp.concatenate([matrix, right], axis=1)
    start = (rows, jnp.zeros(size, bool), index, jnp.zeros(()))
    rows, _, order, logarithm = jax.lax.fori_loop(0, size, step, start)
    return rows[order, size:], logarithm
