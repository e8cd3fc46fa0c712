"""Defaults of the controllers in a scenario file that states nothing but their kind."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.scenario import Scenario
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
STATED = {
    "three_axis": {"torque_time"},
    "lqr": {"torque_time"},
    "sdre": {"torque_time"},
    "wheel_array": {"turn_gain", "rate_gain"},
    "wheel_array_detecting": {"turn_gain", "rate_gain"},
}
"""Keys whose defaults have changed once; stored numbers of the ready scenarios need theirs."""
PLAIN = """
[run]
duration = "21 s"
control_period = {period}
command_delay = {delay}
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "{controller}"
{options}
[sensors]
{sensors}
"""


@pytest.fixture
def read(tmp_path):
    """Read a scenario with a controller that has no options but these."""
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        (tmp_path / name).write_text((EXAMPLES / name).read_text())

    def made(controller="wheel_array", period=0.25, delay=0, sensors="", options=""):
        path = tmp_path / "scenario.toml"
        options = {"controller": controller, "sensors": sensors, "options": options}
        path.write_text(PLAIN.format(period=period, delay=delay, **options))
        return read_scenario(path)

    return made


def gains(scenario: Scenario) -> tuple[float, float]:
    """Rate gain and turn gain, 1/s."""
    return scenario.values["controller.rate_gain"], scenario.values["controller.turn_gain"]


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_ready_scenarios_state_what_a_default_would_change(path):
    if path.stem == "zero_crossing":  # shows the defaults
        return
    controller = tomllib.loads(path.read_text()).get("controller", {})
    assert STATED.get(controller.get("kind"), set()) <= set(controller)


@pytest.mark.parametrize("kind", ["three_axis", "lqr", "sdre"])
def test_an_external_torque_is_estimated_unless_none_is_stated(read, kind):
    assert read(kind).values["controller.torque_time"] == 20.0
    assert read(kind, options='torque_time = "none"').values["controller.torque_time"] == math.inf
    with pytest.raises(InputError, match=r"key controller\.torque_time: found 'no', expected"):
        read(kind, options='torque_time = "no"')


def test_none_is_refused_where_a_value_must_be_finite(read):
    with pytest.raises(InputError, match=r"key controller\.rate_gain"):
        read(options='rate_gain = "none"')


@pytest.mark.parametrize("period", [0.05, 0.25, 0.7, 1.0, 3.0])
@pytest.mark.parametrize("delay", [0, 1, 4])
def test_default_gains_keep_a_phase_margin(read, period, delay):
    rate, turn = gains(read(period=period, delay=delay))
    frequency = np.geomspace(1e-3, 10.0, 200001)
    # rate loop and attitude loop about an integrator, commands held for a period after the delay
    loop = 1j * frequency
    loop = rate * (loop + turn) / loop**2 * np.exp(-loop * (delay + 0.5) * period)
    crossover = np.argmin(np.abs(np.abs(loop) - 1.0))
    assert 180.0 + np.degrees(np.unwrap(np.angle(loop)))[crossover] > 48.0
    assert rate <= 0.8
    assert rate * period <= 0.5  # what the controller accepts


def test_default_gains_are_those_of_the_least_error_by_noise(read):
    noise = 'attitude_sigma = "0.01 deg"\nrate_sigma = "0.002 deg/s"'
    rate, turn = gains(read(sensors=noise))
    # variance of the attitude error, times 2 over the period: s_w^2 / k + k s_a^2
    trial = np.linspace(0.05, 0.4, 3501)
    error = 0.002**2 / trial + trial * 0.01**2
    assert turn == pytest.approx(trial[np.argmin(error)], abs=1e-3)
    assert rate == 0.8
    assert gains(read(sensors='attitude_sigma = "1 deg"')) == (0.8, 0.05)
    assert gains(read(sensors='rate_sigma = "0.1 deg/s"')) == (0.8, 0.25)


def test_stated_gains_are_taken_as_they_are(read):
    assert gains(read(period=1.0, options="rate_gain = 0.2\nturn_gain = 0.04")) == (0.2, 0.04)


def test_a_controller_chosen_in_python_has_the_same_defaults(read):
    noise = 'attitude_sigma = "0.02 deg"\nrate_sigma = "0.002 deg/s"'
    before = read("three_axis", period=0.5, delay=1, sensors=noise)
    assert before.replace(controller="wheel_array") == read(period=0.5, delay=1, sensors=noise)


def test_a_stored_scenario_keeps_the_values_that_it_was_made_with(read):
    earlier = read("three_axis", options='torque_time = "none"')
    assert Scenario.from_text(earlier.text()).values["controller.torque_time"] == math.inf
    slower = read(options="rate_gain = 0.4\nturn_gain = 0.1")
    assert gains(Scenario.from_text(slower.text())) == (0.4, 0.1)


def test_a_file_that_states_nothing_points_as_well_as_is_known(tmp_path):
    stated = tomllib.loads((EXAMPLES / "zero_crossing.toml").read_text())
    assert set(stated["controller"]) == {"kind", "target"}
    assert stated["compensator"] == {"kind": "estimating"}
    runs = gs.campaign(EXAMPLES / "zero_crossing.toml", 64, tmp_path / "runs", seed=21, worst=0)
    assert np.all(runs.status.values == 0)
    # without an estimate of the external torque: 0.028 deg
    assert np.degrees(np.quantile(runs["error_p99.7"].values, 0.95)) < 0.009
