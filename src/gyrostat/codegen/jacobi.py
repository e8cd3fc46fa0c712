"""Eigenvalues of symmetric matrices and singular values, by Jacobi's rotations.

Each round rotates all columns in pairs of neighbours, and then moves them on to other neighbours: a
pass of a loop whose indices are known beforehand. The number of sweeps has a bound. Source: Golub
and Van Loan, Matrix Computations, 4th edition (sections below).
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Array, Float

from gyrostat.codegen.linear_algebra import Matrix, batched, qr
from gyrostat.core.jax64 import jax, jnp

SWEEPS = 30
"""Largest number of sweeps of Jacobi's methods; 20 were enough for all matrices of the tests."""
NEGLIGIBLE = 0.25
"""Part of an off-diagonal element that a sum with the norm must show."""


def _scale(matrix: Matrix) -> Float[Array, ""]:
    """Power of two that brings the largest element near 1: squares neither over- nor underflow.

    Each factor, and their product for every number but 0, is also a number of single precision.
    """

    def step(_: Any, carry: Any) -> Any:
        size, scale = carry
        factor = jnp.where(size > 2.0**60, 2.0**-60, 1.0)
        factor = jnp.where((size < 2.0**-60) & (size > 0.0), 2.0**60, factor)
        return size * factor, scale * factor

    return jax.lax.fori_loop(0, 17, step, (jnp.max(jnp.abs(matrix)), jnp.ones(())))[1]


def _tournament(size: int) -> np.ndarray:
    """Order of the columns for the next round (section 8.5.5).

    After size - 1 rounds, all pairs have been neighbours (2k, 2k + 1) once, and the order is again
    the first.
    """
    if size == 2:
        return np.arange(2)
    top, bottom = np.arange(size).reshape(-1, 2).T
    pairs = [top[0], bottom[0], *top[1:-1]], [*bottom[1:], top[-1]]
    return np.stack(pairs, axis=1).reshape(-1)


def _rotation(first: Any, second: Any, product: Any) -> tuple[Any, Any, Any]:
    """Tangent, cosine and sine that diagonalise [[first, product], [product, second]]."""
    needed = product != 0.0
    ratio = (second - first) / jnp.where(needed, 2.0 * product, 1.0)
    # beyond 1e150, the square overflows and the tangent is 1 / (2 ratio)
    size = jnp.minimum(jnp.abs(ratio), 1e150)
    tangent = 1.0 / (jnp.abs(ratio) + jnp.sqrt(1.0 + size * size))
    tangent = jnp.where(needed, jnp.where(ratio < 0.0, -tangent, tangent), 0.0)
    cosine = 1.0 / jnp.sqrt(1.0 + tangent * tangent)
    return tangent, cosine, tangent * cosine


def _rotated(array: Any, cosine: Any, sine: Any) -> Any:
    """Array whose neighbouring columns are rotated, (m, n) with (n / 2,) angles."""
    pairs = array.reshape(len(array), -1, 2)
    left, right = pairs[..., 0], pairs[..., 1]
    pairs = jnp.stack([cosine * left - sine * right, sine * left + cosine * right], axis=-1)
    return pairs.reshape(array.shape)


def _orthogonal(vectors: Matrix) -> Matrix:
    """Nearly orthogonal matrix without the rounding errors of its rotations.

    One step of Newton and Schulz: Å. Björck, C. Bowie, SIAM Journal on Numerical Analysis 8 (1971).
    """
    return 1.5 * vectors - 0.5 * vectors @ (vectors.T @ vectors)


def _swept(size: int, rotate: Callable[[Any], tuple[Any, Any]], carry: Any) -> Any:
    """Whether a sweep of size - 1 rounds has found nothing to rotate, and the carry after it.

    Args:
        size: Number of columns, which is even.
        rotate: One round: carry -> (whether a product was more than a rounding error, carry).
        carry: Arrays at the start.
    """

    def sweep(state: Any) -> Any:
        _, number, carry = state

        def step(_: Any, inner: Any) -> Any:
            rotated, carry = inner
            in_round, carry = rotate(carry)
            return rotated | in_round, carry

        rotated, carry = jax.lax.fori_loop(0, size - 1, step, (jnp.array(False), carry))
        return rotated, number + 1, carry

    start = jnp.array(True), jnp.zeros((), jnp.int64), carry
    rotated, _, carry = jax.lax.while_loop(
        lambda state: state[0] & (state[1] < SWEEPS), sweep, start
    )
    return ~rotated, carry


