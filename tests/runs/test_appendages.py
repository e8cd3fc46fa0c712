"""Appendages of the spacecraft file in a scenario: numbers by key, dispersed, in every run."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.runs.build import build
from gyrostat.runs.plans import plans_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
APPENDAGES = """
[[flexible]]
name = "wing"
frequency = "0.5 Hz"
participation = [0.1, 0.02, 0.0]

[[slosh]]
name = "tank"
frequency = "0.4 Hz"
mass = "300 g"
position = [0.0, 0.0, "8 cm"]
direction = [1.0, 0.0, 0.0]
"""
DISPERSION = """
[[dispersion]]
key = "slosh.tank.mass"
distribution = "normal"
sigma = "10 %"
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flexible")
    for name in ("zero_crossing_model.toml", "cubesat.toml", "cubesat_wheel.toml"):
        text = (EXAMPLES / name).read_text()
        if name == "cubesat.toml":
            text = text.replace("inertia = [0.06", 'mass = "8 kg"\ninertia = [0.06') + APPENDAGES
        if name == "zero_crossing_model.toml":
            text += DISPERSION
        (folder / name).write_text(text)
    return read_scenario(folder / "zero_crossing_model.toml")


def test_the_plant_of_a_run_has_its_modes(scenario):
    assert Scenario.from_text(scenario.text()) == scenario
    assert "slosh.tank.mass" in scenario.dispersed
    values = {**scenario.values, "slosh.tank.mass": 0.4, "body.mass": 10.0}
    plant = build(structure_of(scenario), values, plans_of(scenario)).plant
    np.testing.assert_allclose(plant.modes.frequency, [np.pi, 0.8 * np.pi])
    np.testing.assert_allclose(
        plant.modes.participation, [[0.1, 0.02, 0.0], [0.0, 0.08 * np.sqrt(0.4), 0.0]]
    )
    np.testing.assert_allclose(plant.modes.translation, [[0.0] * 3, [0.2, 0.0, 0.0]])


def test_changed_appendages_are_checked(scenario):
    changed = scenario.replace(**{"flexible.wing.frequency": "0.7 Hz"})
    assert changed.values["flexible.wing.frequency"] == 0.7
    with pytest.raises(InputError, match="as least inertia of the body"):
        scenario.replace(**{"flexible.wing.participation": [0.4, 0.0, 0.0]})
