"""Loops over the directions of a derivative, and over dense blocks of matrices with known zeros."""

import re
from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.flight.reader.tokens import tokens
from gyrostat.codegen.memo import Memo
from gyrostat.codegen.program import Assign, statements
from gyrostat.codegen.program_cost import Cost
from gyrostat.codegen.row_choice import smallest
from gyrostat.codegen.scope import FLIGHT
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.simd.compiler import compiler
from gyrostat.core.jax64 import jax, jnp

RUNS = 4
RANDOM = np.random.default_rng(5)


def turned(state):
    """Rotation of a vector by a quaternion, and drifts: (12,) -> (12,)."""
    q, v, bias, scale = state[:3], state[3:6], state[6:9], state[9:]
    size = jnp.sqrt(1.0 + q @ q)
    rate = v * (1.0 + scale) + bias
    t = 2.0 * jnp.cross(q, rate)
    return jnp.concatenate([q + 0.1 * t, v + size * t + jnp.cross(q, t), bias, scale])


def propagated(x, p):
    """Covariance with a forward derivative: the matrix is read as it is and transposed."""
    slope = jax.jacfwd(turned)(x)
    return slope @ p @ slope.T, slope


def contracted(x, p):
    """Sums over the directions: rows of the loop meet each other."""
    slope = jax.jacfwd(turned)(x)
    rows = jnp.sum(slope, axis=1), jnp.sum(slope * slope.T), slope[3:5].T @ slope[:2]
    return *rows, slope @ p @ slope.T @ p


def selected(x, p):
    """Derivatives with comparisons, and in a branch and a loop."""
    slope = jax.jacfwd(lambda y: jnp.where(y > 0.0, turned(y), y * turned(y)))(x)
    other = jax.lax.cond(x[0] > 0.0, lambda: slope @ p, lambda: 2.0 * slope)
    return jax.lax.fori_loop(0, 3, lambda _, m: 0.1 * m @ slope + other, p), other


def second(x, p):
    """Derivative of a derivative."""
    slope = jax.jacfwd(lambda y: jnp.cross(y[:3], y[3:]) * jnp.sqrt(1.0 + y @ y))
    return slope(x[:6]) @ p[:6], jax.jacfwd(slope)(x[:6]) @ p[:6]


CASES = [propagated, contracted, selected, second]


def points():
    return {"x": RANDOM.normal(size=(RUNS, 12)), "p": RANDOM.normal(size=(RUNS, 12, 12))}


def module_of(function, **arguments):
    example = {name: array[0] for name, array in arguments.items()}
    count = len(jax.tree.leaves(jax.eval_shape(function, *example.values())))
    names = tuple(f"out_{k}" for k in range(count))
    return emit("part", [Entry(function.__name__, function, example, names)])


@pytest.fixture
def always_loops(monkeypatch):
    """Loops over directions whether they pay or not."""
    for module in ("flight.c", "simd.batch"):
        chosen = f"gyrostat.codegen.{module}.smallest"
        monkeypatch.setattr(chosen, lambda lower, scope: lower(scope)[0])


@pytest.mark.usefixtures("always_loops")
def test_derivatives_in_flight_c_are_those_of_jax(module_at, tmp_path):
    results_of = module_at(Path(__file__).with_name("compiled.py")).results_of
    arguments = points()
    results = results_of("derivatives", CASES, arguments, tmp_path)
    for function in CASES:
        expected = jax.jit(jax.vmap(function))(*arguments.values())
        ours = jax.tree.leaves(results[function][1])
        for one, other in zip(ours, jax.tree.leaves(expected), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)


@pytest.mark.usefixtures("always_loops")
def test_derivatives_in_lanes_are_those_of_jax():
    if compiler() is None:
        pytest.skip("needs a C compiler")
    arguments = points()

    def every(x, p):
        return contracted(x, p), second(x, p)

    found = lanes(every, (True, True), [*arguments.values()])(*arguments.values())
    expected = jax.jit(jax.vmap(every))(*arguments.values())
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)


