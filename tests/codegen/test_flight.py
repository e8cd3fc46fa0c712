"""Flight C of small functions: every construct against Python, every refusal with its line."""

import inspect
import re
from typing import NamedTuple

import equinox as eqx
import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite, solve, whiten

LANES = 500


def elementary(x, y):
    """Every elementary function."""
    near = 0.9 * jnp.tanh(x)
    return (
        jnp.exp(x) + jnp.expm1(x) + jnp.log(1.0 + x * x) + jnp.log1p(y * y),
        jnp.sin(x) + jnp.cos(y) + jnp.tan(near) + jnp.arctan2(x, y) + jnp.arctan(x),
        jnp.arcsin(near) + jnp.arccos(near) + jnp.sinh(near) + jnp.cosh(near),
        jnp.floor(x) + jnp.ceil(y) + jnp.round(x * 3.0) + jnp.fmod(x, 0.7) + jnp.sign(y),
        (jnp.abs(x) + 0.1) ** y + x**3 + (y + 5.0) ** -2 + jnp.sqrt(x * x) + jax.lax.rsqrt(x * x),
        jnp.maximum(x, y) + jnp.minimum(x, 0.0) + jnp.clip(y, -0.3, x) + jax.nn.sigmoid(x),
        jnp.isfinite(x) & ~(x < y) | (x == y),
    )


def vectors(x, y):
    """Moves and sums of the elements of vectors and matrices."""
    matrix = jnp.outer(x, y) + jnp.diag(x) + jnp.eye(3)
    turned = jnp.flip(matrix.T, 0)[1:, ::2]
    return (
        matrix @ y,
        jnp.cross(x, y) + jnp.concatenate([x[1:], y[:1]]),
        turned.sum(axis=1) + jnp.max(turned, axis=0),
        jnp.linalg.norm(x) + jnp.trace(matrix) + jnp.min(x) + jnp.prod(y),
        jnp.where(x > y, x, -y),
        jnp.any(x > 1.0) & jnp.all(y < 3.0),
        jnp.pad(x, (1, 2)) + jnp.stack([x, y]).reshape(6),
    )


def loops(x, y):
    """A scan both ways, a counted loop, a bounded one and one in the other."""

    def add(total, each):
        return 0.5 * total + each[0], total * each[1]

    total, seen = jax.lax.scan(add, x[0], (x, y))
    back, behind = jax.lax.scan(add, total, (y, x), reverse=True)
    both = jax.lax.fori_loop(0, 4, lambda k, c: (c[1], c[0] + k), (x[1], y[1]))

    def halve(carry):
        value, count = carry
        inner = jax.lax.fori_loop(0, 2, lambda k, v: 0.9 * v, value)
        return inner, count + 1

    def goes_on(carry):
        return (jnp.abs(carry[0]) > 0.05) & (carry[1] < 50)

    value, count = jax.lax.while_loop(goes_on, halve, (x[2], 0))
    return total, seen, back, behind, both, value, count


def branches(x, y):
    """Two ways, several ways, and an index out of range."""
    one = jax.lax.cond(x > y, lambda a, b: a - b, lambda a, b: jnp.exp(a) * b, x, y)
    ways = [lambda a: a, lambda a: a * a, lambda a: -a]
    number = (x > 0.0).astype(int) + (y > 0.0).astype(int) * 2 - 1
    return one, jax.lax.switch(number, ways, y)


def algebra(x, y):
    """The package's own solvers, with pivots."""
    matrix = jnp.outer(x, x) + jnp.diag(1.0 + y**2)
    right = y[:, None]
    unsymmetric = matrix + jnp.outer(x, y)
    return inverse_definite(matrix), whiten(matrix, right), *solve(unsymmetric, right)


@jax.jit
def _squared(x, unused):
    return x * x, x + 1.0, unused


def functions(x, y):
    """One function called twice, with a result and an argument that nobody needs."""
    return _squared(x, y)[0] - _squared(y, x)[0]


VECTOR = np.ones(3)
CASES = {
    elementary: 0.0,
    vectors: VECTOR,
    loops: VECTOR,
    branches: 0.0,
    algebra: VECTOR,
    functions: 0.0,
}


