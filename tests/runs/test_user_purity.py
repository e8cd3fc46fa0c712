"""Parts of a user that are not pure: each gives one line with the line of the user's file."""

import jax
import numpy as np
import pytest

from gyrostat.codegen.comparison import first_difference
from gyrostat.core.errors import InputError
from gyrostat.scenario_files.scenario_file import read_scenario
from tests.runs.controller_text import source

CACHED = "@functools.cache\ndef helper():\n    return np.random.rand()\n"
JITTED = "@jax.jit\ndef helper(x):\n    a = np.random.rand(4)\n    return a * x\n"
KEPT = {
    "value of the run in a list": (("LOG.append(y.rate)", "w = 1.0"), "keeps a value of the run"),
    "value of the run in a global": (
        ("global LAST", "LAST = y.rate", "w = 1.0"),
        "keeps a value of the run in LAST",
    ),
    "value of the run in a global, once": (
        ("global LAST", "LAST = y.rate if LAST is None else LAST", "w = 1.0"),
        "keeps a value of the run in LAST",
    ),
    "value of the run in the class": (("P.last = y.rate", "w = 1.0"), "keeps a value of the run"),
    "counter": (("global COUNT", "COUNT += 1", "w = COUNT"), "changes COUNT"),
    "counter without effect yet": (
        ("global COUNT", "COUNT += 1", "w = 2.0 if COUNT > 1000 else 1.0"),
        "changes COUNT",
    ),
    "text in a list": (("LOG.append('called')", "w = 1.0"), "changes LOG"),
    "counter in the object": (
        ("object.__setattr__(self, 'n', getattr(self, 'n', 0) + 1)", "w = self.n"),
        "gives 2e-06 in one trace and 3e-06 in another",
    ),
    "numbers of NumPy": (("w = np.random.rand(4)",), "changes the random generators of numpy"),
    "address": (("w = id(object()) % 1009 + time.perf_counter()",), "in one trace and"),
    "time": (("w = y.rate[0] * time.perf_counter()",), "in one trace and"),
    "branch": (("w = jnp.sin(y.rate[0]) if next(ODD) % 2 else 1.0",), "changes ODD"),
}
LOADED = {
    "numbers of NumPy in a module": ("w = A[0]", "A = np.random.rand(4)\n", "A = np.random"),
    "numbers of NumPy in a cache": ("w = helper()", CACHED, "return np.random.rand()"),
    "numbers of NumPy in a jitted function": ("w = helper(y.rate[0])", JITTED, "a = np.random"),
}
PURE = {
    "cache of a constant": source("w = MEMO.setdefault('w', np.ones(4))"),
    "numbers of a fixed seed": source("w = np.random.default_rng(1).normal(size=4)"),
    "numbers of a fixed seed in a module": source(
        "w = A", below="A = np.random.default_rng(0).normal(size=4)\n"
    ),
    "jitted function and partial": source(
        "w = functools.partial(helper, 2.0)(y.rate[0])",
        below="@jax.jit\ndef helper(g, x):\n    return g * x\n",
    ),
    "text printed": source("print('called')", "w = 1.0"),
}


@pytest.fixture
def read(folder, short):
    """Reads the scenario with a text of own.py."""

    def with_text(text):
        (folder / "own.py").write_text(text)
        return read_scenario(short())

    return with_text


@pytest.mark.parametrize(("lines", "expected"), KEPT.values(), ids=KEPT)
def test_a_part_that_is_not_pure_is_refused_with_its_line(read, lines, expected):
    text = source(*lines, below="import time\nODD = itertools.count()\n")
    with pytest.raises(InputError) as caught:
        read(text)
    message = str(caught.value)
    culprit = lines[-2] if lines[-1] in ("w = 1.0", "w = COUNT", "w = self.n") else lines[-1]
    culprit = "COUNT += 1" if "COUNT" in expected else culprit
    number = text.splitlines().index(f"        {culprit}") + 1
    assert f"controller own.py:P, line {number}: found `{culprit}`, which " in message
    assert expected in message
    assert "\n" not in message


@pytest.mark.parametrize(("line", "below", "culprit"), LOADED.values(), ids=LOADED)
def test_numbers_that_differ_when_the_file_is_loaded_again_are_refused(read, line, below, culprit):
    """JAX traces a jitted function once, and a module is executed once in a process."""
    with pytest.raises(InputError, match="in one trace and") as caught:
        read(source(line, below=below))
    assert f"found `{culprit}" in str(caught.value)


@pytest.mark.parametrize("text", PURE.values(), ids=PURE)
def test_a_pure_part_is_read(read, text):
    assert read(text).controller == "own.py:P"


def test_traces_are_compared_by_their_values_and_not_by_names_of_variables():
    def traced(table, *, first="sin"):
        functions = [jax.numpy.sin, jax.numpy.cos]
        made = functions if first == "sin" else functions[::-1]
        return jax.make_jaxpr(lambda x: jax.lax.cond(x[0] > 0.0, *made, x) * table)(np.ones(3))

    table = np.arange(3.0)
    assert first_difference(traced(table), traced(table.copy())) is None
    assert "cos" in str(first_difference(traced(table), traced(table, first="cos")))
    changed = first_difference(traced(table), traced(table + np.array([0.0, 0.0, 1e-15])))
    assert changed is not None
    assert changed.found != changed.other
