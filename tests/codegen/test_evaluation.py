"""Functions evaluated by NumPy give what compiled ones do; see also the tests of primitives."""

import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from threading import Barrier

import equinox as eqx
import numpy as np
import pytest

from gyrostat.codegen.evaluation import _Programs, _Source, evaluated, evaluation
from gyrostat.codegen.numpy_rules import RULES
from gyrostat.core.jax64 import jax, jnp

ROW = np.array([0.3, -1.7, 0.0, -0.0, 1e300, np.inf, -np.inf, np.nan])
COUNTS = np.array([3, -4, 2**62, -(2**63)])
KEY = jax.random.key(5)
SMALL = 0.9 * np.tanh(ROW)


def smooth(x, n):
    functions = (jnp.exp, jnp.expm1, jnp.log, jnp.log1p, jnp.tan, jnp.tanh, jnp.sinh, jnp.cosh)
    more = (jnp.arctan, jax.lax.rsqrt, jnp.sign, jnp.floor, jnp.ceil, jnp.isfinite)
    return (
        *(function(x) for function in (*functions, *more)),
        *(function(0.5 * jnp.tanh(x)) for function in (jnp.arcsin, jnp.arccos)),
        jnp.arctan2(x, x[::-1]),
        jnp.arctan2(x, -0.0),
        jnp.cbrt(jnp.clip(x, -9.0, 9.0)),
        jax.lax.pow(x, 2.5),
        jax.lax.pow(jnp.abs(x), -0.5),
        jax.lax.rem(x, 0.7),
        x**3,
        x**-2,
        jnp.clip(x, -1.0, 1.0),
        jnp.maximum(x, x[::-1]),
        jax.lax.clamp(x[0], x, 2.0),
    )


def moved(x, n):
    m = x.reshape(2, 4)
    return (
        jnp.min(m, axis=0),
        jnp.max(x),
        jnp.prod(m, axis=1),
        jnp.sum(m),
        jnp.all(m == m, axis=1),
        jnp.any(m > 1e9, axis=0),
        jnp.argmax(x),
        jnp.argmin(m, axis=1),
        m.T,
        jnp.expand_dims(x, 1),
        jax.lax.stop_gradient(x),
        jnp.copy(m)[1:, ::2],
        -x,
        -n,
        jax.lax.bitcast_convert_type(x, jnp.uint64),
        jax.lax.bitcast_convert_type(n, jnp.float64),
        jnp.nan_to_num(m[:, :2]) @ jnp.ones((2, 3)),
        jnp.tensordot(m[0, :2], jnp.ones((2, 3, 2)), axes=(0, 2)),
        jax.lax.optimization_barrier((x, m))[1],
        m.ravel(order="F"),
        jnp.reshape(m, (m.shape[1], m.shape[0]), order="F"),
        jax.lax.slice(x[0], (), ()),
        jnp.concatenate([m, 2.0 * m], axis=1),
        jnp.stack([x, -x], axis=1),
        jnp.broadcast_to(x[:2, None], (2, 3)),
        jax.lax.dynamic_slice(m, (n[0], n[1]), (1, 2)),
        jax.lax.dynamic_update_slice(m, m[:1, :2], (n[0], n[2])),
    )


def whole(x, n):
    return (
        *(f(n, n[::-1]) for f in (jnp.add, jnp.multiply, jnp.subtract, jnp.floor_divide)),
        *(f(n, n[::-1]) for f in (jnp.bitwise_and, jnp.bitwise_or, jnp.bitwise_xor, jnp.mod)),
        ~n,
        n**3,
        n >> 2,
        jnp.sum(n),
        n.astype(float),
        n > 0,
        (n > 0).astype(int),
        x.astype(int),
        x.astype(bool),
        x.astype(jnp.float32),
        jnp.select([x > 1.0, x > 0.0], [x, 2.0 * x], 0.0),
        jax.lax.select_n((n % 3).astype(jnp.int32), n, n + 1, n + 2),
        jnp.arange(3) + n[0],
        jnp.where(n[0] > 0, x, 0.0),
    )


def summed(x, n):
    """Derivatives, which add up."""

    def square(x):
        return jnp.sum(jnp.sin(x) * x)

    return jax.grad(square)(x[:2]), jax.jacfwd(lambda x: x * jnp.sum(x))(x[:3])