def products_of(function, **arguments):
    """Number of products of real numbers in the code."""
    inside = [s for f in module_of(function, **arguments).functions for s in statements(f.body)]
    products = [s for s in inside if isinstance(s, Assign) and s.operation == "mul"]
    return sum(each.target.kind == "real" for each in products)


@pytest.mark.usefixtures("always_loops")
def test_a_derivative_is_a_loop_over_its_directions(monkeypatch):
    def slope(x):
        return jax.jacfwd(turned)(x)

    looped = products_of(slope, x=points()["x"])
    monkeypatch.setattr("gyrostat.codegen.row_loops.LONG", 99)
    written = products_of(slope, x=points()["x"])
    assert looped < written


class Lowerings:
    """Programs by their ranges of rows, with their costs; those with loops over 0-3 and 3-6."""

    def __init__(self, costs):
        self.costs = costs

    def __call__(self, scope):
        memo = Memo()
        for start in (0, 3):
            if scope.rows is not None:
                memo.loops[0, 1, 15, start, 3] = None
        return scope.rows, memo, self.costs[scope.rows]


MERGED = ((0, 0, 6),)


@pytest.mark.parametrize(
    ("costs", "expected"),
    [
        ({None: Cost(90, 100), (): Cost(80, 100), MERGED: Cost(85, 100)}, ()),
        ({None: Cost(90, 100), (): Cost(80, 100), MERGED: Cost(70, 104)}, MERGED),
        ({None: Cost(90, 100), (): Cost(80, 200), MERGED: Cost(70, 200)}, None),
        ({None: Cost(90, 100), (): Cost(95, 90), MERGED: Cost(91, 90)}, None),
        ({None: Cost(90, 100), (): Cost(95, 90), MERGED: Cost(85, 90)}, MERGED),
    ],
)
def test_the_smallest_program_that_takes_no_longer_is_chosen(costs, expected):
    assert smallest(Lowerings(costs), FLIGHT) == expected


def sparse(m, p):
    """Products of matrices with dense blocks, ones and zeros: from the left, and transposed."""
    left = jnp.eye(9).at[:3, 1:7].set(m[:3, :6]).at[3:6, 4:7].set(m[:3, 6:])
    return left @ p, p @ left.T, left @ p @ left.T


def scaled(m, p):
    """Product with a diagonal matrix."""
    return jnp.diag(m[0]) @ p, p @ jnp.diag(m[1])


@pytest.mark.parametrize("function", [sparse, scaled])
def test_products_of_blocks_are_those_of_jax(function, module_at, tmp_path):
    results_of = module_at(Path(__file__).with_name("compiled.py")).results_of
    arguments = {name: RANDOM.normal(size=(RUNS, 9, 9)) for name in ("m", "p")}
    results = results_of(function.__name__, [function], arguments, tmp_path)
    expected = jax.vmap(function)(*map(jnp.asarray, arguments.values()))
    for one, other in zip(results[function][1], expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-13)


def test_a_block_is_summed_by_a_loop():
    # 27 products of elements in each row or column if they were written out
    assert products_of(sparse, **{name: np.ones((1, 9, 9)) for name in ("m", "p")}) < 15


def twice(x):
    """The same product and root twice, and once with its factors exchanged."""
    return jnp.sqrt(x[0] * x[1]) + x[2], jnp.sqrt(x[1] * x[0]) - x[2]


def test_equal_operations_are_one():
    (function,) = module_of(twice, x=np.ones((1, 3))).functions
    operations = [s.operation for s in statements(function.body) if isinstance(s, Assign)]
    assert sorted(operations) == ["add", "mul", "sqrt", "sub"]


def test_a_line_of_python_is_in_its_first_comment_only():
    def inner(x):
        return jnp.sin(x) * x

    def outer(x):
        y = inner(x)
        z = jnp.cos(y)
        return inner(z)

    source = module_of(outer, x=np.ones(1)).source
    line = "return jnp.sin(x) * x"
    assert source.count(line) == 1
    assert len(re.findall(r"/\* \S*test_row_loops.py:\d+ \*/", source)) == 1
    named = {each.source for each in tokens(source) if each.text == "sin"}
    assert len(named) == 1
    assert named.pop().endswith(line)
