"""State that an entry of flight C reads and sets: each result is of the state before the call."""

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.core.jax64 import jax, jnp

LANES, SIZES = 5, (3, 9, 20, 70)


def added(a, b):
    """Elements of a vector, some of them of a table, are added at computed indices."""
    index, n = (3.0 * b).astype(int), a.size
    read = b.at[index].get(mode="clip")
    values = jnp.concatenate([jax.lax.dynamic_slice(read, (n - 2,), (2,)), a[2:]])
    return a.at[index].add(values, mode="clip"), b


def of_vectors(n):
    """Updates of two vectors."""
    grid, few = jnp.linspace(-2.0, 2.0, n), max(n // 4, 2)
    return {
        "first": lambda a, b: (a - a[0], b + a[n - 1] * b[0]),
        "other": lambda a, b: (a + b[1], b + a[0]),
        "swap": lambda a, b: (b, a),
        "reversed": lambda a, b: (b[::-1], a * b[0]),
        "table": lambda a, b: (jnp.interp(b, grid, a), a),
        "itself": lambda a, b: (jnp.interp(a, grid, a), b / jnp.max(jnp.abs(b))),
        "part": lambda a, b: (
            jax.lax.dynamic_update_slice(b, a[:few], (jnp.argmax(a),)),
            jax.lax.dynamic_update_slice(a, a[-few:] * b[0], (jnp.argmax(b),)),
        ),
        "sums": lambda a, b: (jnp.cumsum(b).at[1].set(a[0] * 2.0).at[n - 1].set(a[1] + b[0]), a),
        "set": lambda a, b: (
            jnp.concatenate([b.at[jnp.argmax(a)].set(b[0])[1:], a[:1] * 2.0]),
            b.at[jnp.argmin(b)].add(a[0]),
        ),
        "added": added,
        "repeated": lambda a, b: (b + jnp.resize(a[:2], n), jnp.resize(b[:2], n) - a),
    }


def kalman(P, s):
    """Update of covariance and state by a measurement of the first component."""
    gain = P[:, 0] / (1.0 + P[0, 0] ** 2)
    return P - jnp.outer(gain, P[0]), s + gain * (0.3 - s[0])


def of_matrices(n):
    """Updates of a matrix and a vector."""
    return {
        "rank_one": lambda P, s: (P - jnp.outer(P[:, 0], P[0]) * 0.1, s + P[0, 1]),
        "row": lambda P, s: (P - P[0], s),
        "column": lambda P, s: (P - P[:, :1], s * P[n - 1, n - 1]),
        "kalman": kalman,
        "transposed": lambda P, s: (P.T + s, P[:, 1]),
    }


def updates():
    """Name -> update, and its state."""
    for n in SIZES:
        for name, update in of_vectors(n).items():
            yield f"{name}_{n}", update, ((n,), (n,))
    for n in (3, 9, 20):
        for name, update in of_matrices(n).items():
            yield f"{name}_{n}", update, ((n, n), (n,))


UPDATES = {name: (update, shapes) for name, update, shapes in updates()}


@pytest.fixture(scope="module")
def program(tools, tmp_path_factory):
    entries = [
        Entry(
            f"{name}_of",
            lambda state, update=update: (update(*state), state[0].ravel()[0]),
            {"state": tuple(np.zeros(shape) for shape in shapes)},
            ("state", "before"),
        )
        for name, (update, shapes) in UPDATES.items()
    ]
    return tools.Compiled(emit("states", entries), tmp_path_factory.mktemp("states"))


@pytest.mark.parametrize("name", UPDATES)
def test_a_new_state_is_computed_from_the_one_before(program, name):
    update, shapes = UPDATES[name]
    random = np.random.default_rng(3)
    state = tuple(random.standard_normal((LANES, *shape)) for shape in shapes)
    status, found = program(f"{name}_of", {"state": state})
    assert not status.any()
    for ours, theirs in zip(found["state"], jax.vmap(update)(*state), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(found["before"][0], state[0].reshape(LANES, -1)[:, 0])


def turned(values):
    """New values chosen by a branch, and a number of the old ones on the same line of Python."""
    # fmt: off
    return (lambda old, new: (new, old + 1.0))(values[0] * 2.0, jax.lax.cond(values[1] > 0, lambda v: v[::-1], lambda v: v - 1.0, values))  # noqa: E501
    # fmt: on


def test_a_branch_that_sets_an_array_comes_after_what_reads_it(tools, tmp_path):
    entry = Entry("turned_of", turned, {"values": np.zeros(3)}, ("values", "after"))
    values = np.random.default_rng(4).standard_normal((LANES, 3))
    _, found = tools.Compiled(emit("turned", [entry]), tmp_path)("turned_of", {"values": values})
    for ours, theirs in zip(found.values(), jax.vmap(turned)(values), strict=True):
        np.testing.assert_array_equal(ours[0], theirs)
