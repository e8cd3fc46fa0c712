"""A stored program serves every scenario of its structure, and no other."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from gyrostat.campaigns import native
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.native import program_of
from gyrostat.codegen.simd import compiler
from gyrostat.core.cache import private_cache
from gyrostat.core.errors import InputError
from gyrostat.runs.plans import plans_of
from gyrostat.runs.run_loop import Drawn
from gyrostat.scenario.kinds.registry import KINDS
from gyrostat.scenario.structure import structure_of

pytestmark = pytest.mark.skipif(not compiler(), reason="found no C compiler")


def changed(scenario, key, factor):
    return replace(scenario, values={**scenario.values, key: factor * scenario.values[key]})


def numbers(scenario):
    """Scenarios that differ in numbers, one kind of number each."""
    first, *others = scenario.dispersions
    rows = tuple(tuple(1.1 * x for x in row) for row in first.parameters)
    wider = replace(first, parameters=rows)
    turned = tuple(
        replace(event, target=(0.0, 1.0, 0.0, 0.0)) if event.target else event
        for event in scenario.events
    )
    return {
        "gain": changed(scenario, "controller.turn_gain", 1.1),
        "inertia": changed(scenario, "body.inertia.xx", 1.01),
        "noise": changed(scenario, "sensors.attitude_sigma", 2.0),
        "torque": changed(scenario, "environment.external_torque.x", 0.5),
        "friction": changed(scenario, "wheel.a.coulomb", 1.2),
        "time of an event": changed(scenario, "event.loss.time", 1.1),
        "start": replace(scenario, attitude=(0.0, 0.0, 0.0, 1.0)),
        "target": replace(scenario, target=(0.8, 0.6, 0.0, 0.0)),
        "target of a slew": replace(scenario, events=turned),
        "spread": replace(scenario, dispersions=(wider, *others)),
        "name": replace(scenario, name="another"),
        "percentiles": replace(scenario, percentiles=(90.0,)),
        "end of a window": changed(scenario, "window.imaging.until", 1.1),
        "exposure": changed(scenario, "window.imaging.exposure", 2.0),
    }


def structures(scenario):
    """Scenarios that differ in structure."""
    others = scenario.events[1:]
    return {
        "duration": replace(scenario, count=scenario.count + 1),
        "steps": replace(scenario, substeps=2),
        "delay": replace(scenario, command_delay=1),
        "boresight": replace(scenario, boresight=(0.0, 0.0, 1.0)),
        "full attitude": replace(scenario, boresight=None),
        "axes": replace(scenario, axes=(*scenario.axes[1:], scenario.axes[0])),
        "compensator": replace(scenario, compensator="none"),
        "events": replace(scenario, events=others),
        "order of the events": changed(scenario, "event.turn.time", 0.1),
        "dispersed": replace(scenario, dispersions=scenario.dispersions[1:]),
        "windows": replace(scenario, windows=scenario.windows[1:]),
        "boresight of a window": replace(
            scenario, windows=(replace(scenario.windows[0], boresight=None), scenario.windows[1])
        ),
    }


def flown(program, scenario, plans, runs):
    """Results of all chunks, as arrays."""
    values, keys = draw(scenario, 3, runs)
    nominal = np.array([*scenario.values.values()])
    chunks = program.chunks(nominal, Drawn(values), plans, keys, [0])
    return [np.asarray(leaf) for chunk in chunks for leaf in native.jax.tree.leaves(chunk)]


def test_scenarios_that_differ_in_numbers_share_a_program(scenario):
    names = {
        kind: native.program_name(structure_of(other), plans_of(scenario), 0)
        for kind, other in numbers(scenario).items()
    }
    name = native.program_name(structure_of(scenario), plans_of(scenario), 0)
    assert set(names.values()) == {name}


def test_scenarios_of_another_structure_have_another_program(scenario):
    plans = plans_of(scenario)
    own = native.program_name(structure_of(scenario), plans, 0)
    for kind, other in structures(scenario).items():
        assert native.program_name(structure_of(other), plans, 0) != own, kind


def test_other_options_of_jax_have_another_program(scenario, monkeypatch):
    structure, plans = structure_of(scenario), plans_of(scenario)
    before = native.program_name(structure, plans, 0)
    # the noise of searches has parts
    assert native.program_name(structure, plans, 121) != before
    monkeypatch.setenv("JAX_DEFAULT_MATMUL_PRECISION", "bfloat16")
    assert native.program_name(structure, plans, 0) != before


@pytest.fixture(scope="module")
def trace(scenario):
    """The program of the scenario, traced."""
    return native.trace(structure_of(scenario), plans_of(scenario), 0)


def test_a_stored_program_gives_the_bits_of_a_new_one(scenario, small):
    """The new one is traced with other numbers, which must not become part of it."""
    structure, plans = structure_of(scenario), plans_of(scenario)
    stored = program_of(structure, plans)
    other = scenario
    for kind in ("inertia", "target of a slew", "noise"):
        other = numbers(other)[kind]
    own = plans_of(other)
    new = program_of(structure_of(other), own, verify=True)
    for one, two in zip(
        *(flown(program, other, own, [0, 5, 70]) for program in (stored, new)), strict=True
    ):
        np.testing.assert_array_equal(one, two)


def test_nothing_is_traced_twice(scenario, small, monkeypatch):
    structure, plans = structure_of(scenario), plans_of(scenario)
    program_of(structure, plans)

    def refuse(*arguments, **options):
        raise AssertionError("traced again")

    monkeypatch.setattr(native, "traced", refuse)
    program_of(structure, plans)


def test_a_program_whose_library_was_removed_is_made_again(scenario, small, trace, monkeypatch):
    structure, plans = structure_of(scenario), plans_of(scenario)
    program_of(structure, plans)
    made = []
    monkeypatch.setattr(native, "stored_library", lambda name: None)
    monkeypatch.setattr(native, "trace", lambda *given: made.append(given) or trace)
    program_of(structure, plans)
    assert made == [(structure, plans, 0)]


def test_components_of_a_user_are_always_traced(scenario, small, trace, monkeypatch):
    """Their code may change; the digest covers this package only."""
    structure, plans = structure_of(scenario), plans_of(scenario)
    program_of(structure, plans)

    class Own(KINDS["compensator"]["friction_model"]):
        pass

    other = replace(scenario, compensator="own")
    monkeypatch.setitem(KINDS["compensator"], "own", Own)
    made = []
    monkeypatch.setattr(native, "private_cache", lambda: pytest.fail("stored or looked up"))
    monkeypatch.setattr(native, "trace", lambda *given: made.append(given) or trace)
    program_of(structure_of(other), plans)
    assert made == [(structure_of(other), plans, 0)]


def test_a_stored_program_that_differs_is_reported(scenario, small, trace, monkeypatch):
    structure, plans = structure_of(scenario), plans_of(scenario)
    program_of(structure, plans)
    monkeypatch.setattr(native, "trace", lambda *given: trace)
    program_of(structure, plans, verify=True)
    cache, name = private_cache(), native.program_name(structure, plans, 0)
    content = cache.read(name)
    stored = pickle.loads(content)
    cache.write(name, pickle.dumps(stored._replace(begin=stored.begin._replace(text="other"))))
    try:
        with pytest.raises(InputError, match="differs from a new trace"):
            program_of(structure, plans, verify=True)
    finally:
        cache.write(name, content)
