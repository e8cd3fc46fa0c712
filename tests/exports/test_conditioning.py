"""Tolerances of the test program follow the conditioning of the test run, not of the algorithm."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.codegen.flight.measure import Compiled
from gyrostat.control import AttitudePID, CurrentMode
from gyrostat.core.jax64 import jnp
from gyrostat.exports import folder
from gyrostat.exports.check_program import ROUNDING, TOLERANCE, scales
from gyrostat.exports.folder import emitted
from gyrostat.exports.target import STEPS, flight_module
from gyrostat.exports.vectors.conditioning import conditioning
from gyrostat.exports.vectors.vectors import nominal_vectors

UNIT = 2.0**-52
BASE = 1.0 + np.linspace(0.1, 0.9, STEPS)


class Gains(NamedTuple):
    """Parameter of the law."""

    gain: float


def law(gains, memory, measured, reference):
    """A sum of small differences, one of them, also made large, a product, rounding errors."""
    difference = measured - reference
    total = memory + difference
    residual = jnp.sqrt(measured) ** 2 - measured
    late = jnp.where(memory > 4.5e-4, residual, 0.0)
    pulse = jnp.where((memory < 3e-4) & (total >= 3e-4), gains.gain * measured, 0.0)
    array = jnp.stack([gains.gain * measured, residual])
    large = gains.gain * difference
    return total, difference, measured * reference, large, residual, late, pulse, array


@pytest.fixture(scope="module")
def vectors():
    target = flight_module(
        "law",
        {"gains": Gains(1e9)},
        {"memory": jnp.asarray(0.0)},
        [("start", lambda: jnp.asarray(0.0), ("memory",))],
        [
            (
                "step",
                law,
                ("memory", "difference", "product", "large", "residual", "late", "pulse", "array"),
            )
        ],
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
    assert UNIT * np.max(BASE) <= vectors.conditioning.changes[place] <= 2.2 * UNIT * np.max(BASE)
    largest = np.max(np.abs(vectors.values[:, place]))
    (scale,) = scales(vectors, [place], "double")
    assert scale == pytest.approx(4.0 * vectors.conditioning.changes[place] / TOLERANCE["double"])
    assert scale > 100.0 * largest


def test_errors_of_a_memory_accumulate(vectors):
    places = outputs(vectors)
    assert (
        vectors.conditioning.changes[places["memory"]]
        > 2.0 * vectors.conditioning.changes[places["difference"]]
    )


@pytest.mark.parametrize("name", ["residual", "late", "array[1]"])
def test_of_rounding_errors_only_the_size_is_known(vectors, name):
    places, rounding = outputs(vectors), vectors.conditioning
    noisy = [name for name, place in places.items() if rounding.are_errors[place]]
    assert noisy == ["residual", "late", "array[1]"]
    late = vectors.values[:, places["late"]]
    assert np.mean(late == 0.0) > 0.6
    place, every = places[name], [*places.values()]
    scale = scales(vectors, every, "double")[every.index(place)]
    size = max(rounding.changes[place], np.max(np.abs(vectors.values[:, place])))
    least = 0.0
    if name == "array[1]":  # as the whole of an array
        whole = np.max(np.abs(vectors.values[:, places["array[0]"]]))
        least = ROUNDING["double"] / TOLERANCE["double"] * whole
        assert least > 1e6
    assert scale == pytest.approx(max(4.0 * size / TOLERANCE["double"], least))
    assert UNIT / 4.0 < rounding.changes[place] < 4.0 * UNIT


def test_another_order_of_operations_shows_rounding_errors(vectors):
    """Those that a change of inputs and memory does not show, as they cancel in any case."""
    values, places = vectors.values.copy(), outputs(vectors)
    late = np.repeat([0.0, 1e-20, 1e-17], [21, 11, STEPS - 32])
    values[:, places["late"]] = late
    unchanged = SimpleNamespace(run=lambda rows, factor: values)
    words = unchanged, vectors.fields, vectors.rows, values, "double"
    assert not conditioning(*words).are_errors.any()
    otherwise = values.copy()
    otherwise[:, places["late"]] = 0.0
    found = conditioning(*words, otherwise)
    assert np.flatnonzero(found.are_errors).tolist() == [places["late"]]
    assert found.changes[places["late"]] == 1e-17


def test_a_well_conditioned_result_has_its_own_size(vectors):
    place = outputs(vectors)["product"]
    (scale,) = scales(vectors, [place], "double")
    assert scale == np.max(np.abs(vectors.values[:, place]))


@pytest.mark.parametrize(
    ("error", "fails"), [(1e-13, False), (1e-12, True), (np.nan, True), (0.0, True)]
)
def test_an_export_says_that_its_test_program_fails(monkeypatch, tmp_path, error, fails):
    errors = {f"command.torque[{k}]": error for k in range(8)}
    compiled = Compiled("cc 1", None, {}, errors, fails)
    monkeypatch.setattr(folder, "measure", lambda texts, name: compiled)
    said = []
    gs.export(
        CurrentMode(AttitudePID(1.0, 0.0, 3.0), 0.02), tmp_path, "c", period=0.1, say=said.append
    )
    lines = [line for line in said if "fails" in line]
    assert len(lines) == fails
    if fails:
        ending = "with this compiler." if error == 0.0 else "`command.torque[5]`, and 2 more."
        assert lines[0].endswith(ending)
