"""Whole numbers, logical ones and keys in lanes, where XLA wraps, saturates or orders them."""

import numpy as np
import pytest

from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

RUNS = 11
RANDOM = np.random.default_rng(5)
REAL = RANDOM.standard_normal(RUNS)
SIGNED = RANDOM.integers(-5, 6, RUNS)
WORDS = RANDOM.integers(0, 2**32, RUNS).astype(np.uint32)
LONG = RANDOM.integers(0, 2**63, RUNS).astype(np.uint64) * 2 + 1
FLAGS = RANDOM.random((RUNS, 5)) > 0.5
BEYOND = np.array([1e12, -3.0, np.nan, np.inf, 2.5, -np.inf, 1e25, 9.3e18, 0.0, 1e19, 3e9])


def scan_of_70(x):
    return jax.lax.scan(lambda c, _: (c + 1.0, c), x, None, length=70)[1]


def words(leaf):
    key = jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)
    return np.asarray(jax.random.key_data(leaf) if key else leaf)


CASES = [
    (lambda f: (f[0] < f[1], f[0] >= f[2], jnp.argmax(f), jnp.argmin(f)), (FLAGS,)),
    (lambda f: (jnp.sort(f), jnp.maximum(f[0], f[1]), jnp.minimum(f[0], f[1])), (FLAGS,)),
    (lambda f: (f < jnp.array(True), jnp.array(False) < f), (FLAGS,)),
    (lambda a, b: ((a - b) >> 1, (a * b) >> 3, (a << 20) >> 20), (WORDS, WORDS[::-1])),
    (lambda a: ((-a).astype(float), jnp.sum(jnp.stack([a, a])).astype(float)), (WORDS,)),
    (lambda a: (a.astype(jnp.int32) < 0, a.astype(jnp.int64)), (WORDS,)),
    (lambda k: ((k * k).astype(float), (k + k) < 0), ((SIGNED * 400_000_000).astype("i4"),)),
    (lambda k: k.astype(jnp.int32).astype(float), (SIGNED * 2**31 + 7,)),
    (lambda x: x.astype(jnp.int32), (BEYOND,)),
    (lambda x: x.astype(jnp.uint32), (BEYOND,)),
    (lambda x: x.astype(jnp.uint64), (BEYOND,)),
    (lambda f: f.astype(jnp.uint32) + jnp.uint32(1), (FLAGS,)),
    (lambda k: jax.lax.shift_right_logical(k, 3), (SIGNED,)),
    (lambda k: jax.lax.shift_right_logical(k, 10 * k), (SIGNED.astype("i4"),)),
    (lambda a: (jnp.maximum(a, jnp.uint64(2**63)), jnp.minimum(a, jnp.uint64(7))), (LONG,)),
    (lambda k: k + jax.lax.add(jnp.int64(2**63 - 1), jnp.int64(1)), (SIGNED,)),
    (lambda a: jax.lax.bitcast_convert_type(a, jnp.int32) < 0, (WORDS,)),
    (lambda k: jax.random.uniform(jax.random.key(k)), (SIGNED.astype(np.int32),)),
    (lambda x: (scan_of_70(x), scan_of_70(x)), (REAL,)),
    (lambda x: (lambda rows: (rows, rows))(scan_of_70(x)), (REAL,)),
]


GIVEN = tuple(arguments for _, arguments in CASES)


def every(*each):
    return [function(*own) for (function, _), own in zip(CASES, each, strict=True)]


@pytest.fixture(scope="module")
def found(flags):
    """Results of all cases, of one program."""
    return lanes(every, (True,) * len(CASES), GIVEN, more_flags=flags)(*GIVEN)


@pytest.fixture(scope="module")
def of_xla():
    """The same by JAX, of one program too."""
    return jax.jit(jax.vmap(every))(*GIVEN)


@pytest.mark.parametrize("case", range(len(CASES)))
def test_numbers_are_those_of_xla(found, of_xla, case):
    expected = jax.tree.leaves(of_xla[case])
    for ours, theirs in zip(jax.tree.leaves(found[case]), expected, strict=True):
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs)