def controlled(x, n):
    def step(carry, row):
        total, number = carry
        total = jax.lax.cond(row > 0.0, lambda t: t + row, lambda t: t - 2.0 * row, total)
        return (total, number + 1), (total, number)

    backwards = jax.lax.scan(step, (0.0, 0), x[:3], reverse=True)
    halved = jax.lax.while_loop(lambda c: c[0] > 0.1, lambda c: (0.5 * c[0], c[1] + 1), (x[0], 0))
    return backwards, halved, jax.lax.switch(n[0], [jnp.sin, jnp.cos, jnp.exp], x[0])


def empty(x, n):
    none = x[:0]
    wide = x[:3, None] * none
    return (
        wide @ none,
        wide @ wide.T,
        wide.T @ x[:3],
        jax.lax.reduce_max(wide, (0,)),
        jax.lax.reduce_min(wide, (1,)),
        jax.lax.scan(lambda total, row: (total + row, row), x[0], none),
    )


def other_types(x, n):
    single = x[:3].astype(jnp.float32)
    return (
        *(reduce(n[:2], (0,)) for reduce in (jax.lax.reduce_and, jax.lax.reduce_or)),
        jax.lax.reduce_and(n > 0, (0,)),
        jnp.matmul(x[:2], x[:2], preferred_element_type=jnp.float32),
        (single @ single, single**2, single + 1, n.astype(jnp.int32) * 3, n.astype(jnp.uint32) - 5),
        1.0 / jnp.sign(x),
    )


def halved_in_turn(x, n):
    """Loops along a batch, each of which ends by itself; the first has no pass."""

    def halved(x, key):
        def step(state):
            x, passes, key = state
            return 0.5 * x, passes + jnp.array([1, 2]), jax.random.fold_in(key, 1)

        last = jax.lax.while_loop(lambda s: s[0] > 0.1, step, (x, jnp.zeros(2, int), key))
        return *last[:2], jax.random.key_data(last[2])

    return jax.vmap(halved)(x[:4] + jnp.array([-1.0, 2.0, 3.0, 0.2]), jax.random.split(KEY, 4))


def called(x, n):
    """Functions that are repeated where they are called, of others and of themselves."""
    shift = np.array([0.1, 0.2])

    @jax.jit
    def turned(a, b):
        return b + shift, a

    @jax.jit
    def twice(a, b):
        return (*turned(a, b), *turned(b, a), jnp.where(a[0] > 0.0, a, b)[0])

    first, second = twice(x[:2], x[1:3]), twice(x[1:3], x[:2])
    return first, second, turned(*turned(*first[:2])), x[2].reshape(1), x[:1].reshape(())


CASES = [smooth, moved, whole, summed, controlled, empty, other_types, halved_in_turn, called]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_as_compiled(function):
    found, expected = evaluated(function)(ROW, COUNTS), jax.jit(function)(ROW, COUNTS)
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for number, pair in enumerate(zip(*map(jax.tree.leaves, (found, expected)), strict=True)):
        ours, theirs = pair
        assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype), number
        np.testing.assert_allclose(ours, theirs, 4e-15, 1e-300, err_msg=str(number))


def test_every_rule_is_compared(module_at, monkeypatch):
    used = set()

    class Recorded(dict):
        def get(self, name):
            used.add(name)
            return super().get(name)

    monkeypatch.setattr("gyrostat.codegen.evaluation.RULES", Recorded(RULES))
    for function in CASES:
        evaluated(function)(ROW, COUNTS)
    primitives = module_at(Path(__file__).with_name("test_primitives.py"))
    for function in primitives.CASES:
        evaluated(function)(*(rows[0] for rows in primitives.ARGUMENTS))
    # drawn from keys in a test of their own; or not in every version of JAX
    others = {"random_bits", "copy_p", "expand_dims", "square", "stack"}
    assert set(RULES) - others <= used


def test_functions_that_call_others_are_not_repeated():
    def nested(depth):
        inner = (lambda x: x + 1.0) if depth == 0 else nested(depth - 1)
        return jax.jit(lambda x: sum(inner(x) for _ in range(8)))

    assert evaluated(nested(2))(1.0) == 2.0 * 8.0**3
    # 8^6 lines if each call were written out
    traced = jax.make_jaxpr(nested(5))(1.0)
    assert len([*_Source(_Programs())._lines(traced.jaxpr)]) < 100


def test_only_the_branch_that_is_taken_is_evaluated():
    def fail(x):
        raise AssertionError

    def function(x):
        def failing(x):
            return jax.pure_callback(fail, jax.ShapeDtypeStruct((), float), x)

        return jax.lax.cond(x > 0.0, lambda x: 2.0 * x, failing, x)

    assert evaluated(function)(np.array(3.0)) == 6.0


