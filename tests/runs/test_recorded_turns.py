"""Turns as the metrics of a run take them from its recorded signals."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from gyrostat.control.guidance import AttitudeReference
from gyrostat.control.guidance.around import Around
from gyrostat.core.jax64 import jnp
from gyrostat.runs.metrics.observer import Observer

MODES = MEASURED, FOLLOWED, KEEPS = range(3)
"""Mode whose law does not follow the reference, one whose law does, and one to turn to."""
BEFORE = AttitudeReference(
    jnp.array([0.6, 0.8, 0.0, 0.0]), jnp.array([1e-3, 0.0, 0.0]), jnp.array([0.0, 2e-4, 0.0])
)
RECORDED = jnp.array([0.0, 0.6, 0.8, 0.0]), jnp.array([0.0, 0.0, 5e-3])


class Command(NamedTuple):
    """Recorded command."""

    mode: int
    mode_start: float
    turn_from: object = RECORDED[0]
    turn_rate: object = RECORDED[1]


class Followed:
    """Reference that returns the motion from which a turn begins."""

    around = Around((), jnp.array([[0.0], [0.0], [1.0]]), 0.0, (True, False, False))

    def entered(self, mode, number, start, begin):
        return SimpleNamespace(number=number, begin=BEFORE if begin is None else begin(BEFORE))

    def at(self, mode, time):
        return mode.begin


@pytest.mark.parametrize(
    ("origin", "start", "is_measured"),
    [
        (MEASURED, 7.0, True),
        (FOLLOWED, 7.0, False),  # goes on from the reference, with its acceleration
        (MEASURED, 2.0, False),  # changed at a missing sample: recorded later, with another motion
    ],
)
def test_a_turn_begins_where_the_controller_began_it(origin, start, is_measured):
    setup = SimpleNamespace(setup=SimpleNamespace(reference=Followed()))
    row = SimpleNamespace(command=Command(KEEPS, start))
    begin, _ = Observer.reference(setup, row, 7.0, SimpleNamespace(number=origin))
    expected = AttitudeReference(*RECORDED, jnp.zeros(3)) if is_measured else BEFORE
    for ours, theirs in zip(begin, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)
