"""Small dense algebra against NumPy."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrostat.core import linear
from gyrostat.core.jax64 import jax

SOLVE, WHITEN, FACTOR = jax.jit(linear.solve), jax.jit(linear.whiten), jax.jit(linear.factor)
SEEDS = st.integers(0, 2**32 - 1)


@given(SEEDS, st.floats(-6.0, 6.0))
@settings(max_examples=50)
def test_solve_needs_no_lucky_pivots(seed, exponent):
    random = np.random.default_rng(seed)
    matrix = random.normal(size=(6, 6)) * 10**exponent
    matrix[0, 0] = matrix[1, 1] = 0.0
    matrix[3, 3] *= 1e-15
    right = random.normal(size=(6, 2))
    found, logarithm = SOLVE(matrix, right)
    miss = np.linalg.norm(matrix @ found - right)
    assert miss < 1e-14 * 100 * np.linalg.norm(matrix) * np.linalg.norm(found)
    np.testing.assert_allclose(logarithm, np.linalg.slogdet(matrix)[1], atol=1e-10)


def test_solve_a_permutation_exactly():
    matrix = np.eye(6)[[3, 0, 5, 1, 4, 2]]
    found, logarithm = SOLVE(matrix, np.eye(6))
    np.testing.assert_array_equal(found, matrix.T)
    assert logarithm == 0.0


def test_a_singular_matrix_shows():
    found, logarithm = SOLVE(np.diag([1.0, 2.0, 0.0]), np.eye(3))
    assert not np.all(np.isfinite(found))
    assert logarithm == -np.inf


@given(SEEDS)
@settings(max_examples=30)
def test_whiten_halves_an_inverse(seed):
    random = np.random.default_rng(seed)
    half, right = random.normal(size=(6, 6)), random.normal(size=(6, 4))
    positive = half @ half.T + 0.1 * np.eye(6)
    white = np.asarray(WHITEN(positive, right))
    expected = right.T @ np.linalg.solve(positive, right)
    np.testing.assert_allclose(white.T @ white, expected, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(np.linalg.cholesky(positive) @ white, right, atol=1e-12)


def test_whiten_refuses_by_nan():
    assert np.any(np.isnan(WHITEN(np.diag([1.0, -1.0, 2.0]), np.eye(3))))


@given(SEEDS, st.integers(0, 6))
@settings(max_examples=60)
def test_factor_of_any_rank(seed, rank):
    half = np.random.default_rng(seed).normal(size=(6, rank)) @ np.eye(rank, 6)
    semidefinite = half @ half.T
    lower = np.asarray(FACTOR(semidefinite))
    size = max(1.0, np.max(semidefinite, initial=0.0))
    np.testing.assert_allclose(lower @ lower.T, semidefinite, atol=1e-9 * size)
    assert np.all(np.triu(lower, 1) == 0.0)


def test_product_of_rectangles():
    random = np.random.default_rng(0)
    left, right = random.normal(size=(3, 5)), random.normal(size=(5, 2))
    np.testing.assert_allclose(linear.product(left, right), left @ right, rtol=1e-14)
