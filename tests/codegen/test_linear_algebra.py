"""Linear algebra in flight C and SIMD lanes against LAPACK, by JAX and NumPy.

Golub and Van Loan, Matrix Computations, 4th edition: backward errors of orthogonal methods are a
modest multiple of n eps, those of LU with partial pivoting of the growth factor times that.
"""

from pathlib import Path

import jax.scipy.linalg as jsp
import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.jacobi import eigh, svd
from gyrostat.codegen.linear_algebra import COMPOSED, WRITTEN
from gyrostat.codegen.scope import FLIGHT
from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.simd.batch_scope import BATCH
from gyrostat.codegen.support import compiled_primitives, unsupported
from gyrostat.codegen.tracing import CALLS, inner_jaxprs
from gyrostat.core.jax64 import jax, jnp

EPS = np.finfo(float).eps
RANDOM = np.random.default_rng(35)
RUNS = 24
MATRIX, RIGHT = RANDOM.standard_normal((RUNS, 4, 4)), RANDOM.standard_normal((RUNS, 4))
LARGE = RANDOM.standard_normal((RUNS, WRITTEN + 1, WRITTEN + 1))
MATRIX[0, 1] = MATRIX[0, 0]  # singular
MATRIX[1] = 0.0
MATRIX[2, 1, 2], MATRIX[3, 0, 0] = np.nan, np.inf
MATRIX[4] *= 1e150
MATRIX[5] *= 1e-150
LARGE[0, :, 4] = 0.0
LARGE[1] = 0.0
REGULAR = slice(6, None)
"""Runs whose matrices are neither singular nor near a limit of numbers; LAPACK's singular values of
a matrix with NaN need not end."""


def solved(a, b, large):
    """Solutions and factors; finite in the same places as LAPACK's."""
    definite = a @ a.T + 0.1 * jnp.eye(4)
    factor = jsp.cho_factor(definite, lower=True)
    rows, pivots = jsp.lu_factor(large)
    return (
        jnp.linalg.cholesky(definite),
        jnp.linalg.cholesky(a + a.T),
        jnp.tril(factor[0]),
        jsp.cho_solve(factor, b),
        jnp.linalg.solve(a, b),
        jnp.linalg.solve(large, large.T),
        jnp.linalg.inv(a),
        jnp.linalg.det(a),
        *jnp.linalg.slogdet(a),
        rows,
        pivots,
        jsp.lu(a[:3])[0],
        jsp.solve_triangular(a, b, lower=True, trans=1),
        jsp.solve_triangular(a, b, unit_diagonal=True),
        jax.vmap(jnp.linalg.solve, (None, 0))(a, jnp.stack([b, 2.0 * b])),
        jax.vmap(jnp.linalg.cholesky)(jnp.stack([definite, 2.0 * definite])),
    )


def orthogonal(a, b, large):
    """Orthogonal factors as LAPACK has them; vectors as products, which have no free sign."""
    values, vectors = jnp.linalg.eigh(a + a.T)
    left, sizes, right = jnp.linalg.svd(a[:, :3])
    return (
        *jnp.linalg.qr(a),
        *jnp.linalg.qr(a[:, :2], mode="complete"),
        *jnp.linalg.qr(a[:2]),
        values,
        (vectors * values) @ vectors.T,
        jnp.linalg.eigvalsh(large + large.T),
        sizes,
        (left[:, :3] * sizes) @ right,
        left @ left.T,
        jnp.linalg.svd(large, compute_uv=False),
        jnp.linalg.lstsq(a[:, :3], b)[0],
        jnp.linalg.pinv(a[:, :2]),
        jnp.linalg.norm(a, 2),
        jsp.expm(0.3 * a),
        jax.grad(lambda a: jnp.sum(jnp.linalg.solve(a, b) ** 2))(a),
        jax.grad(lambda a: jnp.sum(jnp.linalg.cholesky(a @ a.T + jnp.eye(4))))(a),
        jax.grad(lambda a: jnp.linalg.eigvalsh(a + a.T)[0])(a),
        jax.grad(lambda a: jnp.linalg.svd(a, compute_uv=False)[0])(a),
    )


CASES = [solved, orthogonal]
ARGUMENTS = MATRIX, RIGHT, LARGE


def every(*arguments):
    return [function(*arguments) for function in CASES]


@pytest.fixture(scope="module")
def expected():
    results = jax.jit(jax.vmap(solved))(*ARGUMENTS)
    regular = jax.jit(jax.vmap(orthogonal))(*(array[REGULAR] for array in ARGUMENTS))
    return {
        solved: [np.asarray(each)[REGULAR] for each in results],
        orthogonal: [np.asarray(each) for each in regular],
        "all runs": results,
    }