def eigh(
    matrix: Matrix, *, lower: bool, sort_eigenvalues: bool = True, **params: Any
) -> tuple[Matrix, Float[Array, " n"]]:
    """Eigenvectors and eigenvalues of a symmetric matrix, by Jacobi's method (section 8.5).

    The sign of an eigenvector is not that of LAPACK. All NaN if an element is not finite, or if
    `SWEEPS` were not enough.
    """
    if params.get("subset_by_index") is not None:
        raise NotImplementedError
    size, half = len(matrix), jnp.tril(matrix) if lower else jnp.triu(matrix).T
    symmetric = half + jnp.tril(half, -1).T
    even = size + size % 2
    scale = _scale(symmetric)
    padded = jnp.pad(symmetric * scale, (0, even - size))
    order, index = _tournament(even), np.arange(even)
    is_product = index == (index ^ 1)[:, None]
    norm = jnp.sqrt(jnp.sum(padded * padded))

    def rotate(carry: Any) -> Any:
        rest, vectors = carry
        diagonal = jnp.diagonal(rest)
        product = rest[index[::2], index[1::2]]
        tangent, *angles = _rotation(diagonal[::2], diagonal[1::2], product)
        # sums that add a small change round less than rotations of the diagonal
        change = jnp.stack([-tangent * product, tangent * product], axis=1).reshape(-1)
        rest = _rotated(_rotated(rest, *angles).T, *angles)
        rest = jnp.where(is_product, 0.0, rest)
        rest = jnp.where(index == index[:, None], diagonal + change, rest)
        carry = rest[order][:, order], _rotated(vectors, *angles)[:, order]
        return jnp.any(norm + NEGLIGIBLE * jnp.abs(product) > norm), carry

    is_result, (rest, vectors) = _swept(even, rotate, (padded, jnp.eye(size, even)))
    is_result &= jnp.all(jnp.isfinite(symmetric))
    values = jnp.diagonal(rest)[:size] / scale
    # after whole sweeps, the columns stand in their first order
    vectors = _orthogonal(vectors[:, :size])
    if sort_eigenvalues:
        rank = jnp.argsort(values)
        values, vectors = values[rank], vectors[:, rank]
    return jnp.where(is_result, vectors, jnp.nan), jnp.where(is_result, values, jnp.nan)


def svd(
    matrix: Matrix, *, full_matrices: bool, compute_uv: bool, **params: Any
) -> tuple[Float[Array, " k"], ...]:
    """Singular values, and vectors if `compute_uv`, by one-sided rotations (section 8.6.3).

    The signs of a pair of singular vectors are not those of LAPACK. All NaN if an element is not
    finite, or if `SWEEPS` were not enough.
    """
    if params.get("subset_by_index") is not None:
        raise NotImplementedError
    height, width = matrix.shape
    if height < width:
        values, *vectors = svd(matrix.T, full_matrices=full_matrices, compute_uv=compute_uv)
        return values, *(each.T for each in vectors[::-1])
    even, scale = width + width % 2, _scale(matrix)
    order = _tournament(even)
    columns = jnp.pad(matrix * scale, ((0, 0), (0, even - width)))
    share = NEGLIGIBLE / np.sqrt(height)
    total = jnp.sqrt(jnp.sum(columns * columns))

    def rotate(carry: Any) -> Any:
        columns, right = carry
        first, second = columns[:, ::2], columns[:, 1::2]
        norm, next_norm = (jnp.sum(each * each, axis=0) for each in (first, second))
        product = jnp.sum(first * second, axis=0)
        _, *angles = _rotation(norm, next_norm, product)
        carry = tuple(_rotated(each, *angles)[:, order] for each in (columns, right))
        # a column that is only rounding errors need not be orthogonal
        bound = total * jnp.sqrt(jnp.maximum(norm, next_norm))
        return jnp.any(bound + share * jnp.abs(product) > bound), carry

    is_result, (columns, right) = _swept(even, rotate, (columns, jnp.eye(width, even)))
    is_result &= jnp.all(jnp.isfinite(matrix))
    columns, right = columns[:, :width], _orthogonal(right[:, :width])
    values = jnp.sqrt(jnp.sum(columns * columns, axis=0))
    rank = jnp.argsort(-values)
    values, columns, right = values[rank], columns[:, rank], right[:, rank]
    values = jnp.where(is_result, values / scale, jnp.nan)
    if not compute_uv:
        return (values,)
    # the columns are orthogonal: their triangular factor is diagonal
    left, diagonal = qr(columns, pivoting=False, full_matrices=full_matrices)
    signs = jnp.where(jnp.diagonal(diagonal) < 0.0, -1.0, 1.0)
    left = left * jnp.pad(signs, (0, left.shape[1] - width), constant_values=1.0)
    return values, *(jnp.where(is_result, each, jnp.nan) for each in (left, right.T))


COMPOSED: dict[str, Callable[..., Any]] = {
    each.__name__: batched(each, in_turn=True) for each in (eigh, svd)
}
"""Primitive -> function of its operand and parameters, of simpler operations."""
