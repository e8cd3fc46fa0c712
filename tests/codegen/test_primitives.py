"""What JAX computes, SIMD lanes of both widths, flight C and NumPy compute too.

Indices are within 32 bits: JAX cuts longer ones off, flight C does not.
"""

import platform
from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen.evaluation import evaluated
from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.jax64 import jax, jnp

if compiler() is None:
    pytest.skip("needs a C compiler", allow_module_level=True)

RUNS = 37
RANDOM = np.random.default_rng(2)
VECTOR, MATRIX = RANDOM.standard_normal((RUNS, 3)), RANDOM.standard_normal((RUNS, 2, 3))
MATRIX[3, 1, 2] = MATRIX[3, 0, 2] = VECTOR[5, 1] = np.nan
INDEX = RANDOM.integers(-5, 6, RUNS)
COUNT = np.append(RANDOM.integers(-9, 10, RUNS - 2), [-(2**63), 2**62])
MANY = RANDOM.standard_normal(61)
INSTRUCTIONS = [()]
if platform.machine() in ("x86_64", "AMD64"):
    INSTRUCTIONS.append(("-mno-avx512f",))


def replaced(x, m, k, n):
    """`.at`, at places that are known and at computed ones, within the array and beyond it."""
    return (
        x.at[2].set(0.0),
        x.at[k].set(7.0),
        x.at[jnp.array([0, 2])].add(x[:2]),
        x.at[jnp.stack([k, n % 9, k])].multiply(2.0),
        x.at[k].min(-0.2),
        x.at[k].max(n * 1.0),
        x.at[k].set(3.0, mode="clip"),
        x.at[1].apply(jnp.exp),
        m.at[1].set(x),
        m.at[:, 2].set(0.0),
        m.at[k].add(x),
        m.at[:, k].set(m[0, :2]),
        m.at[k, n % 9].set(5.0),
        m.at[k % 2, 1:3].subtract(x[:2]),
        jnp.arange(3).at[k].set(n),
        (x > 0.0).at[k].set(True),
        jax.lax.dynamic_update_slice(m, m[:1, :2] * 3.0, (k, n % 9)),
        jax.vmap(lambda row, place: row.at[place].set(9.0))(m, jnp.array([0, 2]) + k % 2),
    )


def picked(x, m, k, n):
    """Elements at computed places, within the array and beyond it."""
    return (
        m.ravel(order="F"),
        jnp.reshape(k * m, (m.shape[1], m.shape[0]), order="F") * 2.0,
        jax.lax.reshape(m, (m.size,), dimensions=(1, 0)),
        x[k],
        m[k],
        m[k, n % 9 - 4],
        jnp.take(x, k),
        jnp.take(m, jnp.stack([k, n % 9]), axis=1),
        jnp.take(jnp.arange(3), k, mode="fill"),
        jnp.take(x > 0.0, k, mode="fill"),
        x.at[k].get(mode="fill", fill_value=-1.0),
        jax.vmap(lambda row, place: row[place])(m, jnp.array([0, 2]) + k % 2),
        jax.lax.select_n((k % 3).astype(jnp.int32), x[0], x[1], x[2]),
        jnp.select([k > 2, k > 0, k > -3], [x, 2.0 * x, 3.0 * x]),
        jnp.stack([*x]) + [*m][1],
    )


def ordered(x, m, k, n):
    """The largest, sorted arrays with what belongs to them, running sums."""
    wide = jnp.outer(x, MANY)
    return (
        jnp.sort(m, axis=0),
        jnp.argsort(x),
        jnp.argsort(jnp.round(m)),
        jax.lax.sort((jnp.round(x), x), num_keys=1)[1],
        jnp.argmax(m, axis=1),
        jnp.argmax(m > 0.5, axis=1),
        jnp.argmin(m > 0.5, axis=1),
        jnp.argmin(m),
        jnp.argmax(wide, axis=1),
        jnp.argmin(wide, axis=0),
        jnp.argmin(jnp.round(wide)),
        jnp.argmax(jnp.where(wide > 0.5, jnp.nan, wide), axis=1),
        jnp.argmax(jnp.clip(10.0 * wide, -1e3, 1e3).astype(int)),
        jnp.median(jnp.nan_to_num(x)),
        jnp.cumsum(x),
        jnp.cumprod(m, axis=0),
        jax.lax.cummax(x, reverse=True),
        jax.lax.cummin(jnp.arange(3) * k),
    )


def whole(x, m, k, n):
    """Whole numbers: divided as in C and as in Python, bit by bit, made of real ones."""
    return (
        jax.lax.div(n, k),
        jax.lax.rem(n, k),
        n // 3,
        n % 4,
        n % k,
        abs(k),
        jnp.sign(k),
        jnp.maximum(k, n),
        jnp.minimum(k, 2),
        jnp.clip(n, -3, 3),
        jnp.max(jnp.stack([k, n, 1])),
        (k & 6) | (n ^ 3),
        ~k,
        k << 3,
        jax.lax.shift_right_logical(n, 5),
        (1e3 * x).astype(int),
        (1e19 * x).astype(int),
        (1e10 * x).astype(jnp.int32),
        k.astype(bool),
        jnp.maximum(k > 0, n > 0),
        jnp.any(jnp.stack([k, n]) == 3),
    )


