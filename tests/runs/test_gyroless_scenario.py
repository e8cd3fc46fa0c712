"""Sensors without a gyro in a scenario: flown, and refused where a gyro is needed."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = """
[run]
duration = "300 s"
control_period = "0.25 s"
[spacecraft]
file = "two_wheels.toml"
[start]
attitude_error = ["2 deg", "4 deg", "6 deg"]
rate = [1e-5, 1e-5, 1e-5]
[controller]
kind = "two_wheels"
[sensors]
kind = "star_tracker"
attitude_sigma = "10 arcsec"
tracker_periods = 4
speed_sigma = 0.002
[metrics]
boresight = [0.0, 0.0, 1.0]
"""


@pytest.fixture
def scenario(tmp_path):
    for name in ("two_wheels.toml", "two_wheels_wheel.toml"):
        shutil.copy(EXAMPLES / name, tmp_path)

    def write(more=""):
        path = tmp_path / "scenario.toml"
        path.write_text(SCENARIO + more)
        return path

    return write


def test_two_wheels_point_on_star_tracker_and_tachometers(scenario):
    run = gs.simulate(scenario("[estimator]\nbandwidth = 0.1"), seed=5)
    assert "measured_rate" not in run
    assert run.attitude_measured.values.mean() < 0.26
    late = run.isel(time=slice(-200, None))
    # 0.05 deg is required; the rate is known as well as by a gyro with a bias of 1 deg/h
    assert np.degrees(late.error.max()) < 0.02
    assert np.abs(late.estimated_rate - late.rate).max() < 5e-6


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("[guard]\nrate_lower = -1.0", "rate_lower"),
        (
            '[[event]]\nkind = "sensor_stuck"\nsensor = "rate"\ntime = 1.0',
            "sensor: found 'rate', expected one of",
        ),
        ('[compensator]\nkind = "estimating"', "without gyro, expected sensors with a gyro"),
        ('[estimator]\nkind = "kalman"', "found 'kalman', expected momentum for the sensors"),
        ("[estimator]\nbandwidth = 0.0", "estimator.bandwidth"),
    ],
)
def test_what_needs_a_gyro_is_refused(scenario, more, words):
    with pytest.raises(InputError, match=words):
        read_scenario(scenario(more))