def test_an_error_has_the_message_of_the_function():
    function = evaluated(lambda x: eqx.error_if(2.0 * x, x < 0.0, "found a negative number"))
    assert function(np.array(1.0)) == 2.0
    with pytest.raises(eqx.EquinoxRuntimeError, match="found a negative number"):
        function(np.array(-1.0))


def test_arrays_along_a_batch():
    rng = np.random.default_rng(1)

    def function(x):
        return jax.lax.cond(x[0] > 0.0, jnp.sin, jnp.cos, x).sum() + x @ x

    rows = rng.standard_normal((6, 3))
    found = evaluated(jax.vmap(function))(rows)
    np.testing.assert_allclose(found, [function(row) for row in rows], 1e-14)


def test_random_keys_and_what_is_no_array():
    def function(key, scale, name):
        split = jax.random.split(jax.random.fold_in(key, 3))
        drawn = jax.random.normal(split[1], (2, 3)), jax.random.uniform(split[0])
        words = jax.random.bits(key, (3,), jnp.uint32), jax.vmap(jax.random.normal)(split)
        return {name: [scale * each for each in (*drawn, *words)], "key": split[0]}

    arguments = jax.random.key(5), np.array(2.0), "noise"
    found, expected = evaluated(function)(*arguments), function(*arguments)
    for pair in zip(found["noise"], expected["noise"], strict=True):
        np.testing.assert_allclose(*pair, 1e-15)
    assert (
        jax.random.key_data(found["key"]).tolist() == jax.random.key_data(expected["key"]).tolist()
    )


def test_random_keys_are_moved_and_stacked():
    def function(key):
        keys = jax.random.split(key, 4)
        square = jnp.stack([keys, keys[::-1]]).reshape(4, 2)
        rows = jax.lax.scan(lambda k, row: (jax.random.split(k)[0], k), key, None, length=3)[1]
        chosen = jnp.where(jnp.array([True, False, True, True]), keys, key)
        return [jax.random.key_data(each) for each in (keys[1:3], square, rows, chosen)]

    for pair in zip(evaluated(function)(KEY), function(KEY), strict=True):
        np.testing.assert_array_equal(*pair)


def test_equal_values_of_other_types_are_traced_anew():
    function = evaluated(lambda x, limit: x if limit is True else x + limit)
    assert [function(np.array(3), value) for value in (1, True, 1)] == [4, 3, 4]


def test_threads_share_a_program():
    def call(evaluate, barrier):
        barrier.wait()
        return evaluate(0.5)

    traced = jax.make_jaxpr(lambda x: sum(jnp.sin(k * x) for k in range(300)))(0.5)
    expected, interval = evaluation(traced)(0.5), sys.getswitchinterval()
    sys.setswitchinterval(1e-7)
    try:
        for _ in range(60):
            shared = evaluation(traced), Barrier(4)
            with ThreadPoolExecutor(4) as pool:
                results = [*pool.map(call, *zip(*[shared] * 4, strict=True))]
            assert results == [expected] * 4
    finally:
        sys.setswitchinterval(interval)


def test_traced_once_for_each_shape_and_each_value_of_what_is_no_array():
    traces = []

    @evaluated
    def function(x, count):
        traces.append(x.shape)
        return count * x

    for x, count in [(np.ones(2), 2), (np.zeros(2), 2), (np.ones(3), 2), (np.ones(2), 3)]:
        np.testing.assert_array_equal(function(x, count), count * x)
    assert traces == [(2,), (3,), (2,)]


def test_arguments_are_not_changed():
    row = np.zeros(3)
    evaluated(lambda x: x.at[1].set(5.0))(row)
    evaluated(lambda x: jax.lax.dynamic_update_slice(x, x[:1] + 1.0, (0,)))(row)
    assert not row.any()


def test_constants_of_the_trace():
    table = np.arange(5.0)
    traced = jax.make_jaxpr(lambda k: jnp.asarray(table)[k] + jnp.asarray(table).sum())(0)
    assert evaluation(traced)(3)[0] == 13.0


def test_products_by_hand_are_those_of_blas():
    rng = np.random.default_rng(2)
    a, b = rng.standard_normal((4, 3, 5)), rng.standard_normal((5, 4, 2))
    for axes in ((2, 0), ((2, 0), (0, 1)), (0, 1)):
        found = evaluated(partial(jnp.tensordot, axes=axes))(a, b)
        np.testing.assert_allclose(found, np.tensordot(a, b, axes), 1e-13)
    large = rng.standard_normal((200, 200))
    np.testing.assert_allclose(evaluated(jnp.matmul)(large, large), large @ large, 1e-10)
