"""From a function to a program of scalars, executed by Python: no compiler, no wheel."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen import Lowering, trace
from gyrostat.codegen.program import Assign, Branch, Call, Function, Loop, Name, statements
from gyrostat.codegen.prune import prune
from gyrostat.codegen.scope import FLIGHT
from gyrostat.codegen.source import NOWHERE
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

X, Y = np.array([0.3, -1.2, 2.5]), np.array([1.1, 0.4, -0.7])


def lowered(function, *examples, scope=FLIGHT):
    """A function of arrays as a function of scalars, and the inner functions before it."""
    traced, lowering, block = trace(function, examples, function.__name__), Lowering(scope), []
    inputs = []
    for number, atom in enumerate(traced.jaxpr.jaxpr.invars):
        names = np.empty(atom.aval.shape, object)
        for place in np.ndindex(names.shape):
            names[place] = Name(FLIGHT.kind(atom), f"x{number}", number, place)
        inputs.append(names)
    results = lowering.graph(traced.jaxpr, inputs, block)
    parameters, found = ([each for a in arrays for each in a.flat] for arrays in (inputs, results))
    return Function(function.__name__, parameters, block, found), lowering.functions


@pytest.fixture(scope="module")
def evaluate(module_at):
    return module_at(Path(__file__).with_name("evaluate.py")).evaluate


def operations(function):
    return [s.operation for s in statements(function.body) if isinstance(s, Assign)]


def moves(x, y):
    return jnp.cross(x, y), jnp.outer(x, y).T[::2, 1:].sum(axis=0), jnp.where(x > y, x, -y)


def table(x, y):
    place = (x[0] > 0.0).astype(int) + (y[0] > 0.0).astype(int)
    return x[place], jnp.floor(jnp.stack([x, y])[1, place])


def scans(x, y):
    def step(total, each):
        return 0.5 * total + each[0], total * each[1]

    total, seen = jax.lax.scan(step, x[0], (x, y))
    return total, seen, jax.lax.scan(step, total, (y, x), reverse=True)


def swaps(x, y):
    return jax.lax.fori_loop(0, 5, lambda k, c: (c[1], c[0] + k), (x[1], y[1]))


def ends_before(x, y):
    def goes_on(carry):
        return (carry[0] > 0.5) & (carry[1] < 50)

    return jax.lax.while_loop(goes_on, lambda c: (0.7 * c[0], c[1] + 1), (x[2], 0))


def branches(x, y):
    ways = [lambda a: a, lambda a: a * a, lambda a: -a]
    number = (x[0] > y[0]).astype(int) * 5 - 1
    return jax.lax.switch(number, ways, x[2]), jax.lax.cond(x[0] > 0, jnp.sin, jnp.cos, y[0])


@jax.jit
def _both(x, unused):
    return x * x, x + 1.0, unused


def calls(x, y):
    return _both(x[0], y[0])[0] - _both(y[1], x[1])[0]


@pytest.mark.parametrize(
    "function", [moves, table, scans, swaps, ends_before, branches, calls], ids=lambda f: f.__name__
)
@pytest.mark.parametrize("given", [(X, Y), (Y, X), (-X, X * Y)], ids=["one", "other", "third"])
def test_the_program_computes_what_the_function_does(function, given, evaluate):
    program, inner = lowered(function, X, Y)
    leaves = jax.tree.leaves(jax.jit(function)(*given))
    expected = np.concatenate([np.ravel(leaf) for leaf in leaves])
    found = evaluate(program, np.concatenate(given).tolist())
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-15)
    prune([*inner, program], [program])
    assert evaluate(program, np.concatenate(given).tolist()) == found


@pytest.mark.parametrize("given", [X, -X, np.array([9.0, 0.4, 70.0])], ids=str)
def test_rows_of_a_batch_leave_a_loop_one_by_one(given, evaluate):
    @jax.vmap
    def halved(x):
        return jax.lax.while_loop(
            lambda c: c[0] > 0.5, lambda c: (0.7 * c[0] * c[1][0], c[1][::-1]), (x, x * X[:2] + 0.9)
        )

    program, _ = lowered(halved, X, scope=replace(FLIGHT, unbounded=True))
    expected = np.concatenate([np.ravel(leaf) for leaf in halved(given)])
    np.testing.assert_allclose(evaluate(program, given.tolist()), expected, rtol=1e-14)
    with pytest.raises(InputError, match="a loop without a bound"):
        lowered(halved, X)


def test_control_flow_stays_and_arrays_do_not():
    kinds = {
        f: [type(s) for s in lowered(f, X, Y)[0].body] for f in (scans, swaps, branches, calls)
    }
    assert kinds[scans].count(Loop) == 2
    assert kinds[swaps].count(Loop) == 1
    assert kinds[branches].count(Branch) == 2
    assert kinds[calls].count(Call) == 2
    loop = next(s for s in lowered(ends_before, X, Y)[0].body if isinstance(s, Loop))
    assert (loop.count, loop.goes_on is None) == (50, False)
    assert operations(lowered(moves, X, Y)[0]).count("select") == 3


def test_constants_fold_and_a_factor_of_one_goes():
    program, _ = lowered(lambda x: 1.0 * x + jnp.sum(jnp.array([2.0, 3.0])) * 0.0, 1.0)
    assert operations(program) == ["add"]
    program, _ = lowered(lambda x: jnp.where(jnp.array(True), x, jnp.sin(x)), 1.0)
    assert program.results == program.parameters


def test_what_nobody_needs_is_pruned():
    program, inner = lowered(calls, X, Y)
    (both,) = inner
    assert (len(both.parameters), len(both.results)) == (2, 3)
    left = prune([*inner, program], [program])
    assert left == [both, program]
    assert (len(both.parameters), len(both.results)) == (1, 1)
    assert operations(both) == ["mul"]


def test_each_statement_knows_its_line_of_python():
    program, _ = lowered(branches, X, Y)
    sources = {s.source for s in statements(program.body)} - {NOWHERE}
    assert {source.file for source in sources} == {"test_lowering.py"}
    assert any(source.name == "number" and "* 5 - 1" in source.text for source in sources)
    assert {source.part for source in sources} == {"branches"}


KEPT = []


def counts(x):
    KEPT.append(0)
    return x + len(KEPT)


@pytest.mark.parametrize(
    ("function", "found"),
    [
        (lambda x: x if x > 0.0 else -x, "needs the value of an input"),
        (lambda x: jnp.arange(3.0)[jnp.arange(3.0) < x], "shape that depends on data"),
        (lambda x: jax.debug.print("{}", x), "an effect on the outside"),
        (counts, "no side effect"),
        (lambda x: x + "text", "found TypeError"),
    ],
)
def test_what_is_no_function_of_arrays_is_not_traced(function, found):
    with pytest.raises(InputError, match=found):
        trace(function, (1.0,), "step")


def test_a_number_that_is_none_is_refused():
    with pytest.raises(InputError, match="a leaf that is no number"):
        trace(lambda x: x[0], ((1.0, "text"),), "step")