def test_what_is_one_for_all_runs_is_converted_alike():
    def function(x, shared, word, whole):
        bits = jax.lax.bitcast_convert_type(shared, jnp.int64)
        return (
            x + bits,
            x + ((word - jnp.uint32(9)) >> 1),
            x + jax.lax.shift_right_logical(whole, 3),
            x + (shared * 1e19).astype(jnp.uint64),
            x + whole.astype(jnp.int32),
            x + jnp.maximum(word, jnp.uint32(4)),
        )

    shared = (np.float64(1.5), np.uint32(3), np.int64(-(2**40) - 5))
    expected = jax.jit(jax.vmap(function, (0, None, None, None)))(REAL, *shared)
    found = lanes(function, (True, False, False, False), (REAL, *shared))(REAL, *shared)
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_keys_go_in_and_come_out():
    fixed = jax.random.key(5)

    def function(key):
        own = jax.random.fold_in(fixed, 2)
        return key, jax.random.split(key, 3), jax.random.uniform(own), own

    keys = jax.random.split(jax.random.key(0), RUNS)
    found = lanes(function, (True,), (keys,))(keys)
    for ours, theirs in zip(found, jax.jit(jax.vmap(function))(keys), strict=True):
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(words(ours), words(theirs))


@pytest.mark.parametrize(
    ("function", "argument", "found"),
    [
        (jax.random.uniform, jax.random.split(jax.random.key(0, impl="rbg"), 2), "key<rbg>"),
        (lambda x: jax.lax.bitcast_convert_type(x, jnp.uint32), REAL, "float64 as uint32"),
        (lambda x: jax.lax.reduce_precision(x, 8, 23), REAL, "reduce_precision"),
        (lambda x: jax.lax.cond(x > 0.0, scan_of_70, lambda _: jnp.zeros(70), x), REAL, "rows"),
        (lambda x: jax.lax.map(lambda y: scan_of_70(x + y), jnp.zeros(3)), REAL, "rows of a scan"),
    ],
)
def test_what_would_be_another_number_is_refused(function, argument, found):
    with pytest.raises(InputError, match=found):
        lanes(function, (True,), (argument,))


def test_random_bits_of_another_kind_are_refused():
    keys = jax.random.split(jax.random.key(0), RUNS)
    with (
        jax.threefry_partitionable(False),
        pytest.raises(InputError, match="random bits of another kind"),
    ):
        lanes(lambda key: jax.random.uniform(key, (3,)), (True,), (keys,))


def test_arguments_are_those_it_was_compiled_for():
    program = lanes(lambda s, x: jnp.sum(s) * x, (False, True), (np.ones(3), REAL))
    for arguments in (
        (np.ones(2), REAL),
        (np.ones(4), REAL),
        (np.ones(3), REAL[:, None]),
        (np.ones(3), REAL > 0.0),
        (np.ones(3), 1.0),
        (np.ones(3, complex), REAL),
    ):
        with pytest.raises(InputError, match="which this was compiled for"):
            program(*arguments)
    np.testing.assert_array_equal(program(np.arange(3), SIGNED), 3.0 * SIGNED)
    assert program(np.ones(3), REAL[:0]).shape == (0,)


def test_runs_are_counted():
    program = lanes(lambda x, y: (x + y, scan_of_70(x)), (True, True), (REAL, REAL))
    with pytest.raises(InputError, match="runs: found 11, 10"):
        program(REAL, REAL[1:])
    for asked in ([-1], [RUNS]):
        with pytest.raises(InputError, match="asked"):
            program(REAL, REAL, asked=asked)
    with pytest.raises(InputError, match="own"):
        lanes(lambda x: x, (False,), (1.0,))


def test_shared_bits_are_shifted_out():
    def program(bits, by, other):
        return bits << by, bits >> by, other + (bits >> np.uint64(3)) + (bits << np.uint64(3))

    given = np.uint64(2**63 + 7), np.uint64(70), np.arange(5, dtype=np.uint64)
    left, right, moved = lanes(program, (False, False, True), given)(*given)
    np.testing.assert_array_equal(np.concatenate([left, right]), 0)
    np.testing.assert_array_equal(moved, 2**60 + 56 + given[2])