def elementary(x, m, k, n):
    """Functions that C has and lanes take one by one; tolerated to rounding."""
    return (
        jnp.arcsinh(x),
        jnp.arccosh(1.0 + x * x),
        jnp.arctanh(0.1 * x),
        jax.scipy.special.erf(x),
        jax.scipy.special.erfc(x),
        jnp.power(jnp.nan_to_num(x), k % 3),
        jax.lax.reduce_precision(x, 11, 52),
    )


def composed(x, m, k, n):
    """Functions that some versions of JAX have as one primitive and others as several."""
    carried, rows = jax.lax.scan(
        lambda c, row: ((c[0] + row * x[0], c[1] + 1), row * c[1]), (x[1], k), m[1]
    )
    return (
        *carried,
        rows,
        jnp.log2(1.0 + x * x),
        jnp.arccos(jnp.clip(x, -1.0, 1.0)),
        jnp.arcsin(jnp.clip(x, -1.0, 1.0)),
        jnp.polyval(jnp.array([0.5, -1.0, 2.0]), x),
        jnp.hypot(x[0], m[1]),
        jnp.einsum("ij,j->i", m, x),
        jnp.nonzero(m[0] > 0.0, size=2, fill_value=-1)[0],
    )


def searched(x, m, k, n):
    """Tables, filters and bits."""
    grid = jnp.array([-1.0, -0.2, 0.3, 1.1])
    return (
        jnp.searchsorted(grid, x),
        jnp.searchsorted(grid, m, side="right"),
        jnp.digitize(x, grid),
        jnp.interp(x, grid, grid**2),
        jnp.interp(m[0], grid, grid**3, left=-7.0, right=jnp.nan),
        # a batch of JAX adds NaN times 0 of other runs
        jnp.convolve(jnp.nan_to_num(x), jnp.nan_to_num(m[0])),
        jnp.convolve(jnp.nan_to_num(m[1]), jnp.nan_to_num(x[:2]), mode="same"),
        jnp.correlate(jnp.nan_to_num(x), m[0], mode="valid"),
        jax.lax.cumlogsumexp(m[1], reverse=True),
        jax.grad(jax.checkpoint(lambda x: jnp.sum(jnp.sin(x) ** 2)))(x),
        n >> 3,
        (k.astype(jnp.uint32) + 0).astype(jnp.int32),
        (jnp.maximum(n, 0) % 2**32).astype(jnp.uint32).astype(jnp.int32) // 2,
        jax.lax.conv_general_dilated(
            jnp.nan_to_num(m)[:, None], jnp.ones((1, 1, 2)), (1,), [(-1, 1)]
        ),
        n >> jnp.array([0, 1, 61, 62, 63]),
        jnp.roll(x, k),
    )


CASES = [replaced, picked, ordered, whole, elementary, composed, searched]
ARGUMENTS = (VECTOR, MATRIX, INDEX, COUNT)


def alike(found, expected):
    assert len(found) == len(expected)
    for number, (ours, theirs) in enumerate(zip(found, expected, strict=True)):
        np.testing.assert_allclose(ours, theirs, rtol=2e-15, atol=1e-15, err_msg=str(number))


@pytest.fixture(scope="module")
def expected():
    """By JAX, all in one program."""

    def every(*arguments):
        return [function(*arguments) for function in CASES]

    found = jax.jit(jax.vmap(every))(*ARGUMENTS)
    return dict(zip(CASES, jax.tree.map(np.asarray, found), strict=True))


@pytest.fixture(
    scope="module", params=INSTRUCTIONS, ids=["all lanes", "four lanes"][: len(INSTRUCTIONS)]
)
def in_lanes(request):
    def every(*arguments):
        return [function(*arguments) for function in CASES]

    program = lanes(every, (True,) * 4, ARGUMENTS, more_flags=request.param)
    return dict(zip(CASES, program(*ARGUMENTS), strict=True))


@pytest.fixture(scope="module")
def in_flight(module_at, tmp_path_factory):
    compiled = module_at(Path(__file__).with_name("compiled.py"))
    arguments = dict(zip(("x", "m", "first", "second"), ARGUMENTS, strict=True))
    folder = tmp_path_factory.mktemp("primitives")
    found = compiled.results_of("primitives", CASES, arguments, folder)
    assert not any(status.any() for status, _ in found.values())
    return {function: results for function, (_, results) in found.items()}


@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_lanes_are_as_jax(function, in_lanes, expected):
    alike(in_lanes[function], expected[function])


@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_flight_c_is_as_jax(function, in_flight, expected):
    alike(in_flight[function], expected[function])


@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_numpy_evaluates_as_jax(function, expected):
    for run in range(RUNS):
        found = evaluated(function)(*(rows[run] for rows in ARGUMENTS))
        alike(found, [rows[run] for rows in expected[function]])
