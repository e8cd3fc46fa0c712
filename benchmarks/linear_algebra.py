"""Linear algebra of compiled code against LAPACK: errors over random and hard matrices.

    python benchmarks/linear_algebra.py                                     1e5 matrices, an hour
    python benchmarks/linear_algebra.py --matrices 2000 --sizes 2 4 15 --engine native

Each matrix is factored in compiled code (flight C, the lanes of the native engine, or JAX itself)
and by LAPACK. First table: backward errors, relative to the norm of the matrix, in n eps: the
largest of compiled code, of LAPACK, and the largest ratio of both for one matrix, where LAPACK's
counts as n eps if it is less; then the share of matrices whose error is above 3 times that of
LAPACK however small that is. Second table: errors of `inv`, `det`, `lstsq` and `expm`, in n eps
times the condition number. Errors are computed in extended precision.
"""

import argparse
import contextlib
from typing import Any, NamedTuple

import extended_precision as exact
import jax.scipy.linalg as jsp
import numpy as np
import scipy.linalg
from compiled_functions import ENGINES

from gyrostat.core.jax64 import jax, jnp

EPS = np.finfo(float).eps
LARGEST_EXPONENT = 5.3
"""Largest 1-norm of a matrix whose exponential is computed. Above 5.37, `expm` of JAX, which
compiled code repeats, leaves a norm of up to 10.7 for its approximation, with errors to 2e-7."""
HIDDEN = 0.1
"""Largest bound of an error that is looked at: the bounds are of first order."""


def matrices(random, size, count):
    """Random matrices: normal, graded, rank-deficient, of condition 1e15, with clusters, scaled."""
    normal = random.standard_normal((count, size, size))
    left, _, right = np.linalg.svd(normal)
    decades = np.linspace(0.0, 1.0, size)
    spectra = 10.0 ** (-15.0 * decades), decades < 0.5, 1.0 + 1e-9 * decades
    graded = normal * 10.0 ** (-12.0 * decades), normal * 10.0 ** (-12.0 * decades)[:, None]
    made = [(left * spectrum) @ right for spectrum in spectra]
    every = np.stack([normal, *graded, *made, 1e300 * normal, 1e-280 * normal])
    return every[np.arange(count) % len(every), np.arange(count)]


def turned(array):
    return np.swapaxes(array, -1, -2)


def norm(matrix):
    """Largest singular values; NaN for a matrix that is not finite."""
    matrix = np.asarray(matrix, float)
    known = np.all(np.isfinite(matrix), axis=(-2, -1))
    filled = np.where(known[:, None, None], matrix, 0.0)
    return np.where(known, np.linalg.norm(filled, 2, axis=(-2, -1)), np.nan)


def factors(a, symmetric, positive, right):
    """What is compared with LAPACK, each of one matrix."""
    rows, pivots = jsp.lu_factor(a)
    left, sizes, basis = jnp.linalg.svd(a)
    values, vectors = jnp.linalg.eigh(symmetric)
    q, r = jnp.linalg.qr(a)
    root, solution = jnp.linalg.cholesky(positive), jnp.linalg.solve(a, right)
    return rows, pivots, q, r, values, vectors, left, sizes, basis, root, solution


def by_lapack(a, symmetric, positive, right):
    """The same by LAPACK."""
    rows, pivots = jax.vmap(jsp.lu_factor)(a)
    root, solution = np.linalg.cholesky(positive), jax.vmap(jnp.linalg.solve)(a, right)
    svd, eigh = np.linalg.svd(a), np.linalg.eigh(symmetric)
    return rows, pivots, *np.linalg.qr(a), *eigh, *svd, root, solution


def permuted(matrix, pivots):
    """Matrices whose rows are exchanged one after the other."""
    matrix, batch = matrix.copy(), np.arange(len(matrix))
    for k in range(pivots.shape[1]):
        first, second = matrix[:, k].copy(), matrix[batch, pivots[:, k]].copy()
        matrix[batch, pivots[:, k]], matrix[:, k] = first, second
    return matrix


