"""Source lines of operations."""

import linecache
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen import source
from gyrostat.codegen.flight import Entry, emit
from gyrostat.core.jax64 import jax, jnp


@jax.jit
def squared(matrix):
    """A function with arrays that are too large for arguments of a function in C."""
    return jnp.sum(matrix @ matrix)


@jax.custom_jvp
def mirrored(matrix):
    """A function with a derivative of its own."""
    return jnp.sum(matrix - matrix.T)


mirrored.defjvp(lambda matrices, changes: (mirrored(*matrices), mirrored(*changes)))


@pytest.mark.parametrize(
    ("function", "line"),
    [(squared, "jnp.sum(matrix @ matrix)"), (mirrored, "jnp.sum(matrix - matrix.T)")],
    ids=["jitted", "with a derivative"],
)
def test_functions_that_are_written_where_they_are_called_keep_their_lines(function, line):
    entry = Entry("step", lambda matrix: function(matrix), {"matrix": np.ones((9, 9))}, ("total",))
    assert line in emit("part", [entry]).source


def test_threads_may_look_up_lines_at_the_same_time():
    """The parser of CPython 3.11 fails where two threads are inside it."""
    files = [str(file) for file in sorted(Path(source.__file__).parent.rglob("*.py"))]
    list(map(linecache.getlines, files))
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(source._syntax_tree.__wrapped__, 4 * files))
    finally:
        sys.setswitchinterval(before)
    assert all(tree is not None and tree.body for tree in found)
