"""Relations between values of a run: against the scenario file with them, and compiled."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from gyrostat.campaigns.web_relations import possible_function
from gyrostat.codegen.simd.batch import Lanes
from gyrostat.codegen.simd.call import Compiled
from gyrostat.codegen.simd.compiler import library
from gyrostat.control.attitude.wheel_array_control import COARSEST
from gyrostat.control.guidance.pointing import frame_of_axes
from gyrostat.core.errors import InputError
from gyrostat.reports.fly_limits import run_limits
from gyrostat.runs.run_relations import run_relations
from gyrostat.scenario.reference_kind import axes_apart
from gyrostat.scenario.relation import less
from gyrostat.scenario_files import read_scenario
from gyrostat.scenario_files.run_file import relations_of_file

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
MODES = """
[run]
duration = "60 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "wheel_array"
[[controller.band]]
name = "hum"
above = "1000 rpm"
below = "1100 rpm"
[guard]
rate_lower = "-1 deg/s"
rate_upper = "1 deg/s"
[reference]
kind = "sequence"
rate = "0.7 deg/s"
[[reference.mode]]
name = "safe"
kind = "fixed"
target = [1, 0, 0, 0]
until_rate_below = "0.1 deg/s"
[[reference.mode]]
name = "science"
kind = "nadir"
altitude = "500 km"
minimum_dwell = "2 s"
[[reference.transition]]
to = "safe"
rate_above = "0.2 deg/s"
rate_below = "0.4 deg/s"
wheels_lost = 2
[[reference.transition]]
name = "late"
to = "safe"
at = "30 s"
"""
SAFE = "reference.transition.to_safe"
SCIENCE = "reference.mode.science"
CHANGES = [
    ({}, ""),
    ({f"{SAFE}.rate_above": 0.006, f"{SAFE}.rate_below": 0.0061}, ""),
    ({"reference.mode.safe.minimum_dwell": 3.0, f"{SAFE}.held": 2.0}, ""),
    ({f"{SCIENCE}.to_earth.z": 0.0}, f"{SCIENCE}.to_earth: found no direction"),
    (
        {f"{SCIENCE}.along.x": 0.0, f"{SCIENCE}.along.z": 1.0},
        f"{SCIENCE}: found parallel body axes",
    ),
    ({f"{SAFE}.rate_above": 0.0071}, "found rate_above 0.0071 and rate_below 0.00698132"),
    ({f"{SAFE}.wheels_lost": 5.0}, "found wheels_lost 5 of 4 wheels"),
    ({"reference.transition.late.at": 0.0}, "found at 0 s, before which no mode"),
    ({"controller.band.hum.above": 120.0}, "found 115.192 rad/s, expected more than above, 120"),
    ({"guard.rate_upper": -0.1}, "expected more than guard.rate_lower, -0.0174533"),
    ({"wheel.b.inertia": 10.0}, "body.inertia: "),
]
"""Changed values, and what is refused of them by the file of the scenario and of a run."""
RUN_CHANGES = [
    ({"reference.mode.science.minimum_dwell": 0.0}, "which is no condition, expected one"),
    ({"reference.mode.safe.until_time": 3.0}, "found 3, expected no such condition"),
    ({"wheel.c.speed": -1e4}, "wheel.c.speed: found -10000 rad/s, a start beyond"),
]
"""Changed values that the program of a scenario does not have."""


@pytest.fixture(scope="module")
def scenario(folder):
    path = folder / "relations.toml"
    path.write_text(MODES)
    return read_scenario(path)


def broken(scenario, changes):
    """Messages of the relations that changed values do not fulfil."""
    values = {**scenario.values, **changes}
    return [each.message(values) for each in relations_of_file(scenario) if not each.holds(values)]


@pytest.mark.parametrize(("changes", "message"), CHANGES)
def test_a_run_may_have_what_the_file_of_its_scenario_may(scenario, changes, message):
    messages = broken(scenario, changes)
    if not message:
        assert messages == []
        return
    assert message in messages[0]
    with pytest.raises(InputError) as caught:
        scenario.replace(**changes)
    assert message in str(caught.value)


@pytest.mark.parametrize(("changes", "message"), RUN_CHANGES)
def test_a_run_has_the_graph_and_the_start_of_its_program(scenario, changes, message):
    (line,) = broken(scenario, changes)
    assert message in line


def test_changes_that_take_no_time_stay_apart(folder):
    """Both modes end at once, but for the limits; the command refuses a file in which they meet."""
    path = folder / "apart.toml"
    text = MODES.replace('minimum_dwell = "2 s"\n', "").replace('at = "30 s"', 'at = "20 s"')
    path.write_text(text)
    scenario = read_scenario(path)
    change = {"reference.mode.safe.until_rate_below": 0.005}
    (line,) = broken(scenario, change)
    assert "expected that they exclude each other" in line
    with pytest.raises(InputError, match="follow each other in no time"):
        scenario.replace(**change)


def test_events_keep_their_order():
    scenario = read_scenario(EXAMPLES / "wheel_failure.toml")
    loss = scenario.events[0]
    second = dataclasses.replace(loss, name="second", wheel=1)
    values = {
        f"event.second.{end}": scenario.values[f"event.{loss.name}.{end}"] + 1.0
        for end in ("time", "detected_after")
        if f"event.{loss.name}.{end}" in scenario.values
    }
    both = dataclasses.replace(
        scenario, events=(loss, second), values={**scenario.values, **values}
    )
    assert broken(both, {}) == []
    swapped = {f"event.{loss.name}.time": values["event.second.time"] + 5.0}
    assert any("found events in another order" in line for line in broken(both, swapped))


def test_compiled_relations_are_those_of_python(scenario):
    """1000 draws about the nominal values."""
    relations, keys = [*run_relations(scenario)], [*scenario.values]
    code = possible_function(keys, relations)
    assert code.layout.words["made"] == len(relations)
    compiled = Lanes(code, Compiled(code.layout, library(code.text)))
    factors = np.random.default_rng(3).choice(
        [-1.0, 0.0, 0.5, 1.0, 1.0, 1.0, 3.0, 1e3], (1000, len(keys))
    )
    nominal = np.array([*scenario.values.values()])
    with np.errstate(invalid="ignore"):
        rows = np.where(np.isfinite(nominal), nominal * factors, nominal)
    found = np.array(compiled(rows)).T
    expected = [
        [float(each.holds(dict(zip(keys, row, strict=True)))) for each in relations]
        for row in rows.tolist()
    ]
    np.testing.assert_array_equal(found, expected)
    assert np.sum(np.ptp(found, axis=0)) >= 8  # most refuse some rows and not others


@pytest.mark.parametrize("angle", [0.0, 0.9e-6, 1.1e-6, 1.0, np.pi])
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1e6, 1e-3), (1.0, 0.0)])
def test_axes_are_apart_if_they_have_a_frame(angle, lengths):
    first = lengths[0] * np.array([0.6, 0.0, 0.8])
    turned = np.cos(angle) * np.array([0.6, 0.0, 0.8]) + np.sin(angle) * np.array([0.0, 1.0, 0.0])
    axes = {"first": first, "second": lengths[1] * turned}
    relation = axes_apart("mode", [*axes])
    values = {
        f"mode.{name}.{end}": value
        for name, axis in axes.items()
        for end, value in zip("xyz", axis, strict=True)
    }
    frame = frame_of_axes(*axes.values())
    assert relation.holds(values) == np.all(np.isfinite(frame))


def test_a_message_has_the_values_of_keys_with_any_name():
    key = "event.loss of {c}, 2nd-é.time"
    relation = less(key, "run.duration", f"{key}: found {{{key}}} s, not {{run.duration}} s")
    assert relation.message({key: 7.5, "run.duration": 5.0}) == f"{key}: found 7.5 s, not 5 s"


def test_limits_of_the_parts_are_found(scenario):
    """The rate gain times the control period is `COARSEST` at most."""
    gain = scenario.values["controller.rate_gain"]
    ranges = {"controller.rate_gain": (0.5 * gain, 1.5 * gain, 1e-6, 1e30)}
    least, most = run_limits(scenario, ranges, [*run_relations(scenario)]).ends[
        "controller.rate_gain"
    ]
    assert (least.value, least.why) == (1e-6, "")
    assert most.value == pytest.approx(COARSEST / 0.25, rel=1e-3)
    assert "expected" in most.why
