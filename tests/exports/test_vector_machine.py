"""Emitted C, read back and evaluated for many inputs at once, against the same C compiled."""

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit, outlining
from gyrostat.codegen.flight.module import ports_of
from gyrostat.codegen.flight.reader.functions import functions
from gyrostat.codegen.flight.reader.translate import translate
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports.target import Target
from gyrostat.exports.vectors.machine import Machine

LANES = 64
RANDOM = np.random.default_rng(0)


def real(*shape):
    """Random numbers, some of them zero, equal to each other, infinite or NaN."""
    numbers = RANDOM.normal(size=(LANES, *shape))
    special = RANDOM.choice([0.0, -0.0, 1.0, np.inf, -np.inf, np.nan], numbers.shape)
    return np.where(RANDOM.random(numbers.shape) < 0.15, special, numbers)


@jax.jit
def inner(x, y):
    """A function of the module, with two results."""
    return jnp.where(x > y, x, jnp.sin(y)), jax.lax.cond(x < 0.0, lambda: -x, lambda: y)


def choices(x, y):
    """Selects, tests, helpers and branches one in the other."""
    both = (x > 0.0) & (y > 0.0) | (x == y)
    a, b = inner(x, y)
    taken = jax.lax.cond(
        both, lambda: jax.lax.cond(a > 1.0, lambda: a, lambda: b), lambda: jnp.maximum(x, y)
    )
    return jnp.where(both, jnp.clip(x, -1.0, y), jnp.sign(taken)), jnp.isfinite(taken) | both


def loops(x, n):
    """A loop that ends early, and one in the other; integers that divide and shift."""

    def ahead(state):
        y, k = state
        return y * 0.5 + jax.lax.fori_loop(
            0, 3, lambda j, z: jnp.where(z > j, z - 1.0, z), y
        ), k + 1

    y, k = jax.lax.while_loop(lambda s: (jnp.abs(s[0]) > 0.1) & (s[1] < 20), ahead, (x, 0))
    return y, k + n // 3 - n % 5 + (n << 2), jnp.where(n > 3, n, -n)


def tables(x, place):
    """Elements at computed indices, the place of the largest one, sorted and stacked values."""
    rows = jnp.stack([x, x[::-1] * 2.0])
    stacked = jax.lax.scan(lambda c, v: (c + v, c * v), 0.0, x)[1]
    replaced = x.at[place % 5].set(7.0)
    return rows[place % 2], jnp.argmax(x), jnp.sort(x)[0], stacked, replaced


TABLE = jnp.asarray(np.random.default_rng(1).normal(size=(30, 3)))


@jax.jit
def of_table(k):
    """A row of a table that its caller reads too."""
    return jax.lax.dynamic_slice(TABLE, (k, 1), (1, 2))[0]


def shared(x, place):
    """A table that two functions read."""
    return x * of_table(place).sum(), x + jax.lax.dynamic_slice(TABLE, (place, 1), (1, 1))[0, 0]


def arrays(matrix, right):
    """Arrays that are computed by loops of C."""
    square = matrix @ matrix.T + 8.0 * jnp.eye(8)
    return jnp.linalg.solve(square, right), jnp.linalg.cholesky(square)


CASES = {
    choices: {"x": real(), "y": real()},
    loops: {"x": real(), "n": RANDOM.integers(-9, 9, LANES)},
    tables: {"x": real(5), "place": RANDOM.integers(0, 12, LANES)},
    shared: {"x": real(), "place": RANDOM.integers(0, 29, LANES)},
    arrays: {"matrix": RANDOM.normal(size=(LANES, 8, 8)), "right": real(8)},
}


def module_of(function, arguments, precision):
    example = {name: array[0] for name, array in arguments.items()}
    count = len(jax.eval_shape(function, *example.values()))
    entry = Entry(function.__name__, function, example, tuple(f"out_{k}" for k in range(count)))
    target = Target("part", "", 1.0, (entry,), (entry,), {}, {})
    return target, emit("part", [entry], precision)


def columns(machine, arguments):
    """Values of all fields, one column for each lane."""
    values = np.zeros((len(machine.fields), LANES))
    for name, array in arguments.items():
        rows = [k for k, field in enumerate(machine.fields) if field.port == name]
        values[rows] = array.reshape(LANES, -1).T
    return values


def check(function, has_margins, precision, tools, folder):
    """Compare what is read back with compiled C."""
    arguments = CASES[function]
    target, module = module_of(function, arguments, precision)
    machine = Machine(target, module, precision)
    machine.most_passes = 1000
    values = columns(machine, arguments)
    found = machine.run(values, lambda *_: None, begins=False, has_margins=has_margins)
    program = tools.Compiled(module, folder, precision=precision)
    status, results = program(function.__name__, arguments)
    assert not status.any()
    for name in [name for name, port in ports_of(module).items() if port.set]:
        rows = [k for k, field in enumerate(machine.fields) if field.port == name]
        expected = np.concatenate([np.reshape(leaf, (LANES, -1)) for leaf in results[name]], 1).T
        seen = found[rows]
        if precision == "double":
            same = (seen == expected) | (np.isnan(seen) & np.isnan(expected))
            with np.errstate(invalid="ignore"):  # equal infinite numbers
                near = np.abs(seen - expected) <= 1e-15 * np.abs(expected)
            assert np.all(same | near)
            continue
        # the elementary functions of single precision are rounded in another way
        assert np.allclose(seen, expected, 1e-4, 1e-4, equal_nan=True)
    return module


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("function", CASES, ids=lambda f: f.__name__)
@pytest.mark.parametrize("has_margins", [False, True])
def test_lanes_have_the_results_of_compiled_c(function, has_margins, precision, tools, tmp_path):
    check(function, has_margins, precision, tools, tmp_path)


@pytest.mark.parametrize("function", [loops, arrays], ids=lambda f: f.__name__)
def test_parts_of_long_functions_have_the_results_of_compiled_c(
    function, tools, tmp_path, monkeypatch
):
    for name, value in {"LONGEST": 20, "PART": 20, "LEAST": 3, "WHOLE": 10}.items():
        monkeypatch.setattr(outlining, name, value)
    module = check(function, True, "double", tools, tmp_path)
    assert any(each.tables for each in module.functions) == (function is arrays)
    assert len(module.functions) > 1


def test_a_constant_table_is_one_array_of_all_lanes():
    """As lists of numbers, each reading would copy the whole table for every lane."""
    module = module_of(shared, CASES[shared], "double")[1]
    constants = translate(functions(module.source), ["shared"], has_margins=False).constants
    tables = [each for each in constants.values() if isinstance(each, np.ndarray)]
    assert tables
    for table in tables:
        np.testing.assert_array_equal(table.reshape(-1, 2), TABLE[:, 1:])


def test_decisions_are_recorded_with_the_lanes_that_reach_them():
    target, module = module_of(choices, CASES[choices], "double")
    machine = Machine(target, module, "double")
    reached = {}

    def record(number, lanes, path, values):
        reached.setdefault(number, np.zeros(LANES, bool))
        reached[number] |= lanes

    machine.run(columns(machine, CASES[choices]), record, begins=False)
    x, y = CASES[choices].values()
    both = ((x > 0.0) & (y > 0.0)) | (x == y)
    inside = [d for d in machine.decisions if d.kind == "if" and "1.0" in d.conditions[0]]
    assert inside
    for decision in inside:
        assert np.array_equal(reached[decision.number], both)
    sizes = [d.size for d in machine.decisions if d.function == "choices"]
    assert max(sizes) == 3  # x > 0 and y > 0, or x == y: as C writes it, in one expression