def backward_errors(results, a, symmetric, positive, right):
    """Name -> error of each matrix, in n eps; `orthogonality` is the largest of all bases."""
    rows, pivots, q, r, values, vectors, left, sizes, basis, root, solution = map(
        np.asarray, results
    )
    size = a.shape[-1]
    unit = np.eye(size)
    lower, upper = np.tril(rows, -1) + unit, np.triu(rows)
    bases = q, vectors, left, turned(basis)
    residual = exact.product(a, solution[..., None])[..., 0] - right
    scale = norm(a) * np.linalg.norm(solution, axis=1)
    errors = {
        "cholesky": norm(exact.product(root, turned(root)) - positive) / norm(positive),
        "lu": norm(exact.product(lower, upper) - permuted(a, pivots)) / norm(a),
        "solve": np.linalg.norm(residual.astype(float), axis=1) / scale,
        "qr": norm(exact.product(q, r) - a) / norm(a),
        "eigh": norm(exact.product(vectors * values[:, None], turned(vectors)) - symmetric)
        / norm(symmetric),
        "svd": norm(exact.product(left * sizes[:, None], basis) - a) / norm(a),
        "orthogonality": np.max(
            [norm(exact.product(turned(each), each) - unit) for each in bases], 0
        ),
    }
    return {name: each / (size * EPS) for name, each in errors.items()}


def backward_cells(compiled, random, size, count):
    """Cells of the first table, for matrices of one size."""
    a = matrices(random, size, count)
    scale = 2.0 ** np.round(np.log2(np.max(np.abs(a), axis=(1, 2), keepdims=True)))
    symmetric = a / 2.0 + turned(a) / 2.0
    right = random.standard_normal((count, size))
    # those scaled to 1e300 and 1e-280 would over- or underflow in products
    mild = a / scale
    positive = mild @ turned(mild) + 10.0 ** random.uniform(-13.0, 1.0, (count, 1, 1)) * np.eye(
        size
    )
    results = list(compiled(factors, a[0], symmetric[0], positive[0], right[0])(
        a, symmetric, positive, right
    ))  # fmt: skip
    for number in (0, 3, 4, 7):
        each = np.asarray(results[number])
        outer = scale[:, 0] if each.ndim == 2 else scale
        results[number] = (
            (np.triu(each) / outer + np.tril(each, -1)) if number == 0 else each / outer
        )
    results[10] = np.asarray(results[10]) * scale[:, 0]
    given = mild, symmetric / scale, positive, right
    ours = backward_errors(results, *given)
    peer = backward_errors(by_lapack(*given), *given)
    cells = []
    for name, error in ours.items():
        known = np.isfinite(error) & np.isfinite(peer[name])
        error, other = error[known], peer[name][known]
        ratio, share = np.max(error / np.maximum(other, 1.0)), np.mean(error > 3.0 * other)
        cells.append(f"{name} {np.max(error):.2g} ({np.max(other):.2g}) {ratio:.2g} {share:.1%}")
    return cells


def derived(a, tall, right, exponent):
    """Functions whose errors grow with the condition of a matrix."""
    solution = jnp.linalg.lstsq(tall, right)[0]
    return jnp.linalg.inv(a), jnp.linalg.det(a), solution, jsp.expm(exponent)


def derived_by_lapack(a, tall, right, exponent):
    """The same by NumPy and SciPy; not a number for a singular matrix."""
    inverses = np.full(a.shape, np.nan)
    for k, matrix in enumerate(a):
        with contextlib.suppress(np.linalg.LinAlgError):
            inverses[k] = np.linalg.inv(matrix)
    pairs = zip(tall, right, strict=True)
    solutions = np.array([np.linalg.lstsq(m, b, rcond=None)[0] for m, b in pairs])
    return inverses, np.linalg.det(a), solutions, scipy.linalg.expm(exponent)


