"""Errors, non-finite results and derivatives of linear algebra in flight C.

References are computed in extended precision, or by JAX with LAPACK.
"""

from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax.scipy.linalg as jsp
import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.tracing import as_arrays
from gyrostat.control import Guarded, MeasurementGuard, SampleStatus
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports import entries

SIZE = 5
EPS = np.finfo(float).eps
RANDOM = np.random.default_rng(7)
RIGHT = np.arange(1.0, SIZE + 1.0)
BASE = RANDOM.standard_normal((SIZE, SIZE))
EXACT = Path(__file__).parents[2] / "benchmarks" / "extended_precision.py"


def regular():
    """Matrices from a condition of 1 to one of 1e14."""
    left, _, right = np.linalg.svd(BASE)
    decades = np.linspace(0.0, 1.0, SIZE)
    yield BASE
    yield np.eye(SIZE)
    for digits in (3.0, 6.0, 9.0, 12.0, 14.0):
        yield (left * 10.0 ** (-digits * decades)) @ right
    yield BASE * 10.0 ** (-9.0 * decades)
    yield BASE * 10.0 ** (-9.0 * decades)[:, None]
    yield 1.0 / (np.arange(SIZE) + np.arange(SIZE)[:, None] + 1.0)  # Hilbert's


def singular():
    """Matrices without an inverse, and others near the limits of numbers."""
    yield np.zeros((SIZE, SIZE))
    yield np.triu(np.ones((SIZE, SIZE)), 1)
    yield np.diag([1.0, 2.0, 0.0, 4.0, 5.0])
    yield 1e300 * np.diag(RIGHT)
    yield 1e-300 * np.diag(RIGHT)
    yield -np.eye(SIZE)


def spoilt():
    """Matrices with an element that is not finite."""
    for bad in (np.nan, np.inf, -np.inf):
        for place in ((0, 0), (4, 4), (0, 4), (4, 0), (2, 1)):
            for matrix in (BASE, BASE @ BASE.T, np.eye(SIZE)):
                matrix = matrix.copy()
                matrix[place] = bad
                yield matrix


def direct(a):
    """Functions without singular values."""
    return (
        jnp.linalg.inv(a),
        jnp.linalg.det(a),
        jsp.expm(a),
        jnp.linalg.solve(a, RIGHT),
        jnp.linalg.cholesky(a),
        jsp.cho_solve(jsp.cho_factor(a), RIGHT),
    )


def solutions(a):
    """With least squares, whose singular values of NaN need not end in LAPACK."""
    return *direct(a), jnp.linalg.lstsq(a[:, :3], RIGHT)[0]


MATRICES = [list(each()) for each in (regular, singular, spoilt)]
EVERY = np.array([matrix for group in MATRICES for matrix in group])
GROUPS = np.repeat(["regular", "singular", "spoilt"], [len(group) for group in MATRICES])


@pytest.fixture(scope="module")
def results_of(module_at):
    return module_at(Path(__file__).with_name("compiled.py")).results_of


@pytest.fixture(scope="module")
def found(results_of, tmp_path_factory):
    """Results for all matrices."""
    folder = tmp_path_factory.mktemp("hard")
    status, results = results_of("hard", [solutions], {"a": EVERY}, folder)[solutions]
    assert not status.any()
    return results


def _length(array):
    return np.linalg.norm(np.asarray(array, float))


def test_errors_are_a_few_rounding_errors_times_the_condition(found, module_at):
    exact = module_at(EXACT)
    matrices = EVERY[GROUPS == "regular"]
    inverse, determinant = exact.inverse(matrices)
    least = exact.least_squares(matrices[:, :, :3], np.repeat(RIGHT[None], len(matrices), 0))
    power = exact.exponential(matrices)
    for k, matrix in enumerate(matrices):
        limit = 10.0 * SIZE * EPS
        condition = np.linalg.norm(matrix, 2) * np.linalg.norm(inverse[k].astype(float), 2)
        assert _length(found[0][k] - inverse[k]) < limit * condition * _length(inverse[k])
        assert abs(found[1][k] - determinant[k]) < limit * condition * abs(determinant[k])
        tall = matrix[:, :3]
        rest = _length(tall @ least[k].astype(float) - RIGHT)
        share = rest / np.linalg.norm(tall, 2) / _length(least[k])
        of_least = np.linalg.cond(tall) * (1.0 + (1.0 + np.linalg.cond(tall)) * share)
        assert _length(found[6][k] - least[k]) < limit * of_least * _length(least[k])
        # the condition of an exponential is at least the norm of the matrix
        of_power = max(1.0, np.linalg.norm(matrix, 2))
        assert _length(found[2][k] - power[k]) < limit * of_power * _length(power[k])


def test_singular_matrices_are_finite_where_those_of_jax_are(found):
    rows = GROUPS == "singular"
    expected = jax.jit(jax.vmap(solutions))(EVERY[rows])
    for number, (ours, theirs) in enumerate(zip(found, expected, strict=True)):
        finite = np.isfinite(ours[rows]), np.isfinite(theirs)
        np.testing.assert_array_equal(*finite, err_msg=str(number))


