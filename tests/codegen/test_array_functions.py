"""Order, search, indices and whole numbers of arrays in flight C and SIMD lanes, as JAX has them.

Results are compared exactly, signs of zeros included: nothing here rounds but cumulative sums and
interpolation, whose operations XLA may fuse.
"""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.jax64 import jax, jnp

RUNS, SIZE = 40, 4
RANDOM = np.random.default_rng(11)
REAL = RANDOM.standard_normal((RUNS, SIZE))
SPECIAL = np.array([0.0, -0.0, np.nan, np.inf, -np.inf, 1.0, -1.0, 1e-300])
REAL[:20] = RANDOM.choice(SPECIAL, (20, SIZE))
GRID = np.sort(RANDOM.integers(-3, 4, (RUNS, SIZE)).astype(float), axis=1)
WHOLE = RANDOM.integers(-8, 9, (RUNS, SIZE))
HALF = RANDOM.integers(-(2**31), 2**31, (RUNS, SIZE)).astype(np.int32)
INDEX = RANDOM.integers(-9, 10, RUNS)


def ordered(x, grid, whole, half, at):
    """Sorting and selection, also of equal elements, zeros of both signs and NaN."""
    return (
        *jax.lax.top_k(x, SIZE),
        *jax.lax.top_k(half, 2),
        *jax.lax.top_k(jnp.stack([x, grid]), 2),
        jax.lax.top_k(whole > 0, 3)[1],
        jnp.argsort(x),
        jnp.argsort(whole, descending=True),
        jnp.argsort(jnp.stack([grid, x]), axis=0),
        jnp.sort(x),
        jnp.lexsort((x, grid, whole)),
        *sorted_in_loops(jnp.concatenate([x, grid, -x, 2.0 * grid, x, grid]), whole),
    )


def sorted_in_loops(many, whole):
    """Arrays whose sorting is not written out."""
    rows = jnp.reshape(many, (2, 4, 3))
    return (
        jnp.sort(many),
        jnp.argsort(many[1:]),
        jnp.lexsort((many, jnp.tile(whole, 6))),
        jnp.argsort(jnp.concatenate([rows, rows[::-1], rows], axis=1), axis=1),
        jnp.sort(jnp.reshape(jnp.tile(many, 6), (72, 2))),
    )


def indexed(x, grid, whole, half, at):
    """Elements at computed indices, also beyond the array."""
    inside = jnp.clip(whole, 0, SIZE - 1)
    return (
        x[at],
        x[whole],
        x.at[at].set(2.0),
        x.at[at].get(mode="fill", fill_value=-7.0),
        whole.at[inside].add(1),
        whole.at[inside].max(3),
        jnp.take(x, whole, mode="wrap"),
        jnp.take(grid, half, mode="clip"),
        jnp.take_along_axis(jnp.outer(grid, grid), inside[:, None], 1),
        jax.lax.dynamic_slice(x, (at,), (2,)),
        jax.lax.dynamic_update_slice(x, grid[:3], (at,)),
        jnp.roll(x, at),
        jnp.roll(jnp.outer(grid, grid), (at, 2), (0, 1)),
        jnp.searchsorted(grid, x),
        jnp.searchsorted(grid, x, side="right", method="sort"),
        jnp.searchsorted(grid, grid, method="compare_all"),
        jnp.searchsorted(jnp.sort(whole), at),
        jnp.bincount(inside, length=SIZE),
        jax.ops.segment_sum(grid, inside, 4),
        jnp.nonzero(whole > 0, size=3, fill_value=-1)[0],
    )


def whole_numbers(x, grid, whole, half, at):
    """Integers wrap around at their size; bits of real numbers."""
    narrow = at.astype(jnp.int32)
    return (
        half * half,
        half + half,
        half - jnp.int32(2**31 - 1),
        -half,
        jnp.abs(half),
        half << 3,
        half >> jnp.abs(narrow),
        jax.lax.shift_right_logical(half, narrow),
        half @ half,
        whole @ whole,
        jnp.cumsum(half, dtype=jnp.int32),
        jnp.prod(half, dtype=jnp.int32),
        (whole << 29).astype(jnp.int32),
        half // jnp.where(narrow == 0, 3, narrow),
        half % jnp.where(narrow == 0, 3, narrow),
        jnp.signbit(x),
        jnp.copysign(grid, x),
        jnp.nextafter(x, grid),
        *jnp.frexp(x),
        jax.lax.bitcast_convert_type(half, jnp.uint32),
        *random_words(half.astype(jnp.uint32)),
        *halved(narrow),
        *jax.vmap(halved)(whole),
    )


