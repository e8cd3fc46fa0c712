"""File of one run: refused contents, and lines on the values of the run."""

import json
import math

import pytest

from gyrostat import verbs
from gyrostat.core.errors import InputError
from gyrostat.scenario_files import read_scenario
from gyrostat.scenario_files.run_file import read_run

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

SCENARIO = """
name = "pointed"
[run]
duration = "2 s"
control_period = "0.5 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
turn_gain = 0.4
[orbit]
kind = "circular"
epoch = "2026-11-22T10:00:00Z"
altitude = "500 km"
inclination = "97.4 deg"
ascending_node = "148 deg"
[[keep_out]]
name = "camera"
boresight = [0.0, 0.0, 1.0]
sun = 0.0
"""


@pytest.fixture(scope="module")
def content(folder):
    path = folder / "pointed.toml"
    path.write_text(SCENARIO)
    text = read_scenario(path).text()
    return {"gyrostat": "run", "seed": 0, "run": None, "values": {}, "scenario": json.loads(text)}


@pytest.fixture
def written(content, tmp_path):
    def write(**changes):
        path = tmp_path / "run.json"
        path.write_text(json.dumps({**content, **changes}))
        return path

    return write


@pytest.mark.parametrize("key", ["run.control_period", "run.duration", "metrics.after"])
def test_values_that_the_compiled_program_fixes_are_refused(written, key):
    with pytest.raises(InputError, match=rf"values\.{key}: found a value of the run"):
        read_run(written(values={key: 0.25}), print)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"run": 2**70}, f"key run: found {2**70}, expected 0 to"),
        ({"values": {"controller.turn_gain": 10**400}}, r"turn_gain: found 10+, expected"),
        ({"values": {"controller.turn_gain": True}}, r"turn_gain: found True, expected"),
        ({"scenario": None}, "key scenario: found none, expected a scenario"),
        ({"scenario": {"values": [1.0]}}, "key scenario: found none, expected a scenario"),
    ],
)
def test_a_tampered_file_is_refused_in_one_line(written, changes, message):
    with pytest.raises(InputError, match=message) as error:
        read_run(written(**changes), print)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("value", ["abc", math.nan, pytest.param(10**400, id="huge"), None])
def test_a_scenario_whose_value_is_no_number_is_refused(written, content, value):
    values = {**content["scenario"]["values"], "controller.turn_gain": value}
    path = written(scenario={**content["scenario"], "values": values})
    with pytest.raises(InputError, match=r"key scenario.values.controller.turn_gain: found"):
        read_run(path, print)


def test_lines_on_a_run_are_about_its_own_values(written):
    """A cone of 180 deg has the Sun in it in every attitude, that of the scenario in none."""
    assert read_run(written(), print).line() == "values of the run, SI: those of the scenario"
    path, lines = written(values={"keep_out.camera.sun": 3.1415}, run=4), []
    verbs.simulate(path, engine="auto", say=lines.append)
    assert [line for line in lines if "keep_out camera: found the Sun too near" in line]
    assert "values of the run, SI: keep_out.camera.sun = 3.1415; noise of run 4" in lines
