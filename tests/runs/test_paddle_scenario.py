"""Two wheels and a paddle without a gyro in a scenario: flown, exported, and refusals."""

import subprocess

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.scenario_files.scenario_file import read_scenario

CRAFT = """
[body]
name = "paddle"
inertia = [12.0, 11.0, 13.0]
[[wheel]]
name = "x"
axis = [1.0, 0.0, 0.0]
inertia = 0.01
torque_limit = 0.3
momentum_limit = 6.0
[[wheel]]
name = "y"
axis = [0.0, 1.0, 0.0]
inertia = 0.01
torque_limit = 0.3
momentum_limit = 6.0
[[wheel]]
name = "paddle"
axis = [0.0, 0.0, 1.0]
inertia = 0.6
torque_limit = 0.3
momentum_limit = 0.06
"""
SCENARIO = """
[run]
duration = "60 s"
control_period = "0.1 s"
[spacecraft]
file = "craft.toml"
[start]
attitude_error = ["1 deg", "-2 deg", "4 deg"]
[controller]
kind = "two_wheels_paddle"
paddle_limit = "150 deg"
[sensors]
kind = "star_tracker"
attitude_sigma = "10 arcsec"
[estimator]
rate_sigma = "0.01 deg/s"
"""
ANGLE = """
[[sensor]]
kind = "paddle_angle"
sigma = "0.1 deg"
"""


@pytest.fixture
def scenario(tmp_path):
    (tmp_path / "craft.toml").write_text(CRAFT)

    def write(more=ANGLE, text=SCENARIO):
        path = tmp_path / "scenario.toml"
        path.write_text(text + more)
        return path

    return write


def test_it_turns_by_the_paddle(scenario):
    run = gs.simulate(scenario(), seed=4, engine="native")
    assert np.degrees(run.error.values[-100:].max()) < 0.01
    assert np.all(run.by_paddle == 1.0)
    # 4 deg about z by the share of the paddle
    assert run.wheel_angle[-1, 2] == pytest.approx(np.radians(4.0) * 13.6 / 0.6, rel=5e-3)


def test_it_is_exported_as_c(scenario, tmp_path, tools):
    out = tmp_path / "flight"
    gs.export(read_scenario(scenario()), out, to="c")
    tools.build(out, "controller.c", "controller_test.c", "-O1", "-lm", "-o", "program")
    done = subprocess.run([out / "program"], capture_output=True, text=True)
    assert done.returncode == 0, [line for line in done.stdout.splitlines() if "not as" in line]
    assert "command.estimated_rate[2]: as in Python" in done.stdout
    assert "command.paddle_end: as in Python" in done.stdout


@pytest.mark.parametrize(
    ("more", "old", "new", "words"),
    [
        ("", "", "", "without paddle_angle, expected a \\[\\[sensor\\]\\] named paddle_angle"),
        (ANGLE, 'paddle_limit = "150 deg"', "", "paddle_limit"),
        (ANGLE, '"150 deg"', "0.0", "paddle_limit"),
        (
            ANGLE,
            'kind = "two_wheels_paddle"\npaddle_limit = "150 deg"',
            'kind = "three_axis"',
            "without paddle, expected the controller two_wheels_paddle",
        ),
        (ANGLE + "[imbalance]\nstatic_imbalance = 1e-6", "", "", "with \\[imbalance\\]"),
    ],
)
def test_what_does_not_fit_is_refused(scenario, more, old, new, words):
    with pytest.raises(InputError, match=words):
        gs.simulate(scenario(more, SCENARIO.replace(old, new)))