class Truth(NamedTuple):
    """Results in extended precision, and what errors are divided by.

    Attributes:
        results: Inverses, determinants, solutions and exponentials.
        conditions: Condition numbers of each; not a number where 10 n eps times that is above
            `HIDDEN`.
    """

    results: tuple[Any, ...]
    conditions: tuple[Any, ...]

    @classmethod
    def of(cls, a, tall, right, exponent):
        """Compute in extended precision."""
        inverse, determinant = exact.inverse(a)
        solution, exponential = exact.least_squares(tall, right), exact.exponential(exponent)
        rest = exact.product(tall, solution[..., None])[..., 0] - right
        condition, of_tall = norm(a) * norm(inverse), np.linalg.cond(tall)
        share = length(rest) / (norm(tall) * length(solution))
        of_solution = of_tall * (1.0 + (1.0 + of_tall) * share)
        pairs = zip(exponent, exponential.astype(float), strict=True)
        of_exponential = np.array([exponential_condition(*pair) for pair in pairs])
        conditions = condition, condition, of_solution, of_exponential
        hidden = condition, condition, of_tall, of_exponential
        largest = HIDDEN / (10.0 * a.shape[-1] * EPS)
        kept = [np.where(h < largest, c, np.nan) for h, c in zip(hidden, conditions, strict=True)]
        return cls((inverse, determinant, solution, exponential), tuple(kept))

    def errors(self, found, size):
        """Errors of results, in n eps times the condition number."""
        for number, (each, true) in enumerate(zip(found, self.results, strict=True)):
            spectral = number == 0
            error = norm(each - true) if spectral else length(each - true)
            scale = norm(true) if spectral else length(true)
            yield error / scale / self.conditions[number] / (size * EPS)


def length(array):
    """Root of the sum of squares over all axes but the first."""
    array = np.asarray(array, float)
    return np.linalg.norm(array.reshape(len(array), -1), axis=1)


def exponential_condition(matrix, exponential):
    """Lower bound of the condition number of an exponential, by the power method; at least 1.

    Below 1, rounding of the result alone would be more than the bound.
    """
    change = np.ones_like(matrix) / len(matrix)
    for _ in range(3):
        for argument in (matrix, matrix.T):
            image = scipy.linalg.expm_frechet(argument, change, compute_expm=False)
            size = np.linalg.norm(image)
            change = image / size
    return max(1.0, size * np.linalg.norm(matrix) / np.linalg.norm(exponential))


def forward_cells(compiled, random, size, count):
    """Cells of the second table: the largest error of compiled code, and that of LAPACK."""
    a = matrices(random, size, count)
    a = a / np.max(np.abs(a), axis=(1, 2), keepdims=True)
    right, tall = random.standard_normal((count, size)), a[:, :, : (size + 1) // 2]
    lengths = 10.0 ** random.uniform(-3.0, np.log10(LARGEST_EXPONENT), count)
    exponent = a * (lengths / np.linalg.norm(a, 1, axis=(1, 2)))[:, None, None]
    given = a, tall, right, exponent
    found = map(np.asarray, compiled(derived, *(each[0] for each in given))(*given))
    with np.errstate(all="ignore"):
        truth = Truth.of(*given)
        pairs = zip(
            ("inv", "det", "lstsq", "expm"),
            truth.errors(found, size),
            truth.errors(derived_by_lapack(*given), size),
            strict=True,
        )
        return [f"{n} {np.nanmax(ours):.2g} ({np.nanmax(peer):.2g})" for n, ours, peer in pairs]


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--matrices", type=int, default=100_000, help="number of matrices")
    parser.add_argument("--sizes", type=int, nargs="+", default=range(1, 33), help="sizes")
    parser.add_argument("--engine", choices=ENGINES, default="flight", help="compiled code")
    parser.add_argument("--seed", type=int, default=0, help="seed")
    options = parser.parse_args()
    random, count = np.random.default_rng(options.seed), options.matrices // len(options.sizes)
    compiled = ENGINES[options.engine]
    for size in options.sizes:
        cells = backward_cells(compiled, random, size, count)
        print(f"n = {size:2d}, {count} matrices: {'; '.join(cells)}", flush=True)
        cells = forward_cells(compiled, random, size, min(count, 500))
        print(f"n = {size:2d}, forward: {'; '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
