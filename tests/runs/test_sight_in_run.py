"""Motion of the line of sight in runs: wheels matched to those of a scenario, and bands of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.microvibration import Harmonic, ModalModel, MountedWheel, WheelDisturbance
from gyrostat.microvibration.disturbance_file import Structure
from gyrostat.runs.reference_path import nominal_setup
from gyrostat.runs.sight_in_run import SightInRun
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.search.speed_plan import with_bands

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = read_scenario(EXAMPLES / "science_windows.toml")
GENERATOR = np.random.default_rng(7)
WHEEL = WheelDisturbance("wheel", (Harmonic(1.0, {"force": 1e-6}),))
MODEL = ModalModel(
    np.array([20.0, 22.0]),
    np.array([0.01, 0.01]),
    GENERATOR.normal(size=(1, 2, 6)),
    GENERATOR.normal(size=(2, 2)),
)
MOUNTED = [
    MountedWheel(name, WHEEL, np.array(a), np.zeros(3))
    for name, a in zip("abcd", SCENARIO.axes, strict=True)
]
STRUCTURE = Structure(MOUNTED, MODEL, 0.1, 1e-6, (10.0, 400.0), None)


def opposite(structure):
    """The same wheels, whose axes are given the other way round."""
    return replace(structure, wheels=[replace(w, axis=-w.axis) for w in structure.wheels])


def test_a_wheel_given_by_the_opposite_axis_turns_the_other_way():
    speed = GENERATOR.uniform(-400.0, 400.0, (20, 4))
    inside = GENERATOR.random(20) < 0.6
    both = [SightInRun.of(SCENARIO, each, 300) for each in (STRUCTURE, opposite(STRUCTURE))]
    first, second = (each.rms(speed, inside) for each in both)
    assert first == pytest.approx(second, rel=1e-9)
    assert abs(both[0].rms(-speed, inside) / first - 1.0) > 1e-3
    squares = both[0].sight.in_run(speed)
    assert first == pytest.approx(np.sqrt(np.mean(squares[inside])))
    assert np.isnan(both[0].rms(speed, np.zeros(20, bool)))


def test_speeds_above_those_of_the_structure_are_avoided():
    wheels = nominal_setup(SCENARIO).plant.spacecraft.wheels
    most = float(np.max(np.asarray(wheels.momentum_limit) / np.asarray(wheels.inertia)))
    sight = SightInRun.of(SCENARIO, STRUCTURE, 300).sight
    low, high = sight.bands()[-1]
    assert low <= 400.0 < most < high
    assert np.isnan(sight.in_run(np.full((1, 4), 401.0))[0])


def test_other_wheels_than_those_of_the_scenario_are_refused():
    with pytest.raises(InputError, match="found 3 wheels on the structure, expected the 4"):
        SightInRun.of(SCENARIO, replace(STRUCTURE, wheels=MOUNTED[:3]), 10)
    turned = [MOUNTED[1], *MOUNTED[1:]]
    with pytest.raises(InputError, match="expected that of wheel a"):
        SightInRun.of(SCENARIO, replace(STRUCTURE, wheels=turned), 10)


def test_bands_of_the_line_of_sight_replace_those_of_the_same_names_only():
    once = with_bands(SCENARIO, [(100.0, 110.0), (150.0, 160.0)])
    again = with_bands(once, [(120.0, 130.0), (150.0, 160.0)])
    names = [part.name for part in again.parts if part.section == "controller.band"]
    assert sorted(names) == ["jitter_1", "jitter_2", "resonance"]
    assert again.values["controller.band.jitter_1.above"] == 120.0
    assert (
        again.values["controller.band.resonance.above"]
        == SCENARIO.values["controller.band.resonance.above"]
    )
