"""Functions of C read large arguments where the caller has them, unless the entry changes them."""

import re

import numpy as np

from gyrostat.codegen.flight import Entry, emit
from gyrostat.core.jax64 import jax, jnp

LENGTH, RUNS = 100, 7


@jax.jit
def looked_up(table, gains, place, factor):
    return factor * table[place.astype(int)] + jnp.sum(gains * gains)


@jax.jit
def scaled(table, gains, place):
    return looked_up(table, gains, place, 2.0) + looked_up(table, gains, place + 1.0, -3.0)


def sums(table, other, gains, place):
    """One table in three calls, another one in one."""
    difference = looked_up(other, gains, place, 1.0) - looked_up(table, gains, place, 0.5)
    return scaled(table, gains, place), difference


def moved(table, place):
    """The table changes between two calls."""
    first = scaled(table, table[:20], place)
    later = table.at[3].set(first).at[place.astype(int)].set(1.0)
    return later, scaled(later, later[:20], place)


def test_calls_with_the_same_table_are_of_one_function(tools, tmp_path):
    table, gains = np.zeros(LENGTH), np.zeros(20)
    given = {"table": table, "other": table, "gains": gains, "place": np.zeros(())}
    entries = [
        Entry("sums", sums, given, ("sum", "difference")),
        Entry("moved", moved, {"table": table, "place": np.zeros(())}, ("table", "value")),
    ]
    module = emit("tables", entries)
    compiled = tools.Compiled(module, tmp_path)
    random = np.random.default_rng(3)
    drawn = {name: random.standard_normal((RUNS, np.size(x))) for name, x in given.items()}
    drawn["place"] = random.integers(0, LENGTH - 1, RUNS).astype(float)
    for function, entry in ((sums, entries[0]), (moved, entries[1])):
        arguments = {name: drawn[name] for name in entry.arguments}
        status, found = compiled(entry.name, arguments)
        assert not status.any()
        expected = jax.vmap(function)(*arguments.values())
        for name, values in zip(entry.results, expected, strict=True):
            np.testing.assert_allclose(found[name][0], values, rtol=1e-13, atol=1e-13)
    heads = re.findall(r"^static .*?\b(looked_up\w*|scaled)\((.*)", module.source, re.MULTILINE)
    assert [name for name, _ in heads] == ["looked_up", "looked_up_2", "scaled"]
    # the arguments of the entry as they are, and the numbers that differ from call to call
    assert heads[0][1].startswith("const double other[100], const double gains[20], double place")
    assert heads[1][1].startswith("const double table[100], const double gains[20], double place")


@jax.jit
def spread(values, factor):
    return jnp.sum(values * factor)


def repeated(gain, factor):
    values = jnp.broadcast_to(gain, 20)
    return spread(values, factor) - spread(values, -2.0 * factor)


def summed(table, factor):
    return spread(table, factor) - spread(table, -2.0 * factor)


def test_entries_give_arguments_of_one_name_with_their_own_types(tools, tmp_path):
    cases = {
        "real": (repeated, {"gain": np.zeros(())}),
        "whole": (repeated, {"gain": np.zeros((), np.int64)}),
        "short": (summed, {"table": np.zeros(100)}),
        "long": (summed, {"table": np.zeros(200)}),
    }
    entries = [
        Entry(f"of_{name}", function, {**example, "factor": np.zeros(())}, ("value",))
        for name, (function, example) in cases.items()
    ]
    compiled = tools.Compiled(emit("types", entries), tmp_path)
    random = np.random.default_rng(4)
    for entry in entries:
        arguments = {
            name: random.uniform(-9.0, 9.0, (RUNS, *x.shape)).astype(x.dtype)
            for name, x in entry.arguments.items()
        }
        _, found = compiled(entry.name, arguments)
        expected = jax.vmap(entry.function)(*arguments.values())
        np.testing.assert_allclose(found["value"][0], expected, rtol=1e-12, atol=1e-11)


@jax.jit
def table(place):
    return jnp.sin(place) * place


@jax.jit
def with_table(values, place):
    return values[3] * table(place) + table(place + 1.0) + jnp.sum(values)


def around(values, place):
    return with_table(values, place) + with_table(values, place + 1.0) + table(place + 2.0)


def test_a_function_may_have_the_name_of_an_argument(tools, tmp_path):
    entry = Entry("around", around, {"table": np.zeros(20), "place": np.zeros(())}, ("value",))
    compiled = tools.Compiled(emit("names", [entry]), tmp_path)
    random = np.random.default_rng(5)
    arguments = {"table": random.uniform(size=(RUNS, 20)), "place": random.uniform(size=RUNS)}
    _, found = compiled("around", arguments)
    expected = jax.vmap(around)(*arguments.values())
    np.testing.assert_allclose(found["value"][0], expected, rtol=1e-12)
