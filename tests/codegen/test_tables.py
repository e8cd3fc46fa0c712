"""Large inputs stay in memory and are read by each lane, as the same function under `vmap` does."""

import numpy as np
import pytest

from gyrostat.codegen.simd.batch import lanes, traced
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment, OrbitSamples

# Optimised, XLA joins a product and a sum into one instruction, as the compiler of C does.
pytestmark = pytest.mark.optimised
RUNS, ROWS = 13, 20
RANDOM = np.random.default_rng(5)
TABLE = RANDOM.standard_normal((ROWS, 4, 3))
ROW = np.append(RANDOM.integers(-4, ROWS + 4, RUNS - 2), [0, ROWS - 1])
VIEWS = [
    lambda x: x,
    lambda x: x.transpose(2, 0, 1),
    lambda x: x[::2, :, 1:],
    lambda x: x[::-1],
    lambda x: x.reshape(-1, 6),
    lambda x: x[:, None, 2:],
    lambda x: x.transpose(1, 0, 2).reshape(4, -1),  # its last axis has no constant stride
    lambda x: jnp.stack([x]),
]


def matches(function, own, *arguments, flags=()):
    """Whether all results in lanes are those of `vmap`, bit by bit."""
    every = jax.jit(jax.vmap(function, tuple(0 if each else None for each in own)))
    expected = every(*arguments)
    found = lanes(function, own, arguments, more_flags=flags)(*arguments)
    for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs)
    return True


def random_reads(seed, count):
    """A function of a table and an index: reads of random parts of views of the table."""
    random = np.random.default_rng(seed)
    plan = [(k % len(VIEWS), int(random.integers(4)), seed + k) for k in range(count)]

    def read(view, kind, k, random):
        axis = int(random.integers(view.ndim))
        start = [k * int(random.integers(-1, 3)) + int(random.integers(-2, 3)) for _ in view.shape]
        # some starts are known beforehand
        start = [s if random.random() < 0.6 else int(random.integers(0, 3)) for s in start]
        if kind == 0:
            size = [int(random.integers(1, min(n, 3) + 1)) for n in view.shape]
            return jax.lax.dynamic_slice(view, start, size)
        mode = ("clip", "fill")[int(random.integers(2))]
        if kind == 1:
            return jnp.take(view, jnp.stack([k, 2 - k]), axis=axis, mode=mode).reshape(-1)[::7]
        if kind == 2:
            return view.at[(*start[:-1], jnp.array([0, 2]))].get(mode=mode)
        return view[tuple(start)]

    def function(table, k):
        return [
            read(VIEWS[view](jnp.asarray(table)), kind, k, np.random.default_rng(each))
            for view, kind, each in plan
        ]

    return function


def test_random_reads_of_tables_that_runs_share_and_of_their_own(flags):
    def function(shared, own, k):
        return random_reads(3, 8)(shared, k), random_reads(30, 4)(own, k)

    own = RANDOM.standard_normal((RUNS, *TABLE.shape))
    assert matches(function, (False, True, True), TABLE, own, ROW, flags=flags)


def test_tables_pass_through_loops_branches_and_functions():
    def function(table, words, k):
        table, words = jnp.asarray(table), jnp.asarray(words)
        last = jax.jit(lambda x, i: x[i, 0, 1])
        sums = jax.lax.fori_loop(0, 5, lambda i, c: c + table[i + k, 1], jnp.zeros(3))
        rows = jax.lax.scan(lambda c, row: (c + row[2, 0], row[0, k]), 0.0, table, reverse=True)
        turns = jax.lax.while_loop(lambda c: table[c, 0, 0] < 1.0, lambda c: c + 1, k)
        flat = jax.lax.scan(lambda c, word: (c ^ word, None), jnp.uint32(0), words[::-1])[0]
        chosen = jax.lax.cond(k > 9, lambda x: x[k, 0], lambda x: x[3, 1], table)
        return (
            sums,
            rows,
            turns,
            flat,
            chosen,
            last(table, k),
            words[k],
            table[0, 0],
            table.shape[0],
        )

    table = np.array(TABLE)
    table[-1] = 2.0  # ends the loop
    words = RANDOM.integers(0, 2**32, 90).astype(np.uint32)
    assert matches(function, (False, False, True), table, words, ROW)


def orbit(rows):
    samples = OrbitSamples(
        *RANDOM.standard_normal((4, rows, 3)), np.ones(rows), RANDOM.standard_normal((rows, 4))
    )
    return OrbitEnvironment.of(10.0, samples, 5400.0)


def test_the_program_does_not_grow_with_the_table_and_reads_a_value_once():
    def function(orbit, time):
        return orbit.field(time), 2.0 * orbit.field(time), orbit.position(time), orbit.field(time)

    long, short = (
        traced(function, (False, True), (orbit(rows), np.zeros(RUNS))).text for rows in (3000, 200)
    )
    assert len(long.splitlines()) == len(short.splitlines())
    assert long.count("shared_words(") == 4 * 6
    # one read for all lanes if the time is the same for all runs
    shared = traced(
        lambda orbit, time, x: x + orbit.field(time),
        (False, False, True),
        (orbit(200), 0.0, np.zeros(3)),
    )
    assert "shared_words(" not in shared.text


def test_an_environment_along_an_orbit_in_both_engines():
    times = np.append(RANDOM.uniform(-10.0, 2500.0, RUNS), [0.0, 2000.0, 1e9])
    assert matches(
        lambda orbit, t: (orbit.sun(t), orbit.velocity(t)), (False, True), orbit(200), times
    )


def test_arithmetic_on_a_large_table_is_refused():
    def function(table, x):
        return jnp.sum(2.0 * table) + x

    with pytest.raises(
        InputError, match=r"test_tables\.py.*3000×2.*expected at most 4096 elements"
    ):
        lanes(function, (False, True), (np.zeros((3000, 2)), np.zeros(3)))
    assert matches(lambda table, x: jnp.sum(table) + x, (False, True), np.arange(100.0), np.ones(3))
