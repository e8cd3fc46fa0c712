"""Tests that ranges of numbers decide are not in emitted C, and the others are."""

import re

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.flight.reader.functions import functions
from gyrostat.codegen.flight.reader.translate import translate
from gyrostat.codegen.fold_ranges import fold_ranges
from gyrostat.codegen.program import Assign, Function, Name, Number
from gyrostat.core.jax64 import jax, jnp

LANES = 40
RANDOM = np.random.default_rng(0)
ROWS = np.arange(12.0).reshape(4, 3)
MANY = RANDOM.normal(size=50)
LAST = 2**63 - 1
TALL = np.arange(600.0).reshape(200, 3)


def chosen(x):
    """Row at the place of the largest element, which is always one of the rows."""
    return jnp.asarray(ROWS)[jnp.argmax(x)] + jnp.stack([x[:3], x[1:], x[:3]])[jnp.argmin(x[:3])]


def sought(x):
    """Row at the place of the largest of many elements, which a loop seeks."""
    wide = jnp.outer(x, jnp.asarray(MANY)).ravel()
    return jnp.asarray(TALL)[jnp.argmax(wide)]


def counted(x):
    """Element at a count of int32 that ends within the array."""
    count = jnp.sum((x > 0.0).astype(jnp.int32))
    return jnp.concatenate([x, jnp.zeros(1)])[jnp.where(count > 2, 2, count)]


def permuted(x):
    """Solution by a factorisation with pivots: places of a permutation are in a table."""
    matrix = jnp.eye(9) + 0.1 * jnp.outer(jnp.ones(9), jnp.tile(jnp.nan_to_num(x), 3)[:9])
    lu, _, places = jax.lax.linalg.lu(matrix)
    return jnp.floor(lu[0, :3]), jnp.ones(9)[places], (x[0] + jnp.arange(9.0))[places]


def ordered(x):
    """Parts of rows in an order that a loop seeks; it carries the places that it has found."""
    rows, index = jnp.stack([x, x[::-1], 2.0 * x]), jnp.arange(3)

    def step(k, carry):
        used, order = carry
        best = jnp.argmax(jnp.where(used, -9.0, rows[:, 0]))
        return used | (index == best), jnp.where(index == k, best, order)

    order = jax.lax.fori_loop(0, 3, step, (jnp.zeros(3, bool), index))[1]
    return rows[order, 1:]


def counting(x):
    """A loop that ends early, and returns the number at which it does."""

    def further(state):
        number, total = state
        return number + 1, total + 1.0 + jnp.abs(x)[number - 2]

    return jax.lax.while_loop(lambda s: (s[1] < 1.5) & (s[0] < 6), further, (2, 0.0))


def anywhere(place, x):
    """Element at any index, which is brought into the array."""
    return x[place]


def branched(place, x):
    """Elements of three at an index that the tests around them limit, on both sides of each."""
    few = x[:3]
    below = jax.lax.cond((place < 2) & (x[3] > 0.0), lambda: few[place], lambda: x[3])
    above = jax.lax.cond(place <= -1, lambda: x[3], lambda: few[place])
    return below, above, jnp.where(place < 7, few[jnp.minimum(place, 1)], 0.0)


def sizes(x):
    """A size is not negative; the difference of sizes may be."""
    size = jnp.abs(x)
    return jnp.where(size < 0.0, jnp.nan, size), jnp.where(size[0] - size[1] < 0.0, 1.0, 2.0)


def wrapped(place, x):
    """Places around a ring; a remainder below zero is not zero, and one in a table is no end."""
    return jnp.mod(place, 4), jnp.mod(place, -4), x[jnp.mod(place, 3)]


REALS = np.where(RANDOM.random((LANES, 4)) < 0.1, np.nan, RANDOM.normal(size=(LANES, 4)))
CASES = {
    chosen: {"x": REALS},
    sought: {"x": REALS},
    counted: {"x": REALS},
    permuted: {"x": REALS},
    ordered: {"x": REALS},
    counting: {"x": REALS},
    anywhere: {"place": RANDOM.integers(-9, 9, LANES), "x": REALS},
    branched: {"place": np.append(RANDOM.integers(-9, 9, LANES - 2), [-(2**63), LAST]), "x": REALS},
    sizes: {"x": REALS},
    wrapped: {"place": RANDOM.integers(-9, 9, LANES), "x": REALS},
}
TESTED = {
    chosen: r"[<>] \d+\) \?",
    sought: r"\w+ [<>] (0|199)\b",
    counted: r"\w+ < 0\b",
    ordered: r"\w+(\[\w+\])? (< 0|> [123])\b|integer_sum",
    counting: r"\w+ < 0\b",
    permuted: r"\b(?!i\b)\w+(\[\w+\])? < 0\b",
    sizes: r"size\w* < 0\.0",
    wrapped: r"< 0\) && |!= false|INT64_C",
}
"""Function -> test that is never true in it."""


def module_of(function):
    example = {name: array[0] for name, array in CASES[function].items()}
    count = len(jax.tree.leaves(jax.eval_shape(function, *example.values())))
    names = tuple(f"out_{k}" for k in range(count))
    return emit("part", [Entry(function.__name__, function, example, names)])


def code_of(function):
    """C without comments."""
    return re.sub(r"/\*.*?\*/", "", module_of(function).source, flags=re.DOTALL)