def random_words(word):
    """Generators of Lehmer and Marsaglia, powers and sums of products, by 32 bits."""
    word = word ^ (word << jnp.uint32(13))
    word = word ^ (word >> jnp.uint32(17))
    lehmer = word * jnp.uint32(1664525) + jnp.uint32(1013904223)
    products = (function(word, dtype=jnp.uint32) for function in (jnp.prod, jnp.cumprod))
    return word, lehmer, word**3, word @ lehmer, *products


def halved(number):
    """Odd part of a number and its factors of two, at most nine of them."""

    def test(state):
        return (state[0] % 2 == 0) & (state[1] < 9)

    def step(state):
        return state[0] // 2, state[1] + jnp.int32(1)

    return jax.lax.while_loop(test, step, (number, jnp.int32(0)))


def rounded(x, grid, whole, half, at):
    """What may differ in the last digits."""
    return (
        jnp.cumsum(grid),
        jnp.cumprod(grid + 0.5),
        jax.lax.cummax(grid, reverse=True),
        jnp.interp(grid[:2] + 0.3, jnp.arange(SIZE) - 2.0, grid),
        jnp.interp(2.0 * grid, jnp.arange(SIZE) - 2.0, grid, left=-1.0, right=7.0),
        jnp.interp(grid, jnp.arange(SIZE) - 2.0, grid, period=4.0),
        jax.grad(lambda place: jnp.interp(place, jnp.arange(SIZE) - 2.0, grid))(grid[0] + 0.3),
        jax.grad(lambda row: jnp.sum(jax.lax.top_k(row, 2)[0] ** 2))(grid),
        jax.grad(lambda row: jnp.sum(row[whole] ** 2))(grid),
    )


CASES = [ordered, indexed, whole_numbers, rounded]
ARGUMENTS = REAL, GRID, WHOLE, HALF, INDEX


def every(*arguments):
    return [function(*arguments) for function in CASES]


@pytest.fixture(scope="module")
def expected():
    results = jax.jit(jax.vmap(every))(*ARGUMENTS)
    return dict(zip(CASES, [[np.asarray(each) for each in case] for case in results], strict=True))


@pytest.fixture(scope="module")
def in_lanes():
    if compiler() is None:
        pytest.skip("needs a C compiler")
    results = lanes(every, (True,) * len(ARGUMENTS), ARGUMENTS)(*ARGUMENTS)
    return dict(zip(CASES, results, strict=True))


@pytest.fixture(scope="module")
def in_flight(module_at, tmp_path_factory):
    results_of = module_at(Path(__file__).with_name("compiled.py")).results_of
    arguments = dict(zip(("x", "grid", "whole", "half", "at"), ARGUMENTS, strict=True))
    found = results_of("arrays", CASES, arguments, tmp_path_factory.mktemp("arrays"))
    assert not any(status.any() for status, _ in found.values())
    return {function: results for function, (_, results) in found.items()}


@pytest.mark.parametrize("writer", ["in_lanes", "in_flight"])
@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_results_are_those_of_jax(function, writer, expected, request):
    found = request.getfixturevalue(writer)[function]
    for number, (ours, theirs) in enumerate(zip(found, expected[function], strict=True)):
        if function is rounded:
            np.testing.assert_allclose(ours, theirs, 1e-14, 1e-14, err_msg=str(number))
            continue
        np.testing.assert_array_equal(ours, theirs, err_msg=str(number))
        signed = ~np.isnan(np.asarray(theirs, float))
        signs = (np.signbit(np.asarray(each, float))[signed] for each in (ours, theirs))
        np.testing.assert_array_equal(*signs, err_msg=str(number))


def test_sorting_of_many_elements_is_a_loop():
    sources = [
        emit("order", [Entry("order", jnp.sort, {"x": np.zeros(size)}, ("y",))]).source
        for size in (16, 201)
    ]
    assert len(sources[1]) < len(sources[0]) + 50 < 2500