@pytest.fixture(scope="module")
def in_lanes():
    if compiler() is None:
        pytest.skip("needs a C compiler")
    results = lanes(every, (True,) * 3, ARGUMENTS)(*ARGUMENTS)
    return dict(zip(CASES, results, strict=True))


@pytest.fixture(scope="module")
def results_of(module_at):
    return module_at(Path(__file__).with_name("compiled.py")).results_of


@pytest.fixture(scope="module")
def in_flight(results_of, tmp_path_factory):
    arguments = dict(zip(("a", "b", "large"), ARGUMENTS, strict=True))
    found = results_of("algebra", CASES, arguments, tmp_path_factory.mktemp("algebra"))
    return {function: results for function, (_, results) in found.items()}


def alike(found, expected):
    for number, (ours, lapack) in enumerate(zip(found, expected, strict=True)):
        np.testing.assert_allclose(ours[REGULAR], lapack, 1e-9, 1e-11, err_msg=str(number))


@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_lanes_agree_with_lapack(function, in_lanes, expected):
    alike(in_lanes[function], expected[function])


@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_flight_c_agrees_with_lapack(function, in_flight, expected):
    alike(in_flight[function], expected[function])


@pytest.mark.parametrize("writer", ["in_lanes", "in_flight"])
def test_results_are_finite_exactly_where_those_of_lapack_are(writer, expected, request):
    found = request.getfixturevalue(writer)
    for number, (ours, lapack) in enumerate(zip(found[solved], expected["all runs"], strict=True)):
        finite = np.isfinite(ours), np.isfinite(lapack)
        for run in (0, 1, 2, 4, 5):
            np.testing.assert_array_equal(
                *(each[run] for each in finite), err_msg=f"{number} {run}"
            )
        # OpenBLAS writes 0 where it multiplies by 1 / inf: here, an infinite pivot is not hidden
        assert not np.any(finite[0][3] & ~finite[1][3]), number


@pytest.mark.parametrize("writer", ["in_lanes", "in_flight"])
def test_no_eigenvalues_of_a_matrix_with_nan_or_infinity(writer, request):
    found = request.getfixturevalue(writer)[orthogonal]
    for run in (2, 3):
        for number in (6, 7, 9, 10):
            assert np.all(np.isnan(found[number][run]))


def hard(size):
    """Matrices of a size at which factorisations fail that are not careful."""
    matrix = RANDOM.standard_normal((size, size))
    left, _, right = np.linalg.svd(matrix)
    decades = np.linspace(0.0, 1.0, size)
    yield matrix
    yield np.eye(size)
    yield np.ones((size, size))
    yield matrix * 10.0 ** (-12.0 * decades)
    yield matrix * 10.0 ** (-12.0 * decades)[:, None]
    yield (left * 10.0 ** (-15.0 * decades)) @ right
    yield (left * (decades < 0.5)) @ right  # rank-deficient, repeated singular values
    yield (left * (1.0 + 1e-9 * decades)) @ right
    yield 1.0 / (np.arange(size) + np.arange(size)[:, None] + 1.0)  # Hilbert's
    yield np.eye(size) - np.triu(np.ones((size, size)), 1)  # Wilkinson's growth
    yield 1e300 * matrix
    yield 1e-300 * matrix


def normwise(error, matrix):
    """Error relative to the norm of a matrix and n eps."""
    size = np.max(np.abs(matrix))
    return np.linalg.norm(error / size, 2) / np.linalg.norm(matrix / size, 2) / (len(matrix) * EPS)


@pytest.mark.parametrize("size", [1, 2, 3, 6, WRITTEN + 3])
def test_backward_errors_are_a_few_rounding_errors(size):
    factors = {
        "eigh": jax.jit(lambda a: eigh(a, lower=True)),
        "svd": jax.jit(lambda a: svd(a, full_matrices=True, compute_uv=True)),
        "qr": jax.jit(lambda a: COMPOSED["qr"](a, pivoting=False, full_matrices=True)),
        "lu": jax.jit(COMPOSED["lu"]),
    }
    for number, matrix in enumerate(hard(size)):
        symmetric = matrix / 2.0 + matrix.T / 2.0
        vectors, values = map(np.asarray, factors["eigh"](symmetric))
        sizes, left, right = map(np.asarray, factors["svd"](matrix))
        q, r = map(np.asarray, factors["qr"](matrix))
        rows, _, order = map(np.asarray, factors["lu"](matrix))
        lower, upper = np.tril(rows, -1) + np.eye(size), np.triu(rows)
        assert normwise((vectors * values) @ vectors.T - symmetric, symmetric) < 10.0, number
        assert normwise((left * sizes) @ right - matrix, matrix) < 10.0, number
        assert normwise(q @ r - matrix, matrix) < 10.0, number
        assert normwise(lower @ upper - matrix[order], matrix) < 10.0 * _growth(upper, matrix)
        for basis in (vectors, left, right, q):
            assert normwise(basis.T @ basis - np.eye(size), np.eye(size)) < 10.0, number
        assert np.all(np.diff(values) >= 0.0), number
        assert np.all(np.diff(sizes) <= 0.0), number


