"""Loops, branches and tables in lanes, against the same function under `vmap`."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

# Optimised, XLA joins a product and a sum into one instruction, as the compiler of C does.
pytestmark = pytest.mark.optimised
RUNS = 21
RANDOM = np.random.default_rng(1)


@pytest.fixture
def same(flags):
    """Compares a function in lanes with the same under `vmap`."""

    def compare(function, own, *arguments, tolerance=0.0):
        every = jax.jit(jax.vmap(function, tuple(0 if each else None for each in own)))
        expected = every(*arguments)
        found = lanes(function, own, arguments, more_flags=flags)(*arguments)
        for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
            assert ours.dtype == theirs.dtype
            np.testing.assert_allclose(ours, theirs, rtol=tolerance, atol=tolerance)
        return found

    return compare


def test_loops_end_in_each_lane_at_its_own_pass(same):
    def collatz(start):
        def turn(carry):
            number, count = carry
            odd = number - 2.0 * jnp.floor(number / 2.0) == 1.0
            return jnp.where(odd, 3.0 * number + 1.0, number / 2.0), count + 1

        return jax.lax.while_loop(lambda carry: carry[0] > 1.0, turn, (start, 0))

    starts = np.arange(1.0, RUNS + 1.0)
    _, count = same(collatz, (True,), starts)
    assert count[19 - 1] == 20


def test_a_loop_in_a_branch_runs_for_the_lanes_that_took_it(same):
    def program(x, y):
        def long(z):
            return jax.lax.while_loop(lambda c: c < 100.0, lambda c: 1.5 * c + 1.0, z)

        def short(z):
            # would never end where the branch is not taken
            return jax.lax.while_loop(lambda c: c < 0.0, lambda c: c + y, z)

        return jax.lax.cond(x > 0.0, long, short, x), jax.lax.cond(y > 9.0, long, short, x)

    x = RANDOM.standard_normal(RUNS)
    same(program, (True, False), np.append(x, [-0.0, 0.0]), 0.25)


def test_switches_take_numbers_beyond_their_branches(same):
    branches = [lambda z: z + 1.0, lambda z: -z, lambda z: z * z]

    def program(number, x):
        return jax.lax.switch(number, branches, x)

    same(program, (True, True), RANDOM.integers(-2, 5, RUNS), RANDOM.standard_normal(RUNS))
    same(program, (False, True), 1, RANDOM.standard_normal(RUNS))


def test_elements_are_picked_by_each_lane(same):
    def program(table, own, k):
        return (
            jnp.asarray(table)[k],
            own[k],
            jax.lax.dynamic_slice(own, (k,), (2,)),
            jnp.argmax(own),
        )

    own = RANDOM.standard_normal((RUNS, 5))
    same(program, (False, True, True), np.arange(5.0), own, RANDOM.integers(0, 4, RUNS))


def test_sorting_puts_nan_last(same):
    values = RANDOM.standard_normal((RUNS, 2, 5))
    values[3, 0, 1] = values[4, 1, 0] = np.nan
    found = same(lambda x: jnp.sort(x, axis=1), (True,), values)
    assert np.isnan(found[3, 0, 4])


def test_kinds_of_numbers_become_one_another(same):
    def program(x, k, b):
        return (
            x.astype(int),
            k.astype(float) + b,
            (k != 0) ^ b,
            b.astype(jnp.int32) + 1,
            k.astype(bool),
            jnp.maximum(k, 2) * jnp.minimum(k, 3),
            jnp.sum(jnp.array([k, 1])),
            x > 0,
        )

    x = np.append(RANDOM.standard_normal(RUNS) * 1e3, [np.nan, 1e300, -1e300])
    same(program, (True, True, True), x, np.arange(len(x)) - 4, x > 0.0)


def test_random_programs_are_the_interpreter_bit_by_bit(module_at, tools):
    program = module_at(Path(__file__).with_name("test_random_programs.py")).random_program(3)
    values = RANDOM.choice([0.0, -0.0, 1.0, np.inf, np.nan], (3, 300))
    values = np.where(RANDOM.random(values.shape) < 0.8, RANDOM.standard_normal((3, 300)), values)
    expected = tools.interpret(jax.make_jaxpr(program)(0.0, 0.0, 0.0), list(values))
    compiled = lanes(program, (True,) * 3, values, more_flags=("-ffp-contract=off",))
    for ours, theirs in zip(compiled(*values), expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)
        numbers = ~np.isnan(ours)
        np.testing.assert_array_equal(np.signbit(ours[numbers]), np.signbit(theirs[numbers]))
        assert np.isfinite(ours).mean() > 0.3


def test_what_runs_share_is_one_number(same):
    def program(shared, x, flag):
        gain = jnp.exp(jnp.sum(shared)) + jnp.where(flag, 1.0, jnp.tanh(shared[0]))
        kept = jax.lax.fori_loop(0, 3, lambda k, c: c * shared[1] + k, gain)
        return kept * x, gain

    same(program, (False, True, False), np.array([0.1, -0.3]), np.ones(RUNS), True, tolerance=4e-16)


@pytest.fixture(scope="module")
def walk():
    """A random walk of 100 steps in lanes: where it ends, and on demand the way and each sign."""

    def function(key, start):
        def step(place, k):
            place = place + jax.random.normal(jax.random.fold_in(key, k), (2,))
            return place, (place, place[0] > 0.0)

        last, (way, positive) = jax.lax.scan(step, start, jnp.arange(100))
        return last, way, positive

    keys = jax.random.split(jax.random.key(1), RUNS)
    start = RANDOM.standard_normal((RUNS, 2))
    program = lanes(function, (True, True), (keys, start), on_demand=(False, True, False))
    return function, program, keys, start


def test_rows_of_long_scans(walk):
    function, program, keys, start = walk
    last, way, positive = jax.jit(jax.vmap(function))(keys, start)
    asked = [2, 3, 17]
    found = program(keys, start, asked=asked)
    np.testing.assert_allclose(found[0], last, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(found[1], np.asarray(way)[asked], rtol=1e-13, atol=1e-13)
    np.testing.assert_array_equal(found[2], positive)
    assert program(keys, start)[1].shape == (0, 100, 2)


def test_a_run_does_not_depend_on_its_neighbours(walk):
    _, program, keys, start = walk
    together = program(keys, start, asked=range(RUNS), threads=2)
    for run in (0, 7, 8, RUNS - 1):
        alone = program(keys[run : run + 1], start[run : run + 1], asked=[0])
        for ours, theirs in zip(alone, together, strict=True):
            np.testing.assert_array_equal(ours[0], theirs[run])


def test_rows_are_results_alone():
    def program(x):
        rows = jax.lax.scan(lambda c, _: (c + 1.0, c), x, None, length=100)[1]
        return jnp.sum(rows)

    with pytest.raises(InputError, match=r"test_programs\.py.*rows of a long scan"):
        lanes(program, (True,), (np.zeros(3),))


@pytest.mark.parametrize(
    ("function", "found"),
    [
        (jax.scipy.special.gammaln, "lgamma"),
        (lambda x: x.astype(jnp.float32), "float32"),
        (lambda x: jnp.outer(jnp.arange(100.0), jnp.arange(100.0)) * x[0], "100×100"),
    ],
)
def test_what_lanes_do_not_know_is_refused(function, found):
    with pytest.raises(InputError, match=found):
        lanes(function, (True,), (np.ones((4, 2)),))


def test_rows_of_a_short_scan_on_demand_are_those_of_the_requested_runs():
    def function(start):
        return jax.lax.scan(lambda x, _: (0.5 * x, x), start, None, length=5)

    start = np.arange(10.0)
    end, rows = lanes(function, (True,), (start,), on_demand=(False, True))(start, asked=(7, 2))
    np.testing.assert_array_equal(end, start / 32.0)
    np.testing.assert_array_equal(rows, np.outer([7.0, 2.0], 0.5 ** np.arange(5)))
