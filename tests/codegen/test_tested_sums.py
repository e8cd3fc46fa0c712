"""Tests that all of several numbers are finite: they find each number, and bound the analysis."""

import re

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.control.guarded import finite
from gyrostat.core.jax64 import jax, jnp

COUNT, ROWS = 21, 5


def doubled(values, matrix):
    """Whether twice the numbers of two arrays are finite."""
    return finite((2.0 * values, jnp.float64(2.0) * matrix))


@pytest.fixture(scope="module")
def module():
    arguments = {"values": np.zeros(COUNT), "matrix": np.zeros((ROWS, ROWS))}
    return emit("tested", [Entry("doubled", doubled, arguments, ("is_tested",))])


@pytest.fixture(scope="module")
def compiled(module, tools, tmp_path_factory):
    return tools.Compiled(module, tmp_path_factory.mktemp("tested"))


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1.5e308, -1.5e308])
def test_each_number_that_is_not_finite_is_found(wrong, compiled):
    total = COUNT + ROWS**2
    numbers = np.random.default_rng(0).normal(size=(total + 1, total))
    numbers[np.arange(total), np.arange(total)] = wrong
    values, matrices = numbers[:, :COUNT], numbers[:, COUNT:].reshape(-1, ROWS, ROWS)
    _, results = compiled("doubled", {"values": values, "matrix": matrices})
    assert results["is_tested"][0].tolist() == [False] * total + [True]


def test_an_infinite_number_and_its_opposite_are_not_finite(compiled):
    values = np.zeros((1, COUNT))
    values[0, [3, 4]] = np.inf, -np.inf
    _, results = compiled("doubled", {"values": values, "matrix": np.zeros((1, ROWS, ROWS))})
    assert results["is_tested"][0].tolist() == [False]


def test_one_result_at_a_time_keeps_states_of_the_analysis_apart(module):
    most, kept = 0, set()
    for annotation in re.findall(r"/\*@ ghost .*?\*/", module.source, re.DOTALL):
        kept |= set(re.findall(r"split (\w+);", annotation))
        kept -= set(re.findall(r"merge (\w+);", annotation))
        most = max(most, len(kept))
    assert most <= 2
    assert len(kept) == 1


def test_loops_that_set_tables_are_unrolled_by_the_analysis():
    def stacked(values):
        return jax.lax.scan(lambda total, x: (total + x, total * x), 0.0, values)[1]

    def summed(values):
        return jax.lax.fori_loop(0, 50, lambda k, total: jnp.sin(total) + k, values[0])

    arguments = {"values": np.zeros(40)}
    source = emit("tables", [Entry("stacked", stacked, arguments, ("rows",))]).source
    assert re.search(r"/\*@ loop unroll 40; \*/\n +for \(", source)
    source = emit("tables", [Entry("summed", summed, arguments, ("total",))]).source
    assert "for (" in source
    assert "loop unroll" not in source