def _growth(upper, matrix):
    return max(1.0, np.max(np.abs(upper)) / np.max(np.abs(matrix)))


def text_of_filter(size):
    """Characters of the C of a filter with some states."""

    def update(state, covariance, value):
        change = jnp.eye(size) + 1e-3 * jnp.outer(jnp.sin(state), jnp.cos(state))
        row = jnp.eye(6, size) + 1e-3 * jnp.outer(jnp.cos(state[:6]), state)
        covariance = change @ covariance @ change.T + 1e-6 * jnp.eye(size)
        scatter = row @ covariance @ row.T + 1e-4 * jnp.eye(6)
        gain = jsp.cho_solve(jsp.cho_factor(scatter), row @ covariance).T
        state = change @ state + gain @ (value - row @ change @ state)
        return state, covariance - gain @ scatter @ gain.T

    arguments = {"state": np.ones(size), "covariance": np.eye(size), "value": np.ones(6)}
    return len(emit("filter", [Entry("filter", update, arguments, ("state", "covariance"))]).source)


def test_text_of_a_filter_does_not_grow_with_its_matrices():
    assert text_of_filter(30) < 1.1 * text_of_filter(15)


@pytest.mark.parametrize("writer", ["lanes", "flight"])
def test_eliminations_in_loops_have_small_backward_errors(writer, results_of, tmp_path):
    """Hard matrices of a size that is not written out; LAPACK's pivots where they are unique."""
    size = 7
    matrices = np.stack([*hard(size)])

    def factors(a):
        scaled = a / jnp.max(jnp.abs(a))
        definite = scaled @ scaled.T + jnp.eye(size)
        rows, pivots, order = jax.lax.linalg.lu(a)
        right = jnp.arange(1.0, 3.0 * size + 1.0).reshape(size, 3)
        solution = jsp.solve_triangular(definite, right, lower=True, trans=1)
        return definite, jnp.linalg.cholesky(definite), rows, pivots, order, right, solution

    if writer == "lanes":
        if compiler() is None:
            pytest.skip("needs a C compiler")
        found = lanes(factors, (True,), (matrices,))(matrices)
    else:
        _, found = results_of("elimination", [factors], {"a": matrices}, tmp_path)[factors]
    pivots_of_lapack = np.asarray(jax.vmap(jax.lax.linalg.lu)(matrices)[1])
    np.testing.assert_array_equal(found[3][[0, 3, 4, 5]], pivots_of_lapack[[0, 3, 4, 5]])
    for number, (matrix, *each) in enumerate(zip(matrices, *found, strict=True)):
        definite, factor, rows, _, order, right, solution = (np.asarray(array) for array in each)
        assert normwise(factor @ factor.T - definite, definite) < 10.0, number
        lower, upper = np.tril(rows, -1) + np.eye(size), np.triu(rows)
        assert normwise(lower @ upper - matrix[order], matrix) < 10.0 * _growth(upper, matrix)
        residual = np.tril(definite).T @ solution - right
        scale = np.abs(np.tril(definite).T) @ np.abs(solution)
        assert np.max(np.abs(residual) / scale) < 10.0 * size * EPS, number


def test_the_table_of_primitives_is_what_the_rules_refuse():
    table = compiled_primitives()
    functions = {
        jnp.linalg.cholesky: MATRIX[0],
        jnp.linalg.eigvalsh: MATRIX[0],
        jnp.linalg.eig: MATRIX[0],
        jax.scipy.special.gammaln: RIGHT[0],
        jax.scipy.special.erfinv: RIGHT[0],
        jnp.fft.fft: RIGHT[0],
        jax.scipy.linalg.hessenberg: MATRIX[0],
        jnp.sort: RIGHT[0],
        jnp.signbit: RIGHT[0],
        jax.scipy.linalg.schur: MATRIX[0],
        jax.lax.population_count: np.arange(3),
        jax.random.normal: np.array([1, 2], np.uint32),
        lambda x: jax.lax.top_k(x, 2): RIGHT[0],
        lambda key: jax.random.randint(key, (), 0, 5): np.array([1, 2], np.uint32),
    }
    for function, argument in functions.items():
        closed = jax.make_jaxpr(function)(argument)
        for scope, number in ((BATCH, 0), (FLIGHT, 1)):
            listed = all(table[name][number] for name in names_of(closed.jaxpr))
            assert listed == (unsupported(closed, scope) is None), function


