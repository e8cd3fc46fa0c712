"""The controller of a scenario as C: own ones, with estimator, compensator and guard."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.control.measurement_guard import UNLIMITED
from gyrostat.core.errors import InputError
from gyrostat.exports import scenario_controller

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
OWN = EXAMPLES / "own_controller.toml"
GUARD = """
[guard]
on_bad = "zero"
rate_upper = "1 deg/s"
rate_lower = "-1 deg/s"
"""
BANDS = """
clearance = "150 rpm"
wear_time = "20 s"
[[controller.band]]
name = "zero"
below = "100 rpm"
[wear]
wear = [1.0, 3.0, 1.0, 1.0]
"""


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    """Scenario with an own controller and a guard."""
    folder = tmp_path_factory.mktemp("export")
    for path in (OWN, *EXAMPLES.glob("cubesat*.toml"), OWN.with_suffix(".py")):
        (folder / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    with (folder / OWN.name).open("a", encoding="utf-8") as file:
        file.write(GUARD)
    return gs.read_scenario(folder / OWN.name)


def test_an_own_controller_compiles_and_its_test_passes(guarded, tmp_path, tools):
    out = tmp_path / "flight"
    gs.export(guarded, out, to="c")
    tools.build(out, "controller.c", "controller_test.c", "-lm", "-o", "program")
    done = subprocess.run([out / "program"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert "command.torque[3]: as in Python" in done.stdout
    header = (out / "controller.h").read_text(encoding="utf-8")
    assert "AttitudePD" in header  # without phases: there is one design
    assert "Phases" not in header
    source = (out / "controller.c").read_text(encoding="utf-8")
    assert "own_controller.py" in source
    limit = repr(np.radians(1.0).item())
    assert limit in source


@pytest.fixture
def with_gyro(tmp_path):
    """Scenario with a gyro that measures up to 0.02 rad/s, and more text."""
    for path in EXAMPLES.glob("cubesat*.toml"):
        (tmp_path / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    text = (EXAMPLES / "wheel_array.toml").read_text(encoding="utf-8")
    text = text.replace("[sensors]", '[sensors]\nrate_limit = "0.02 rad/s"', 1)

    def read(more):
        scenario = tmp_path / "wheel_array.toml"
        scenario.write_text(text + more, encoding="utf-8")
        return gs.read_scenario(scenario)

    return read


def test_limits_come_from_the_sensors_where_the_scenario_gives_none(guarded, with_gyro):
    """Of a gyro, a quaternion, and tachometers without a limit."""
    limits = _limits(with_gyro(""))
    found = {name: (float(each.lower), float(each.upper)) for name, each in limits.items()}
    assert found == {
        "attitude": (-1.1, 1.1),
        "rate": pytest.approx((-0.022, 0.022)),
        "wheel_speed": (-UNLIMITED, UNLIMITED),
    }
    assert float(_limits(guarded)["rate"].upper) == np.radians(1.0)


def test_the_readme_names_the_limits_that_come_from_the_sensors(with_gyro):
    attitude, rate = "`attitude` ±1.1", "`rate` ±0.022"
    for more, expected in [("", (attitude, rate)), (GUARD, (attitude,))]:
        ranges = scenario_controller(with_gyro(more), "hold").ranges
        assert tuple(text.partition(" (")[0] for text in ranges) == expected


def _limits(scenario):
    return scenario_controller(scenario, "hold").steps[0].arguments["guard"].limits


def test_a_scenario_of_this_package_is_exported_too(run, tmp_path, tools):
    """With its Kalman filter, whose covariances are rounding errors in part, bands and wear."""
    for path in EXAMPLES.glob("cubesat*.toml"):
        (tmp_path / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    scenario, out = tmp_path / "wheel_array.toml", tmp_path / "flight"
    text = (EXAMPLES / scenario.name).read_text(encoding="utf-8")
    scenario.write_text(text.replace("[sensors]", f"{BANDS}[sensors]", 1), encoding="utf-8")
    code, _, said = run("export", scenario, "--to", "c", "--out", out)
    assert code == 0, said
    tools.build(out, "controller.c", "controller_test.c", "-lm", "-o", "program")
    done = subprocess.run([out / "program"], capture_output=True, text=True)
    assert done.returncode == 0, [line for line in done.stdout.splitlines() if "not as" in line]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"to": "json"}, "to json: found an object of Scenario, expected to c"),
        ({"to": "c", "period": 0.1}, "a scenario: found period, expected these with a part"),
        ({"to": "c", "what": "wheel"}, "what wheel: found an object of Scenario, expected cont"),
        ({"to": "c", "on_bad": "zero"}, "a scenario: found on_bad"),
        ({"to": "c", "gains": "1,2,3"}, "a scenario: found gains"),
    ],
)
def test_options_that_a_scenario_has_are_refused(guarded, tmp_path, options, expected):
    with pytest.raises(InputError) as caught:
        gs.export(guarded, tmp_path / "flight", **options)
    assert expected in str(caught.value)
    assert not (tmp_path / "flight").exists()