@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_results_are_those_of_python(function, tools, tmp_path):
    arguments = CASES[function]
    program = tools.Compiled(module_of(function), tmp_path)
    status, results = program(function.__name__, arguments)
    expected = jax.vmap(function)(*arguments.values())
    assert not status.any()
    for one, other in zip(jax.tree.leaves(results), jax.tree.leaves(expected), strict=True):
        assert np.array_equal(one, other, equal_nan=True)


@pytest.mark.parametrize("function", TESTED, ids=lambda f: f.__name__)
def test_what_is_never_true_is_not_tested(function):
    assert not re.search(TESTED[function], code_of(function))


def test_limits_of_an_index_that_a_branch_implies_are_not_tested():
    source = code_of(branched)
    assert len(re.findall(r"> 2\b", source)) == 1  # where the index is not negative
    assert len(re.findall(r"< 0\b", source)) == 4  # of the others: from the end, then to the start


def test_an_index_from_outside_is_tested():
    source = code_of(anywhere)
    assert re.search(r"< 0\b", source)
    assert re.search(r"> 3\b", source)


def wrapping(x, n):
    """Numbers that wrap around are negative where a range without limits would not be."""
    in_loop = jax.lax.fori_loop(
        0, 6, lambda _, c: (c[0] + 1, c[1] + jnp.where(c[0] < 0, 1, 0)), (jnp.asarray(LAST - 3), 0)
    )
    count = jnp.clip(n, 0, 9)
    far = jnp.where(x[0] > 0.0, 2**40, 7)
    ended = jnp.where(in_loop[0] < 0, 1, 2), jnp.where(count + (LAST - 5) < 0, 1, 2)
    return *in_loop, *ended, jnp.asarray(ROWS.ravel())[far], jax.lax.dynamic_slice(x, (far,), (2,))


def reciprocals(x):
    """Quotients over a negative zero are negative, without a negative operand."""
    size = jnp.where(x < 0.0, -x, x)
    return tuple(jnp.where(1.0 / y < 0.0, 1.0, 2.0) for y in (jnp.sqrt(x), size, 2.0 * size))


def test_numbers_wrap_around_and_zeros_have_signs(tools, tmp_path):
    numbers = np.array([0.0, -0.0, 0.5, -0.5, 3.0, np.nan, np.inf, -np.inf])
    rows = numbers[np.add.outer(np.arange(8), np.arange(4)) % 8]
    counts = np.array([0, 1, 5, 6, 9, LAST, -LAST, -1])
    for function, arguments in ((wrapping, {"x": rows, "n": counts}), (reciprocals, {"x": rows})):
        expected = jax.tree.leaves(jax.vmap(function)(*map(jnp.asarray, arguments.values())))
        example = {name: array[0] for name, array in arguments.items()}
        names = tuple(f"out_{k}" for k in range(len(expected)))
        module = emit("part", [Entry(function.__name__, function, example, names)])
        folder = tmp_path / function.__name__
        folder.mkdir()
        _, results = tools.Compiled(module, folder)(function.__name__, arguments)
        for number, pair in enumerate(zip(jax.tree.leaves(results), expected, strict=True)):
            np.testing.assert_array_equal(*pair, err_msg=f"{function.__name__} {number}")


def clipped(x, n):
    """Limits and divisors that are constants."""
    return (
        jnp.clip(x, -1.0, 2.0),
        jnp.maximum(0.0, x),
        n // 3,
        n % 5,
        jax.lax.rem(n, jnp.asarray(-7)),
    )


def test_constants_need_no_test_for_nan_or_zero(tools, tmp_path):
    special = [0.0, -0.0, -1.0, 2.0, np.nan, np.inf, -np.inf, 1.5, -7.0]
    arguments = {"x": np.array(special), "n": np.array([0, 1, -1, 7, -7, 2**62, -(2**63), 14, 35])}
    example = {name: array[0] for name, array in arguments.items()}
    names = tuple(f"out_{k}" for k in range(5))
    module = emit("part", [Entry("clipped", clipped, example, names)])
    decisions = translate(functions(module.source), [], has_margins=False).decisions
    texts = [text for decision in decisions for text in decision.conditions]
    assert not [text for text in texts if re.search(r"(\w+) != \1$|== -?[01]$", text)]
    _, results = tools.Compiled(module, tmp_path)("clipped", arguments)
    expected = jax.vmap(clipped)(*map(jnp.asarray, arguments.values()))
    for one, other in zip(jax.tree.leaves(results), expected, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
        assert np.array_equal(np.signbit(one), np.signbit(other))


@pytest.mark.parametrize("order", [1, -1])
def test_a_sum_of_indices_drops_a_term_that_is_found_to_be_zero(order):
    chosen, place, total = Name("index"), Name("index"), Name("index")
    flag = Name("logical")
    zero, one = Number("index", 0), Number("index", 1)
    body = [
        Assign(chosen, "select", (flag, zero, zero)),
        Assign(total, "add", (chosen, place)[::order]),
        Assign(further := Name("index"), "add", (total, one)[::order]),
    ]
    function = Function("f", [flag, place], body, [total, further])
    fold_ranges(function)
    assert function.results == [place, further]
    assert [set(each.operands) for each in function.body if each.target is further] == [
        {place, one}
    ]