def test_nothing_hides_a_number_that_is_not_finite(found):
    """LAPACK ignores NaN in a search for a pivot, and 1 / inf is 0: it may be finite by chance."""
    rows = GROUPS == "spoilt"
    expected = jax.jit(jax.vmap(direct))(EVERY[rows])
    for number, (ours, theirs) in enumerate(zip(found, expected, strict=False)):
        hidden = np.isfinite(ours[rows]) & ~np.isfinite(theirs)
        assert not hidden.any(), number
    with_nan = np.isnan(EVERY).any(axis=(1, 2))
    for ours in found[:4]:
        finite = np.isfinite(ours[with_nan]).reshape(with_nan.sum(), -1)
        assert not finite.all(axis=1).any()


class Torque(NamedTuple):
    """Command."""

    torque: Any


class Measured(NamedTuple):
    """Measurement."""

    rate: Any


class Law(eqx.Module):
    """Law whose matrix follows from the measurement."""

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, memory, measurement):
        a, b, c = measurement.rate
        matrix = jnp.array([[a, b], [b, c]])
        solution = jnp.linalg.solve(matrix, jnp.ones(2))
        root = jnp.linalg.cholesky(matrix)
        values, vectors = jnp.linalg.eigh(matrix)
        sizes = jnp.linalg.svd(matrix, compute_uv=False)
        numbers = jnp.stack([solution, root[1], values * vectors[0], sizes])
        return memory + 1.0, Torque(numbers.reshape(-1))


def test_a_result_that_is_not_finite_gives_the_status_of_the_guard(module_at, tmp_path):
    tools = module_at(Path(__file__).with_name("compiled.py"))
    guard = MeasurementGuard.of(Measured(np.ones(3)))
    memory = Guarded(Law(), guard).start(1.0)
    arguments = {"controller": Law(), "guard": guard, "memory": memory}
    arguments = {name: as_arrays(tree) for name, tree in arguments.items()}
    rates = np.array(
        [
            [2.0, 1.0, 3.0],
            [1.0, 1.0, 1.0],  # singular
            [1.0, 2.0, 1.0],  # indefinite
            [0.0, 0.0, 0.0],
            [4.0, 1.0, 1.0],
            [1e-320, 0.0, 1e-320],  # its inverse overflows
        ]
    )
    entry = Entry(
        "law_step",
        entries.command,
        {**arguments, "measurement": Measured(rates[0])},
        ("memory", "command", "report"),
    )
    program = tools.Compiled(emit("law", [entry]), tmp_path)
    results = program.sequence(
        "law_step", {**arguments, "measurement": Measured(rates)}, ("measurement",)
    )
    status, torque = results["report"][0], results["command"][0]
    good, bad = SampleStatus.GOOD, SampleStatus.NOT_COMPUTED
    np.testing.assert_array_equal(status, [good, bad, bad, bad, good, bad])
    assert np.isfinite(torque).all()
    for held, last in ((1, 0), (2, 0), (3, 0), (5, 4)):
        np.testing.assert_array_equal(torque[held], torque[last])


def derivatives(a, b):
    """Gradients of sums of squares, which have no free sign."""

    def gradient(function):
        return jax.grad(lambda a: sum(jnp.sum(part**2) for part in function(a)))(a)

    def functions_of_eigenvalues(a):
        values, vectors = jnp.linalg.eigh(a + a.T)
        return ((vectors * jnp.sin(values)) @ vectors.T,)

    def polar(a):
        left, _, right = jnp.linalg.svd(a)
        return (left @ right + a,)

    return (
        gradient(lambda a: (jnp.linalg.inv(a),)),
        gradient(lambda a: (jnp.linalg.det(a), jnp.linalg.slogdet(a)[1])),
        gradient(lambda a: (jnp.linalg.qr(a)[1] + jnp.eye(3),)),
        gradient(lambda a: (jnp.tril(jsp.lu_factor(a)[0]),)),
        gradient(lambda a: (jnp.linalg.lstsq(a[:, :2], b)[0],)),
        gradient(functions_of_eigenvalues),
        gradient(polar),
        jax.jvp(lambda a: jsp.cho_solve(jsp.cho_factor(a @ a.T), b), (a,), (jnp.eye(3),))[1],
    )


def test_derivatives_are_those_of_jax(results_of, tmp_path):
    arguments = RANDOM.standard_normal((9, 3, 3)) + 2.0 * np.eye(3), RANDOM.standard_normal((9, 3))
    expected = jax.jit(jax.vmap(derivatives))(*arguments)
    by_name = dict(zip("ab", arguments, strict=True))
    _, in_flight = results_of("derivatives", [derivatives], by_name, tmp_path)[derivatives]
    writers = [in_flight]
    if compiler() is not None:
        writers.append(lanes(derivatives, (True, True), arguments)(*arguments))
    for results in writers:
        for number, (ours, theirs) in enumerate(zip(results, expected, strict=True)):
            scale = np.max(np.abs(theirs))
            np.testing.assert_allclose(ours, theirs, 1e-8, 1e-10 * scale, err_msg=str(number))