@pytest.fixture(scope="module")
def compiled(tools, tmp_path_factory):
    """All cases in one module."""
    entries = []
    for function, example in CASES.items():
        count = len(jax.tree.leaves(jax.eval_shape(function, example, example)))
        names = tuple(f"result_{k}" for k in range(count))
        given = {"x": example, "y": example}
        entries.append(Entry(function.__name__, flat(function), given, names))
    module = emit("cases", entries)
    return tools.Compiled(module, tmp_path_factory.mktemp("cases"))


def flat(function):
    """The function with a tuple of arrays, or one array, as its result."""

    def call(x, y):
        leaves = jax.tree.leaves(function(x, y))
        return tuple(leaves) if len(leaves) > 1 else leaves[0]

    return call


def _refute_algebra(x, y, results):
    """What the solvers found, by NumPy: quicker than JAX's compilation of them."""
    inverse, white, solved, _ = results
    matrix = x[:, :, None] * x[:, None] + np.eye(3) * (1.0 + y**2)[:, :, None]
    unsymmetric = matrix + x[:, :, None] * y[:, None]
    np.testing.assert_allclose(inverse, np.linalg.inv(matrix), rtol=0.0, atol=1e-12)
    squared = np.einsum("ij,ijk,ik->i", y, inverse, y)
    np.testing.assert_allclose(np.sum(white**2, axis=(1, 2)), squared, rtol=1e-9)
    np.testing.assert_allclose(unsymmetric @ solved, y[:, :, None], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
def test_every_construct_is_what_python_says(function, compiled, tools):
    random = np.random.default_rng(7)
    shape = (LANES, *np.shape(CASES[function]))
    x, y = (1.5 * random.standard_normal(shape) for _ in range(2))
    status, found = compiled(function.__name__, {"x": x, "y": y})
    assert not status.any()
    jaxpr = jax.make_jaxpr(function)(x[0], y[0])
    expected = tools.interpret(jaxpr, [x, y])
    assert len(found) == len(expected)
    for ours, theirs in zip(found.values(), expected, strict=True):
        np.testing.assert_array_equal(ours[0], theirs)
    if function is algebra:
        _refute_algebra(x, y, [ours[0] for ours in found.values()])
        return
    compiled = jax.tree.leaves(jax.jit(jax.vmap(function))(x, y))
    for ours, compiled_jax in zip(found.values(), compiled, strict=True):
        scale = np.abs(compiled_jax).max()
        np.testing.assert_allclose(ours[0], compiled_jax, rtol=1e-11, atol=1e-13 * scale)


def test_loops_and_functions_stay_what_they_are(compiled):
    text = compiled.module.source
    body = text[text.index("int loops(") : text.index("int branches(")]
    assert len(re.findall(r"\bfor \(", body)) == 5
    assert len(re.findall(r"\bbreak;", body)) == 1  # of the loop that may end before its bound
    assert len(re.findall(r"^static .*\bsquared\(", text, re.MULTILINE)) == 1
    assert len(re.findall(r"= squared\(\w+\)", text)) == 2  # no argument, no result too many
    assert len(re.findall(r"\bif \(", text[text.index("int branches(") :])) >= 2


def by_counter(x):
    """A loop that ends by its counter alone."""
    return jax.lax.while_loop(lambda c: c[0] < 4, lambda c: (c[0] + 1, 0.5 * c[1]), (1, x))


def by_either(x):
    """A loop that ends by a tolerance or by its counter, whichever is first."""

    def goes_on(carry):
        return (carry[0] > 1.0) & (carry[1] <= 9)

    return jax.lax.while_loop(goes_on, lambda c: (0.5 * c[0], c[1] + 1), (x, 0))


@jax.jit
def _halved(x):
    return by_either(x)[0]


def nested(x):
    """A loop around loops of both kinds, one of them in a function that is called twice."""

    def further(carry):
        number, value, seen = carry
        return number + 1, 3.0 * _halved(value), seen + _halved(by_counter(value)[1])

    return jax.lax.while_loop(lambda c: (c[0] < 5) & (c[1] < 1e4), further, (0, x, 0.0))


def without_a_pass(x):
    """Loops whose counters are at their ends before the first pass."""
    ended = jax.lax.while_loop(lambda c: c[0] < 3, lambda c: (c[0] + 1, 2.0 * c[1]), (3, x))
    further = jax.lax.while_loop(
        lambda c: (c[0] < 3) & (c[1] > 2.0), lambda c: (c[0] + 1, c[1] - 1.0), (7, ended[1])
    )
    return ended[0], further[1] + x


LOOPS = (by_counter, by_either, nested, without_a_pass)
"""Loops with a bound in their test."""


@pytest.fixture(scope="module")
def bounded(tools, tmp_path_factory):
    """Loops with a bound in their test, in one module."""
    entries = [
        Entry(each.__name__, each, {"x": 0.0}, ("a", "b", "c")[: len(each(0.0))]) for each in LOOPS
    ]
    return tools.Compiled(emit("bounded", entries), tmp_path_factory.mktemp("bounded"))


@pytest.mark.parametrize("function", LOOPS, ids=lambda f: f.__name__)
def test_a_loop_ends_as_in_python_and_returns_0(function, bounded):
    # at once, by the tolerance, in the last pass, by the counter while above the tolerance, NaN
    x = np.array([0.5, 100.0, 2.0**10, 2.0**10 + 1.0, 1e6, np.inf, np.nan])
    status, found = bounded(function.__name__, {"x": x})
    assert status.tolist() == [0] * len(x)
    expected = jax.vmap(function)(x)
    for ours, theirs in zip(found.values(), expected, strict=True):
        np.testing.assert_array_equal(ours[0], theirs)


def test_no_test_of_a_loop_is_always_true(bounded):
    text = bounded.module.source
    assert not re.search(r"!\(?(true|false)\b", text)
    assert "status" not in text
    assert len(re.findall(r"\bbreak;", text)) == 3  # by_either, and two in nested
    body = text[text.index("int by_counter(") : text.index("int by_either(")]
    assert "< 3; ++" in body
    body = text[text.index("int without_a_pass(") :]
    assert "for (" not in body


def test_emitted_again_it_is_the_same_byte_by_byte():
    entries = [Entry("loops", flat(loops), {"x": VECTOR, "y": VECTOR}, tuple("abcdefgh"))]
    first, second = emit("again", entries), emit("again", entries)
    assert (first.source, first.header) == (second.source, second.header)


class Gains(eqx.Module):
    """Two gains.

    Attributes:
        static: K, N·m/rad. A word of C.
        rows: of a matrix,
            1/s.
    """

    static: float
    rows: np.ndarray
    delay: int = eqx.field(static=True, default=3)


class Seen(NamedTuple):
    """What is measured."""

    angle: float
    flag: bool

    UNITS = {"angle": "rad"}  # noqa: RUF012


def controlled(gains, memory, seen):
    """Command a torque."""
    swapped = (memory[1], memory[0] + seen.angle)
    return swapped, jnp.where(seen.flag, gains.static, 0.0) * jnp.sum(gains.rows @ gains.rows[0])


def test_structs_have_the_names_the_meaning_and_the_state_of_python(tools, tmp_path):
    arguments = {
        "gains": Gains(2.0, np.arange(4.0).reshape(2, 2)),
        "memory": (1.0, 2.0),
        "seen": Seen(0.5, True),
    }
    module = emit("law", [Entry("law_step", controlled, arguments, ("memory", "torque"))])
    for line in (
        "/* Two gains. Compiled in: delay = 3. */",
        "    /* K, N·m/rad. A word of C. */\n    double static_;",
        "    /* of a matrix, 1/s. */\n    double rows[2][2];",
        "    /* rad */\n    double angle;",
        "    bool flag;\n} Seen;",
        "    double item_0;\n    double item_1;\n} law_step_memory;",
    ):
        assert line in module.header
    compiled = tools.Compiled(module, tmp_path)
    lanes = jax.tree.map(lambda leaf: np.asarray(leaf)[None], arguments)
    _, found = compiled("law_step", lanes)
    # the state takes its own place: nothing is read after it is set
    assert [leaf[0] for leaf in found["memory"]] == [2.0, 1.5]
    assert found["torque"][0][0] == 2.0 * (1.0 + 3.0)


def test_every_group_of_statements_names_its_line_of_python(compiled):
    text = compiled.module.source
    lines, first = inspect.getsourcelines(elementary)
    number = next(k for k, line in enumerate(lines) if "near = " in line)
    comment = f"/* test_flight.py:{first + number}: near = 0.9 * jnp.tanh(x) */"
    assert f"{comment}\n    const double near = 0.9 * tanh(x);" in text
    assert re.search(r"/\* gyrostat/core/linear\.py:\d+: row = rows\[0\]", text)
    assert "/tmp" not in text
    assert "site-packages" not in text


def test_comments_and_names_cannot_break_c(tools, tmp_path):
    def named(x):
        double = x + 1.0 if "*/ /* ??/ *\\ \\* /// ??? \\" else x
        exp = jnp.exp(double)
        return exp * exp, double * exp

    module = emit("named", [Entry("named", named, {"x": 0.0}, ("exp_", "int_"))])
    _, found = tools.Compiled(module, tmp_path)("named", {"x": np.zeros(1)})
    np.testing.assert_allclose(found["exp_"][0], np.e**2)
    assert "//" not in module.source  # MISRA C:2012, rule 3.1


def test_float_is_float_throughout(tools, tmp_path):
    def bounded(x):
        return jnp.exp(-x) / jnp.maximum(x, jnp.finfo(float).tiny), 0.1 * x

    module = emit("single", [Entry("single", bounded, {"x": 0.0}, ("y", "z"))], "float")
    assert "double" not in module.source + module.header
    assert "expf(" in module.source
    single = tools.Compiled(module, tmp_path, precision="float")
    _, found = single("single", {"x": np.array([0.5, 3.0])})
    np.testing.assert_allclose(found["y"][0], np.exp([-0.5, -3.0]) / [0.5, 3.0], rtol=3e-7)
    assert "0.0f" not in module.source  # the least double would vanish


def side_effect(x):
    jax.debug.print("x is {}", x)
    return x


def callback(x):
    shape = jax.ShapeDtypeStruct((), float)
    return jax.pure_callback(np.sin, shape, x)


KEPT = []


def remembers(x):
    KEPT.append(x)
    return x + KEPT[0]


def counts(x):
    KEPT.append(0)
    return x + len(KEPT)


def data_dependent(x):
    return jnp.arange(3.0)[jnp.arange(3.0) < x].sum()


def python_branch(x):
    return x if x > 0.0 else -x


def unbounded(x):
    return jax.lax.while_loop(lambda v: v > 1.0, lambda v: 0.5 * v, x)


def bounded_by_data(x):
    return jax.lax.fori_loop(0, 3 + (x > 0.0), lambda k, v: 0.5 * v, x)


def large(x):
    return jnp.sum(x * jnp.ones((200, 200)))


def empty(x):
    return jnp.sum(jnp.ones((2, 0)) * x)


def large_input(x):
    return x.sum()


def reduced(x):
    return jax.scipy.linalg.hessenberg(x * jnp.eye(3)).sum()


def pivoted(x):
    return jax.scipy.linalg.qr(x * jnp.eye(3), pivoting=True)[1].sum()


def drawn(x):
    return x + jax.random.normal(jax.random.key(0))


def small(x):
    return x.astype(jnp.float32)


REFUSED = {
    side_effect: ("jax.debug.print", "an effect on the outside"),
    callback: ("jax.pure_callback", "a primitive (pure_callback)"),
    remembers: ("", "kept from an earlier call"),
    counts: ("", "no side effect"),
    data_dependent: ("jnp.arange", "shape that depends on data"),
    python_branch: ("if x > 0.0", "needs the value of an input"),
    unbounded: ("while_loop", "a loop without a bound"),
    bounded_by_data: ("fori_loop", "a loop without a bound"),
    large: ("jnp.ones((200, 200))", "an array of 200×200"),
    empty: ("jnp.sum", "a sum of no elements"),
    reduced: ("scipy.linalg.hessenberg", "(hessenberg)"),
    pivoted: ("scipy.linalg.qr", "QR without pivoting"),
    drawn: ("jax.random", "found random numbers"),
    small: ("float32", "numbers of type float32"),
}


@pytest.mark.parametrize("function", REFUSED, ids=lambda f: f.__name__)
def test_what_does_not_belong_in_flight_code_is_refused_with_its_line(function):
    text, what = REFUSED[function]
    with pytest.raises(InputError) as caught:
        emit("bad", [Entry("bad", function, {"x": 1.0}, ("y",))])
    message = str(caught.value)
    assert what in message
    assert text in message
    assert "\n" not in message
    if text:
        lines, first = inspect.getsourcelines(function)
        number = next(k for k, line in enumerate(lines) if text in line)
        assert f"test_flight.py:{first + number}: " in message


HELD = np.random.default_rng(3).standard_normal((600, 4))
HELD_AS_ONE = jnp.asarray(HELD)


@jax.jit
def _of_last_column(k):
    return jax.lax.dynamic_slice(HELD_AS_ONE, (k, 3), (1, 1))[0, 0]


def interpolated(x):
    """Rows of a large constant at computed indices, in a branch and a loop too, and one element."""

    def row(k):
        one, after = jax.lax.dynamic_slice(HELD_AS_ONE, (k, 1), (2, 3))
        return (one - 0.5 * after)[::2]

    start = (100.0 * jnp.abs(x)).astype(int)
    x = x + _of_last_column(start) - _of_last_column(start)
    total = jax.lax.fori_loop(0, 3, lambda k, t: t + row(start + k)[0], 0.0)
    return total + jax.lax.cond(x > 0.0, lambda: row(start)[1], lambda: 0.0) + HELD[3, 2]


def test_a_large_constant_is_one_table_of_the_columns_that_are_read(tools, tmp_path):
    compiled = tools.Compiled(
        emit("held", [Entry("held", interpolated, {"x": 1.0}, ("y",))]), tmp_path
    )
    # two functions read columns 1 and 3 of 4 at computed rows, one of them two rows at once
    assert compiled.module.source.count("static const double") == 1
    assert "\nstatic const double constant_table[1200] = {" in compiled.module.source
    assert repr(HELD[7, 3].item()) in compiled.module.source
    assert repr(HELD[7, 2].item()) not in compiled.module.source
    x = np.linspace(-7.0, 7.0, LANES)
    status, found = compiled("held", {"x": x})
    assert not status.any()
    expected = jax.jit(jax.vmap(interpolated))(x)
    np.testing.assert_allclose(found["y"][0], expected, rtol=1e-14, atol=1e-14)


def test_what_a_struct_cannot_hold_is_refused():
    for bad, found in ((np.ones((200, 200)), "200"), (np.ones(2, np.float32), "float32")):
        with pytest.raises(InputError, match=found):
            emit("bad", [Entry("bad", large_input, {"x": bad}, ("y",))])
    with pytest.raises(InputError, match="no number"):
        emit("bad", [Entry("bad", lambda x: x[0], {"x": (1.0, "text")}, ("y",))])
    with pytest.raises(InputError, match="another shape"):
        emit("bad", [Entry("bad", lambda x: (x, x[0]), {"x": (1.0,)}, ("y", "x"))])
    with pytest.raises(InputError, match="unused name of C"):
        emit("bad", [Entry("bad", lambda x: x, {"x": 1.0}, ("status",))])


def test_tuples_within_tuples_that_return_as_they_came_have_one_struct():
    def step(memory, x):
        """Count and add up."""
        (count, total), _ = memory
        return ((count + 1, total + x), x)

    entry = Entry("step", step, {"memory": ((0, 0.0), 0.0), "x": 1.0}, ("memory",))
    assert emit("counted", [entry]).header.count("typedef struct") == 2
