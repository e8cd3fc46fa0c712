"""Tolerances of the test program follow the conditioning of the test run, not of the algorithm."""

from typing import NamedTuple

import numpy as np
import pytest

from gyrostat.core.jax64 import jnp
from gyrostat.exports.check_program import TOLERANCE, scales
from gyrostat.exports.folder import emitted
from gyrostat.exports.target import STEPS, flight_module
from gyrostat.exports.vectors.vectors import nominal_vectors

UNIT = 2.0**-52
BASE = 1.0 + np.linspace(0.1, 0.9, STEPS)


class Gains(NamedTuple):
    """Parameter of the law."""

    gain: float


def law(gains, memory, measured, reference):
    """A small difference, a product, a sum of small differences, and all of them made large."""
    difference = measured - reference
    total = memory + difference
    return total, difference, measured * reference, gains.gain * difference


@pytest.fixture(scope="module")
def vectors():
    target = flight_module(
        "law",
        {"gains": Gains(1e9)},
        {"memory": jnp.asarray(0.0)},
        [("start", lambda: jnp.asarray(0.0), ("memory",))],
        [("step", law, ("memory", "difference", "product", "large"))],
        title="A law",
        period=0.1,
        constants={},
        inputs={"measured": BASE * (1.0 + 1e-5), "reference": BASE},
    )
    return nominal_vectors(target, emitted(target, "double"), "double")


def outputs(vectors):
    return {f.name: k for k, f in enumerate(vectors.fields) if f.role in ("state", "output")}


def test_a_difference_is_known_to_the_rounding_of_its_operands(vectors):
    place = outputs(vectors)["difference"]
    # each operand moves by a unit in the last place, up or down
    assert UNIT * np.max(BASE) <= vectors.changes[place] <= 2.2 * UNIT * np.max(BASE)
    largest = np.max(np.abs(vectors.values[:, place]))
    (scale,) = scales(vectors, [place], "double")
    assert scale == pytest.approx(4.0 * vectors.changes[place] / TOLERANCE["double"])
    assert scale > 100.0 * largest


def test_errors_of_a_memory_accumulate(vectors):
    places = outputs(vectors)
    assert vectors.changes[places["memory"]] > 2.0 * vectors.changes[places["difference"]]


def test_a_well_conditioned_result_has_its_own_size(vectors):
    place = outputs(vectors)["product"]
    (scale,) = scales(vectors, [place], "double")
    assert scale == np.max(np.abs(vectors.values[:, place]))
