"""What lanes leave out, and that what is left gives the same numbers."""

import re

import numpy as np
import pytest

from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.jax64 import jax, jnp

RUNS = 19
RANDOM = np.random.default_rng(8)
VECTORS = RANDOM.standard_normal((RUNS, 3))


def compiled(function, *arguments):
    """The text of a function in lanes, whose results are those under `vmap`."""
    program = lanes(function, (True,) * len(arguments), arguments)
    expected = jax.jit(jax.vmap(function))(*arguments)
    found = program(*arguments)
    for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-14, atol=1e-300)
    return program.text


def statements(text, pattern):
    return len(re.findall(rf"v\d+ = [^;]*{pattern}[^;]*;", text))


def test_axes_of_the_body_cost_nothing():
    text = compiled(lambda v: np.diag([1.0, -1.0, 2.0]) @ v + np.zeros(3), VECTORS)
    assert statements(text, r" \* ") == 1
    assert statements(text, r" \+ ") == 0


def test_what_is_known_is_not_computed_again():
    def turned(v):
        axis = jnp.cross(v, jnp.array([1.0, 2.0, 3.0]))
        return axis, -jnp.cross(-v, jnp.array([1.0, 2.0, 3.0])), jnp.exp(axis) + jnp.exp(axis)

    text = compiled(turned, VECTORS)
    assert statements(text, "exp_real") == 3
    assert statements(text, " - ") == 3


def test_a_divisor_that_stays_divides_once():
    def program(v, scale):
        def step(y, _):
            return y - 0.1 * jnp.tanh(y / scale) + v / 3.0, None

        return jax.lax.scan(step, v, None, length=50)[0] / jnp.sqrt(v @ v)

    text = compiled(program, VECTORS, 1.0 + RANDOM.random(RUNS))
    loop = text[text.index("for (int64_t") : text.index("        v")]
    assert statements(loop, " / ") == 0
    assert statements(text, " / ") == 2


def test_what_a_loop_does_not_change_is_not_carried():
    def program(v):
        def step(carry, _):
            following = carry[0] + carry[1] * carry[2]
            return (following, carry[1], following), None

        return jax.lax.scan(step, (v, 2.0 * v, v), None, length=9)[0]

    text = compiled(program, VECTORS)
    loop = text[text.index("for (int64_t") :]
    assert statements(loop, r" \+ ") == 3


def test_quotients_that_are_made_whole_stay_exact():
    def program(k, step):
        def count(total, _):
            time = k * step
            return total + jnp.floor(time / step), (time / 49.0).astype(int)

        total, _ = jax.lax.scan(count, 0.0, None, length=3)
        whole = jnp.round(0.5 + (k / 49.0 - 0.5)), jnp.ceil(k / step), k % 7.0
        return total, whole, (k * 0.1) * 10.0 >= 3.0, jnp.trunc(k / 49.0)

    given = np.arange(1.0, 500.0), np.full(499, 49.0)
    found = lanes(program, (True, True), given, more_flags=("-ffp-contract=off",))
    total, (rounded, up, rest), _, whole = found(*given)
    np.testing.assert_array_equal(total, 3.0 * given[0])
    np.testing.assert_array_equal(rounded, np.round(0.5 + (given[0] / 49.0 - 0.5)))
    np.testing.assert_array_equal(up, np.ceil(given[0] / 49.0))
    np.testing.assert_array_equal(rest, given[0] % 7.0)
    np.testing.assert_array_equal(whole, np.trunc(given[0] / 49.0))


def test_quotients_from_branches_and_tables_stay_exact():
    def program(k, step):
        quotient, rest = (k * step) / step, k - jnp.round(k)
        dear = jnp.sin(rest) * jnp.cos(rest)
        return (
            jnp.floor(jnp.where(rest == 0.0, quotient + dear, 2.5 + 3.0 / step)),
            jnp.floor(jax.lax.cond(k > 3.0, lambda: quotient, lambda: k + 1.0 / step)),
            jnp.floor(jnp.stack([quotient, 2.0 / step])[(k < 0.0).astype(int)]),
            jnp.floor(jax.lax.scan(lambda c, x: (c, k * x / x), 0.0, step + jnp.zeros(1))[1][0]),
            jnp.floor(jnp.sqrt(k * (k * step / step))),
        )

    whole, steps = np.arange(1.0, 500.0), np.full(499, 49.0)
    found = lanes(program, (True, True), (whole, steps), more_flags=("-ffp-contract=off",))
    for made in found(whole, steps):
        np.testing.assert_array_equal(made, whole)


