"""Functions and random numbers in lanes, against NumPy, SciPy and JAX."""

import platform

import numpy as np
import pytest
from scipy.special import erfinv

from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.jax64 import jax, jnp

COUNT = 20_000
SPECIAL = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 1.0, -1.0, 1e-320, 5e-310, -1e308, 720.0])
# what lanes.h states, and half a unit for NumPy
UNITS = {
    "exp": (np.exp, 1),
    "expm1": (np.expm1, 2),
    "tanh": (np.tanh, 3),
    "log": (np.log, 1),
    "log1p": (np.log1p, 2),
    "sin": (np.sin, 1),
    "cos": (np.cos, 1),
    "arcsin": (np.arcsin, 3),
    "arccos": (np.arccos, 3),
    "sqrt": (np.sqrt, 0),
    "floor": (np.floor, 0),
    "round": (np.round, 0),
    "tan": (np.tan, 1),
    "abs": (np.abs, 0),
}


def wide_range(seed, low=-8.0, high=3.0):
    random = np.random.default_rng(seed)
    return random.standard_normal(COUNT) * 10.0 ** random.uniform(low, high, COUNT)


def normal(x):
    """Numbers as the processor takes them in lanes: those too small to be normal are zero."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return x
    return np.where(np.abs(x) < np.finfo(float).tiny, np.copysign(0.0, x), x)


def units_apart(found, expected):
    with np.errstate(all="ignore"):
        apart = np.abs(found - expected) / np.spacing(np.abs(expected))
    alike = (found == expected) | (np.isnan(found) & np.isnan(expected))
    apart = np.where(alike, 0.0, apart)
    assert not np.isnan(apart).any()
    return apart.max()


@pytest.fixture(scope="module")
def elementary(flags):
    """All of them in one program: name -> results, of special numbers and a wide range."""
    names = list(UNITS)

    def every(x):
        return tuple(getattr(jnp, name)(x) for name in names)

    program = lanes(every, (True,), (SPECIAL,), more_flags=flags)
    given = np.concatenate([SPECIAL, wide_range(1), np.random.default_rng(2).uniform(-1, 1, COUNT)])
    return given, dict(zip(names, program(given), strict=True))


@pytest.mark.parametrize("name", UNITS)
def test_elementary_functions_keep_to_their_bounds(elementary, name):
    given, found = elementary
    function, bound = UNITS[name]
    with np.errstate(all="ignore"):
        expected = normal(function(normal(given)))
    assert units_apart(normal(found[name]), expected) <= bound + 1
    numbers = ~np.isnan(expected) & (expected != 0.0)
    np.testing.assert_array_equal(np.signbit(found[name][numbers]), np.signbit(expected[numbers]))


def test_the_angle_of_two_numbers(flags):
    program = lanes(jnp.arctan2, (True, True), (SPECIAL, SPECIAL), more_flags=flags)
    y, x = (each.ravel() for each in np.meshgrid(SPECIAL, SPECIAL))
    y, x = np.append(y, wide_range(3)), np.append(x, wide_range(4, -3.0))
    found, expected = program(y, x), normal(np.arctan2(normal(y), normal(x)))
    assert units_apart(found, expected) <= 4
    np.testing.assert_array_equal(np.signbit(found), np.signbit(expected))


def test_angles_beyond_the_fast_range(flags):
    program = lanes(lambda x: (jnp.sin(x), jnp.cos(x)), (True,), (SPECIAL,), more_flags=flags)
    given = wide_range(5, 4.0, 12.0)
    for found, function in zip(program(given), (np.sin, np.cos), strict=True):
        assert units_apart(found, function(given)) <= 2


def test_the_inverse_error_function(flags):
    program = lanes(jax.scipy.special.erfinv, (True,), (SPECIAL,), more_flags=flags)
    given = np.random.default_rng(6).uniform(-1.0, 1.0, COUNT)
    np.testing.assert_allclose(program(given), erfinv(given), rtol=1e-12, atol=0)
    # towards 1 the error of x² counts, in XLA alike
    tail = 1.0 - np.logspace(-15, -1, 1000)
    np.testing.assert_allclose(
        program(tail), jax.scipy.special.erfinv(jnp.asarray(tail)), rtol=2e-14, atol=0
    )
    np.testing.assert_array_equal(program(np.array([1.0, -1.0, 2.0])), [np.inf, -np.inf, np.nan])


def test_random_numbers_are_those_of_jax():
    def draws(key, k):
        of_seed = jax.random.bits(jax.random.key(k - 9), dtype=jnp.uint64)
        bits, uniform, normal = jax.random.split(jax.random.fold_in(key, k), 3)
        return (
            jax.random.bits(bits, (3,), dtype=jnp.uint64),
            jax.random.uniform(uniform, (2, 2), minval=-1.0),
            jax.random.normal(normal),
            of_seed ^ jax.random.bits(jax.random.key(5), dtype=jnp.uint64),
        )

    keys = jax.random.split(jax.random.key(3), 501)
    expected = jax.jit(jax.vmap(draws, (0, None)))(keys, 7)
    bits, uniform, normal, seeds = lanes(draws, (True, False), (keys, 7))(keys, 7)
    np.testing.assert_array_equal(bits, expected[0])
    np.testing.assert_array_equal(uniform, expected[1])
    np.testing.assert_array_equal(seeds, expected[3])
    np.testing.assert_allclose(normal, expected[2], rtol=2e-14, atol=1e-15)
