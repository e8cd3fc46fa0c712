"""Linear algebra of batches in NumPy's extended precision: references for that in double."""

import numpy as np

REAL = np.longdouble


def product(left, right):
    """Product of batches of matrices."""
    total = REAL(0.0)
    for k in range(left.shape[-1]):
        total = total + REAL(1.0) * left[..., :, k, None] * right[..., k, None, :]
    return total


def inverse(matrix):
    """Inverses, (batch, n, n), and determinants, by elimination with partial pivoting."""
    batch, size = np.arange(len(matrix)), matrix.shape[-1]
    unit = np.broadcast_to(np.eye(size), matrix.shape)
    rows = np.concatenate([matrix, unit], axis=2).astype(REAL)
    determinant = np.ones(len(matrix), REAL)
    for k in range(size):
        best = k + np.argmax(np.abs(rows[:, k:, k]), axis=1)
        rows[batch, best], rows[:, k] = rows[:, k].copy(), rows[batch, best].copy()
        pivot = rows[:, k, k]
        determinant *= np.where(best == k, pivot, -pivot)
        row = rows[:, k] / pivot[:, None]
        rows = rows - rows[:, :, k, None] * row[:, None]
        rows[:, k] = row
    return rows[:, :, size:], determinant


def least_squares(matrix, right):
    """Solutions, (batch, n), of full column rank, by Gram and Schmidt's method done twice."""
    vectors = np.array(matrix, REAL)
    rest, width = np.array(right, REAL), matrix.shape[-1]
    triangle = np.zeros((len(matrix), width, width), REAL)
    target = np.zeros((len(matrix), width), REAL)
    for k in range(width):
        for _ in range(2):
            for j in range(k):
                part = np.sum(vectors[:, :, j] * vectors[:, :, k], axis=1)
                triangle[:, j, k] += part
                vectors[:, :, k] -= part[:, None] * vectors[:, :, j]
        triangle[:, k, k] = np.sqrt(np.sum(vectors[:, :, k] ** 2, axis=1))
        vectors[:, :, k] /= triangle[:, k, k, None]
        target[:, k] = np.sum(vectors[:, :, k] * rest, axis=1)
        rest = rest - target[:, k, None] * vectors[:, :, k]
    for k in reversed(range(width)):
        target[:, k] /= triangle[:, k, k]
        target[:, :k] -= triangle[:, :k, k] * target[:, k, None]
    return target


def exponential(matrix):
    """Exponentials, (batch, n, n), by squaring and a Taylor series of 24 terms."""
    halvings = 12
    scaled = np.array(matrix, REAL) / REAL(2.0) ** halvings
    term = np.broadcast_to(np.eye(matrix.shape[-1], dtype=REAL), matrix.shape)
    total = term
    for k in range(1, 25):
        term = product(term, scaled) / k
        total = total + term
    for _ in range(halvings):
        total = product(total, total)
    return total