def test_constants_are_joined_where_a_number_can_hold_them():
    def program(large, small):
        return large / 1e308, large * 1e-200 * 1e-200, small * 1e200 * 1e200, small * 2.0 * 1e9

    given = np.array([1e300, -2e300]), np.array([1e-300, -2e-300])
    found = lanes(program, (True, True), given)(*given)
    for ours, exact in zip(found, program(*given), strict=True):
        np.testing.assert_allclose(ours, exact, rtol=1e-15)


def test_nothing_endless_is_a_limit():
    text = compiled(lambda v: jnp.clip(v, -jnp.inf, np.array([np.inf, 1.0, np.inf])), VECTORS)
    assert statements(text, "at_(most|least)") == 1


def test_logical_values_and_constants_fold():
    def program(v):
        up = v > 0.0
        always = jnp.array([True, False, True])
        both = jnp.where(~up, v, 2.0 * v) * jnp.where(always, 1.0, jnp.sqrt(2.0))
        return both, jnp.where(~~up, 1.0, -1.0), (up & always) | (up ^ up)

    text = compiled(program, VECTORS)
    assert statements(text, "~") == 0


def held(v):
    """The curve of a wheel that turns; else something else and dear, which needs all of them."""
    rests = v == 0.0
    coupled = np.array([[2.0, 0.3, 0.1], [0.3, 1.5, 0.2], [0.1, 0.2, 1.0]])
    holds = coupled @ jnp.where(rests, 1.0, coupled @ v) + jnp.cos(v)
    return jnp.where(rests, holds, jnp.sin(v))


@pytest.mark.parametrize("share", [0.0, 0.1, 1.0])
def test_what_is_seldom_needed_stands_in_a_branch(share):
    vectors = np.where(RANDOM.random((RUNS, 3)) < share, 0.0, VECTORS)
    text = compiled(held, vectors)
    before, branch = text.split("if (SELDOM(any(")
    assert statements(before, "sin_real") + statements(branch, "sin_real") == 3
    assert statements(before, "cos_real") == 0
    assert statements(branch, "cos_real") == 3


def test_what_both_sides_need_stays_before_the_branch():
    def program(v):
        dear = jnp.sin(v) * jnp.cos(v)
        return jnp.where(v == 0.0, jnp.tan(dear) + dear, dear)

    before, branch = compiled(program, VECTORS).split("if (SELDOM(any(")
    assert statements(before, "sin_real") == 3
    assert statements(branch, "tan_real") == 3


def test_the_same_function_is_the_same_text():
    one, other = (lanes(held, (True,), (VECTORS,)).text for _ in range(2))
    assert one == other


def test_numbers_too_small_to_be_normal_are_zero():
    small = np.array([1e-310, 5e-324, 1e-300, -1e-309, 0.0])
    found = lanes(lambda x: (x * 1.5, x * 1e-5, x == 0.0), (True,), (small,))(small)
    expected = jax.jit(lambda x: (x * 1.5, x * 1e-5, x == 0.0))(small)
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert np.float64(5e-324) / 2.0 == 0.0 < np.float64(1e-310) * 0.5  # here they are as before


def test_a_branch_takes_all_that_leads_to_it():
    def program(v):
        rests = v == 0.0
        inner = jnp.where(rests, jnp.cos(v) * jnp.sum(v), jnp.tan(v))
        return jnp.where(rests, jnp.abs(inner) < 0.5, v > 0.0)

    vectors = np.where(RANDOM.random((RUNS, 3)) < 0.2, 0.0, VECTORS)
    before, branch = compiled(program, vectors).split("if (SELDOM(any(", 1)
    assert statements(before, "(cos|tan)_real") == 0
    assert statements(branch, "tan_real") == 3


def test_a_branch_may_take_some_elements_of_an_array():
    def program(v, x):
        dear = jnp.sin(v + 1.0) * jnp.cos(v + 2.0) * x
        inner = jnp.where(v == 0.0, dear, jnp.tan(v))
        outer = jnp.sin(inner[0]) * jnp.cos(inner[0]) + dear[2]
        return jnp.where(x == 0.0, outer, x), inner[1:]

    vectors = np.where(RANDOM.random((RUNS, 3)) < 0.3, 0.0, VECTORS)
    text = compiled(program, vectors, np.where(RANDOM.random(RUNS) < 0.3, 0.0, VECTORS[:, 0]))
    assert text.count("if (SELDOM(any(") == 2