def names_of(jaxpr):
    for equation in jaxpr.eqns:
        yield equation.primitive.name
        if equation.primitive.name in CALLS:
            for inner in inner_jaxprs(equation):
                yield from names_of(inner)


def hidden(a):
    """A column far smaller than the matrix; R as in LAPACK."""
    return jnp.linalg.qr(a)


SMALL_COLUMN = np.array([[1.0, 1e-200], [0.0, 2e-200], [0.0, 1e-200]])


def stacked(a):
    """Several matrices at once, also a stack of one."""
    symmetric = a + jnp.swapaxes(a, -1, -2)
    return (
        jax.vmap(jnp.linalg.eigvalsh)(symmetric),
        jax.vmap(lambda a: jnp.linalg.svd(a, compute_uv=False))(a),
        jnp.linalg.pinv(a),
        jnp.linalg.eigvalsh(symmetric[:1]),
    )


def single(a):
    """In single precision."""
    values, vectors = jnp.linalg.eigh(a + a.T)
    left, sizes, right = jnp.linalg.svd(a)
    q, r = jnp.linalg.qr(a)
    return (vectors * values) @ vectors.T - a.T, (left * sizes) @ right, q @ r


def test_a_small_column_is_reflected_too(results_of, tmp_path):
    found = results_of("small_column", [hidden], {"a": SMALL_COLUMN[None]}, tmp_path)
    _, (q, r) = found[hidden]
    expected = np.linalg.qr(SMALL_COLUMN)
    np.testing.assert_allclose(q[0], expected[0], atol=1e-15)
    np.testing.assert_allclose(r[0], expected[1], rtol=1e-14)


def test_stacks_of_matrices_compile_for_flight(results_of, tmp_path):
    stack = MATRIX[6:9, :3, :3]
    status, found = results_of("stacks", [stacked], {"a": stack[None]}, tmp_path)[stacked]
    assert not status.any()
    values = np.linalg.eigvalsh(stack + np.swapaxes(stack, -1, -2))
    expected = values, np.linalg.svd(stack)[1], np.linalg.inv(stack), values[:1]
    for ours, peer in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours[0], peer, 1e-9, 1e-12)


def test_single_precision_has_its_own_rounding_errors(results_of, tmp_path):
    matrices = np.concatenate([np.zeros((1, 4, 4)), MATRIX[REGULAR], 1e15 * MATRIX[REGULAR]])
    arguments = {"a": matrices}
    found = results_of("single_precision", [single], arguments, tmp_path, precision="float")
    status, products = found[single]
    assert not status.any()
    scale = np.max(np.abs(matrices), axis=(1, 2), keepdims=True) + 1e-30
    for number, product in enumerate(products):
        error = (product - matrices) / scale
        assert np.max(np.abs(error)) < 60.0 * np.finfo(np.float32).eps, number


def test_matrices_without_elements_are_refused():
    for function, shape in ((jnp.linalg.qr, (3, 0)), (jnp.linalg.eigvalsh, (0, 0))):
        for scope in (BATCH, FLIGHT):
            found = unsupported(jax.make_jaxpr(function)(np.zeros(shape)), scope)
            assert "that are not empty" in str(found)


@pytest.mark.parametrize("shapes", [((1024,), (1024,)), ((65, 15), (15, 2)), ((65, 4), (4, 5))])
def test_products_of_any_shape_compile(shapes):
    closed = jax.make_jaxpr(jnp.matmul)(*(np.zeros(shape) for shape in shapes))
    assert unsupported(closed, FLIGHT) is None
    assert unsupported(closed, BATCH) is None


def tiny(a, b):
    """Results of subnormal matrices, scaled back."""
    small = 1e-310 * (a + a.T)
    return jnp.linalg.solve(small, 1e-310 * b), jnp.linalg.eigvalsh(small) * 1e155 * 1e155


def test_subnormal_matrices_are_not_zero(results_of, tmp_path):
    """In flight C. XLA takes subnormal numbers as zero, C does not; spaced 5e-324, they have 13
    digits here."""
    arguments = {"a": MATRIX[REGULAR], "b": RIGHT[REGULAR]}
    _, (solution, values) = results_of("tiny_matrices", [tiny], arguments, tmp_path)[tiny]
    symmetric = arguments["a"] + np.swapaxes(arguments["a"], -1, -2)
    expected = np.linalg.solve(symmetric, arguments["b"][..., None])[..., 0]
    np.testing.assert_allclose(solution, expected, rtol=1e-9)
    np.testing.assert_allclose(values, np.linalg.eigvalsh(symmetric), rtol=1e-10)
