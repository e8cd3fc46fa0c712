"""Linear algebra of compiled code against LAPACK: backward errors over random and hard matrices.

    python benchmarks/linear_algebra.py                 1e5 matrices, some minutes
    python benchmarks/linear_algebra.py --matrices 2000

Each matrix is factored by the functions that compiled code contains and by LAPACK. Here JAX
compiles them: the same operations, but for subnormal numbers, which XLA takes as zero. Errors are
relative to the norm of the matrix, in n eps.
"""

import argparse

import numpy as np

from gyrostat.codegen.jacobi import eigh, svd
from gyrostat.codegen.linear_algebra import COMPOSED
from gyrostat.core.jax64 import jax

EPS = np.finfo(float).eps
SIZES = (1, 2, 3, 4, 6, 8, 9, 12, 15, 16, 24, 32)


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


def norm(matrix):
    return np.linalg.norm(matrix, 2, axis=(-2, -1))


def errors(factors, matrix, symmetric):
    """Backward errors of each factorisation, and the lack of orthogonality."""
    (rows, _, order), (q, r), (vectors, values), (sizes, left, right) = factors
    unit = np.eye(matrix.shape[-1])
    lower, upper = np.tril(rows, -1) + unit, np.triu(rows)
    exchanged = np.take_along_axis(matrix, np.asarray(order)[..., None], axis=-2)
    scale = np.max(np.abs(matrix), axis=(-2, -1), keepdims=True)
    size = norm(matrix / scale)
    bases = [norm(np.swapaxes(b, -1, -2) @ b - unit) for b in (q, vectors, left, right)]
    return {
        "LU": norm(lower @ (upper / scale) - exchanged / scale) / size,
        "QR": norm(q @ (r / scale) - matrix / scale) / size,
        "eigh": norm(
            (vectors * (values[:, None] / scale)) @ np.swapaxes(vectors, -1, -2) - symmetric / scale
        )
        / norm(symmetric / scale),
        "svd": norm((left * (sizes[:, None] / scale)) @ right - matrix / scale) / size,
        "orthogonality": np.max(bases, axis=0),
    }


def lapack(matrix, symmetric):
    scale = np.max(np.abs(matrix), axis=(-2, -1), keepdims=True)
    values, vectors = np.linalg.eigh(symmetric / scale)
    left, sizes, right = np.linalg.svd(matrix / scale)
    q, r = np.linalg.qr(matrix / scale)
    factors = jax.lax.linalg.lu(matrix)
    outer = scale[:, 0]
    return factors, (q, r * scale), (vectors, values * outer), (sizes * outer, left, right)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--matrices", type=int, default=100_000, help="number of matrices")
    parser.add_argument("--seed", type=int, default=0, help="seed")
    given = parser.parse_args()
    random, count = np.random.default_rng(given.seed), given.matrices // len(SIZES)
    print(
        "largest error in n eps (and that of LAPACK), and largest ratio where LAPACK's is above 1"
    )
    for size in SIZES:
        functions = (
            COMPOSED["lu"],
            lambda a: COMPOSED["qr"](a, pivoting=False, full_matrices=False),
            lambda a: eigh(a, lower=True),
            lambda a: svd(a, full_matrices=True, compute_uv=True),
        )
        batches = [jax.jit(jax.vmap(function)) for function in functions]
        matrix = matrices(random, size, count)
        symmetric = matrix / 2.0 + np.swapaxes(matrix, -1, -2) / 2.0
        each = (matrix, matrix, symmetric, matrix)
        factors = [tuple(map(np.asarray, batch(a))) for batch, a in zip(batches, each, strict=True)]
        ours, peer = errors(factors, matrix, symmetric), errors(lapack(*each[1:3]), *each[1:3])
        cells = []
        for name in ours:
            a, b = ours[name] / (size * EPS), peer[name] / (size * EPS)
            ratio = np.max(a / np.maximum(b, 1.0))
            cells.append(f"{name} {np.max(a):.2g} ({np.max(b):.2g}) {ratio:.2g}")
        print(f"n = {size:2d}, {count} matrices: {'; '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
