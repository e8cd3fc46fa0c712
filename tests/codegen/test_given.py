"""Functions of C read large arguments where the caller has them, unless the entry changes them."""

import re
from typing import Any, NamedTuple

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


class Springs(NamedTuple):
    """Springs of a mechanism."""

    stiffness: Any
    damping: Any
    slack: Any


class Mechanism(NamedTuple):
    """A part inside a part."""

    suspension_of_the_mechanism: Any


class Machine(NamedTuple):
    """Two mechanisms."""

    forward_mechanism: Any
    backward_mechanism: Any


def pulled(machine, x):
    """Only the springs of the mechanism in front change."""
    front = machine.forward_mechanism.suspension_of_the_mechanism
    back = machine.backward_mechanism.suspension_of_the_mechanism
    force = front.stiffness * x + front.damping * x**3 + jnp.where(x > front.slack, x, back.slack)
    force = force + back.stiffness * (x - back.slack) + back.damping * (x**3 - back.slack)
    moved = Mechanism(Springs(front.stiffness + 1.0, front.damping * x, back.slack))
    return machine._replace(forward_mechanism=moved), force


def test_members_with_long_paths_are_read_and_set_by_pointers(tools, tmp_path):
    springs = Mechanism(Springs(*np.zeros((3, 1))))
    machine = Machine(springs, springs)
    example = jax.tree.map(lambda leaf: leaf[0], machine)
    entry = Entry("pull", pulled, {"machine": example, "x": 0.0}, ("machine", "force"))
    module = emit("pulling", [entry])
    front, back = "forward_mechanism", "backward_mechanism"
    declared = re.findall(r"(?:const )?Springs \*const (\w+) =\s+&machine->(\w+)", module.source)
    assert [place for _, place in declared] == [front, back]
    assert re.search(rf"const Springs \*const {declared[1][0]} ", module.source)
    assert not re.search(rf"const Springs \*const {declared[0][0]} ", module.source)
    compiled = tools.Compiled(module, tmp_path)
    random = np.random.default_rng(4)
    drawn = random.standard_normal((RUNS, 7))
    parts = [Mechanism(Springs(*drawn[:, k : k + 3].T)) for k in (0, 3)]
    status, found = compiled("pull", {"machine": Machine(*parts), "x": drawn[:, 6]})
    assert not status.any()
    machine, force = jax.vmap(pulled)(Machine(*parts), drawn[:, 6])
    for leaf, values in zip(found["machine"], jax.tree.leaves(machine), strict=True):
        np.testing.assert_allclose(leaf, values, rtol=1e-14)
    np.testing.assert_allclose(found["force"][0], force, rtol=1e-14)


@jax.jit
def chosen(values, works):
    return jnp.sum(jnp.where(works, values, 0.5 * values) ** 2)


def of_flags(values, works):
    every = jnp.ones(4, dtype=bool)
    return chosen(values, every) + chosen(-2.0 * values, every), chosen(values, works)


def test_flags_that_are_all_true_leave_the_branches_of_a_function_out(tools, tmp_path):
    given = {"values": np.zeros(4), "works": np.zeros(4, dtype=bool)}
    module = emit("flags", [Entry("of_flags", of_flags, given, ("all", "some"))])
    random = np.random.default_rng(5)
    values, works = random.standard_normal((RUNS, 4)), random.random((RUNS, 4)) < 0.5
    status, found = tools.Compiled(module, tmp_path)("of_flags", {"values": values, "works": works})
    assert not status.any()
    for name, expected in zip(("all", "some"), jax.vmap(of_flags)(values, works), strict=True):
        np.testing.assert_allclose(found[name][0], expected, rtol=1e-14)
    source = re.sub(r"/\*.*?\*/", "", module.source, flags=re.S)
    bodies = re.findall(r"^static double (chosen\w*)\((.*?)^}", source, re.M | re.S)
    assert [name for name, _ in bodies] == ["chosen", "chosen_2"]
    assert "works" not in bodies[0][1]
    assert "?" not in bodies[0][1]
    assert "works" in bodies[1][1]
