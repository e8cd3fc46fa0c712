"""Slews around cones in campaigns, searches and pages that fly."""

import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.reports.fly import sliders
from gyrostat.runs.slew_lines import blocked_runs
from gyrostat.scenario_files import read_scenario
from gyrostat.scenario_files.run_file import read_run
from tests.runs.test_keep_out_slews import EXAMPLES, HEAD, SLEWS, dispersed

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")


@pytest.fixture(scope="module")
def slews(tmp_path_factory):
    """Scenarios with and without a planned slew."""
    folder = tmp_path_factory.mktemp("slews")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder)
    text = HEAD + SLEWS + dispersed("start.attitude_error.x", -0.01, 0.01)
    made = []
    for each in (text, text.replace('keep_out = "camera"\n', "")):
        path = folder / "scenario.toml"
        path.write_text(each)
        made.append(read_scenario(path))
    return made


def test_what_slews_are_planned_from_cannot_be_tuned(slews, tmp_path):
    with pytest.raises(InputError, match=r"found reference\.rate, expected no dispersion of it"):
        gs.tune(slews[0], {"reference.rate": "0.01:0.02"}, "error_max", tmp_path / "out")


def test_a_page_that_flies_has_no_sliders_of_what_slews_are_planned_from(slews):
    fixed = {"reference.rate", "reference.torque_share", "reference.slew.across.time"}
    keys = []
    for scenario in slews:
        # each value that is read takes a search for its limits
        program = SimpleNamespace(read=[*fixed, "controller.turn_gain"], designed=frozenset())
        rows = np.array([[0.0]])
        keys.append({each.key for each in sliders(scenario, program, rows, [])[0]})
    planned, free = keys
    assert fixed <= free
    assert not fixed & planned
    assert "controller.turn_gain" in planned


def test_runs_inside_a_cone_are_counted(slews):
    times = np.array([0.0, 56.0, np.nan, 66.0])
    (line,) = blocked_runs(slews[0], times)
    assert "in 2 of 4 runs, for 66 s at most" in line
    assert not blocked_runs(slews[0], np.zeros(4))
    assert not blocked_runs(slews[1], times)


def test_the_file_of_a_run_cannot_change_what_slews_are_planned_from(slews, tmp_path):
    path = tmp_path / "run.json"
    content = {"gyrostat": "run", "scenario": json.loads(slews[0].text())}
    rate = slews[0].values["reference.rate"]
    path.write_text(json.dumps({**content, "values": {"reference.rate": 0.5 * rate}}))
    with pytest.raises(InputError, match=r"values\.reference\.rate: found 0\.0087.*planned"):
        read_run(path, print)
    path.write_text(json.dumps({**content, "values": {"reference.rate": rate}}))
    assert read_run(path, print).values == {"reference.rate": rate}
