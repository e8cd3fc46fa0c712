"""Modes that branch: read, checked on their graph, and flown alike by both engines."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.scenario.mode_graph import check_modes, edges
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
TEXT = """
[run]
duration = "60 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
rate = ["1.5 deg/s", "-1 deg/s", "0.8 deg/s"]
[controller]
kind = "three_axis"
[[controller.law]]
name = "soft"
kind = "three_axis"
rate_gain = 0.3
[reference]
kind = "sequence"
rate = "0.7 deg/s"
[[reference.mode]]
name = "safe"
kind = "fixed"
target = [1, 0, 0, 0]
law = "soft"
minimum_dwell = "5 s"
[[reference.mode]]
name = "science"
kind = "fixed"
target = [0.0, 0.6, 0.0, 0.8]
[[reference.transition]]
to = "science"
rate_below = "0.3 deg/s"
held = "2 s"
[[reference.transition]]
to = "safe"
at = "30 s"
"""


@pytest.fixture
def scenario(tmp_path):
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, tmp_path)

    def write(old="", new=""):
        path = tmp_path / "scenario.toml"
        path.write_text(TEXT.replace(old, new, 1))
        return path

    return write


def test_both_engines_take_the_same_changes(scenario):
    path = scenario()
    runs = [gs.simulate(path, engine=engine) for engine in ("native", "jax")]
    for name in ("attitude", "rate", "torque", "wheel_speed", "target", "mode", "mode_start"):
        one, other = (np.asarray(run[name]) for run in runs)
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-10, err_msg=name)
    modes = np.asarray(runs[0]["mode"])
    changes = np.flatnonzero(np.diff(modes))
    assert list(modes[changes + 1]) == [1, 0]
    assert float(runs[0]["time"][changes[1] + 1]) == pytest.approx(30.0)
    assert float(runs[0].attrs["change.to_science"]) == 1.0
    assert float(runs[0].attrs["change.to_safe"]) == 1.0
    times = [float(runs[0].attrs[f"mode.{name}.time"]) for name in ("safe", "science")]
    assert sum(times) == pytest.approx(60.0)
    assert times[0] == pytest.approx(0.25 * np.sum(modes[:-1] == 0))
    # 2 s below the limit on the rate, as the controller measures it, from the first such sample
    rate = np.linalg.norm(np.asarray(runs[0]["measured_rate"]), axis=1)
    assert np.all(rate[changes[0] + 1 - 8 : changes[0] + 2] < np.radians(0.3))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('to = "safe"', 'to = "save"', "found 'save', expected one of safe, science"),
        ('law = "soft"', 'law = "hard"', "found 'hard', expected one of soft"),
        ('at = "30 s"', "", "to_safe: found no condition"),
        ('at = "30 s"', 'when = "eclipse"', "found it without [orbit]"),
        ('at = "30 s"', 'at = "90 s"', "found at 90 s in a run of 60 s"),
        ('held = "2 s"', 'rate_above = "0.4 deg/s"', "expected conditions that can hold together"),
        ('to = "safe"', 'from = "safe"\nto = "safe"', ""),
        ('at = "30 s"', "wheels_lost = 9", "found wheels_lost 9 of 4 wheels"),
        ('to = "science"', 'to = "safe"', "found no path to it from the first mode, safe"),
    ],
)
def test_mistakes_are_one_line(scenario, old, new, message):
    if not message:
        assert check_modes(read_scenario(scenario(old, new)))
        return
    with pytest.raises(InputError, match=re.escape(message)):
        check_modes(read_scenario(scenario(old, new)))


def test_a_cycle_that_takes_no_time_is_refused(scenario):
    text = TEXT.replace('minimum_dwell = "5 s"\n', "").replace('held = "2 s"\n', "")
    path = scenario(TEXT, text.replace('at = "30 s"', 'rate_above = "1 deg/s"'))
    with pytest.raises(InputError, match="safe -> science -> safe"):
        check_modes(read_scenario(path))


def test_times_of_edges_are_those_of_dwell_and_hold(scenario):
    found = {(edge.name, edge.start): edge.time for edge in edges(read_scenario(scenario()))}
    assert found == {("to_science", "safe"): 5.0, ("to_safe", "science"): 0.0}
