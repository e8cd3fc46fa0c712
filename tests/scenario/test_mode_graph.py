"""Proof on the graph of the modes, against powers of its adjacency matrix."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gyrostat.core.errors import InputError
from gyrostat.scenario import mode_graph
from gyrostat.scenario.mode_graph import GraphEdge


@st.composite
def graphs(draw):
    """Number of modes, and edges: start, end, time, taken once."""
    count = draw(st.integers(2, 6))
    mode = st.integers(0, count - 1)
    edge = st.tuples(mode, mode, st.sampled_from([0.0, 0.0, 2.0]), st.booleans())
    return count, draw(st.lists(edge, min_size=1, max_size=12))


def joined(count, pairs):
    """Whether a path of one or more edges leads from each mode to each other, (modes, modes)."""
    adjacent = np.zeros((count, count), int)
    for start, end in pairs:
        adjacent[start, end] = 1
    paths, power = np.zeros_like(adjacent), np.eye(count, dtype=int)
    for _ in range(count):
        power = np.minimum(power @ adjacent, 1)
        paths |= power
    return paths.astype(bool)


@given(graphs())
@example((3, [(0, 1, 0.0, False), (0, 2, 0.0, False), (1, 1, 0.0, True)]))
def test_the_proof_is_that_of_powers_of_the_adjacency_matrix(graph):
    count, rows = graph
    names = [f"m{k}" for k in range(count)]
    every = [
        GraphEdge(f"e{k}", names[start], names[end], time, once=once)
        for k, (start, end, time, once) in enumerate(rows)
    ]
    paths = joined(count, [row[:2] for row in rows])
    lost = [name for k, name in enumerate(names) if k and not paths[0, k]]
    instant = [row[:2] for row in rows if row[2] == 0.0 and not row[3]]
    circular = np.diag(joined(count, instant))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mode_graph, "modes", lambda _: names)
        patch.setattr(mode_graph, "edges", lambda _: every)
        message = _checked()
    if lost:
        assert f"reference.mode.{lost[0]}: found no path" in message
    elif circular.any():
        cycle = message.split("in no time, ")[1].partition(", expected")[0].split(" -> ")
        numbers = [names.index(name) for name in cycle]
        assert numbers[0] == numbers[-1]
        assert all(pair in instant for pair in pairwise(numbers))
    else:
        # a change from a mode to itself is no exit
        left = {start for start, end, *_ in rows if end != start}
        final = [name for k, name in enumerate(names) if k not in left]
        assert f"final: {', '.join(final) or 'none'};" in message


def _checked():
    """Result of the proof, or why it fails."""

    class Scenario:
        parts = ()

    try:
        return mode_graph.check_modes(Scenario())  # pyright: ignore[reportArgumentType]
    except InputError as error:
        return str(error)
