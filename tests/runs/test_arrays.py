"""Scenarios with an array of wheels, star tracker and gyro, and an orbit."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.runs.build import build
from gyrostat.runs.designs import plan
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLE = Path(__file__).parents[2] / "examples" / "scenarios" / "wheel_array.toml"


@pytest.fixture
def variant(tmp_path):
    def make(*changes):
        for name in ("cubesat.toml", "cubesat_wheel.toml"):
            (tmp_path / name).write_text(EXAMPLE.with_name(name).read_text())
        text = EXAMPLE.read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "scenario.toml"
        path.write_text(text)
        return path

    return make


@pytest.mark.slow
def test_the_loop_is_closed_on_estimates_in_an_orbit():
    # before its events
    flown = gs.simulate(replace(read_scenario(EXAMPLE), count=560), seed=1)
    assert float(flown.time[-1]) == 140.0
    assert int(flown.status) == 0
    end = flown.isel(time=-1)
    error = rotations.error_angle(end.attitude.values, np.array([1.0, 0.0, 0.0, 0.0]))
    assert np.degrees(float(error)) < 0.02
    # the gyro's bias is found, so that it is not flown
    bias = np.degrees(end.estimated_bias.values)
    np.testing.assert_allclose(bias, [0.002, -0.001, 0.003], atol=3e-4)
    # the null space is used: all four wheels are driven away from zero speed
    assert np.all(np.abs(end.wheel_speed) > 1.2 * np.abs(flown.wheel_speed[0]))
    # momentum in space changes by gravity, harmonics and magnetorquers, which stay in their limit
    assert np.all(np.abs(flown.external_torque) <= 5e-6)
    assert np.any(np.abs(flown.external_torque) > 0.0)
    assert np.linalg.norm(end.momentum - flown.momentum[0]) > 1e-6


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (
            ("[environment]", '[estimator]\nkind = "none"\n[environment]'),
            "key estimator.kind: found 'none', expected kalman for the sensors star_tracker_gyro",
        ),
        (("tracker_periods = 4", "tracker_periods = 0.5"), "key sensors.tracker_periods: found"),
        (("angle_walk = 2e-5", "angle_walk = 0.0"), "key sensors.angle_walk: found 0.0, expected"),
        (("altitude = 500e3", "altitude = -1.0"), "key environment.altitude: found"),
        (('kind = "orbit"', 'kind = "orbits"'), "key environment.kind: found 'orbits', expected"),
        (
            ('control_period = "0.25 s"', 'control_period = "5 s"'),
            "control period: found 5 s, expected 1.25 s or less at this rate gain",
        ),
    ],
)
def test_what_does_not_fit_is_refused(variant, change, found):
    with pytest.raises(InputError) as error:
        read_scenario(variant(change))
    assert found in str(error.value)


def test_the_other_allocation_is_the_same_but_for_it(variant):
    least = read_scenario(EXAMPLE)
    squares = read_scenario(variant(('"wheel_array"', '"wheel_array_pseudo_inverse"')))
    changed = {name for name, value in vars(least).items() if getattr(squares, name) != value}
    assert changed == {"controller"}


DETECTS = ('"wheel_array"', '"wheel_array_detecting"\nfailure_torque = "0.2 mN·m"')
UNTOLD = ('detected_after = "10 s"', "")


def controller_of(scenario):
    """The plans of the array's controller, all phases, as they fly."""
    found = build(structure_of(scenario), scenario.values, plan(scenario)).controller.controller
    return found.starts, found.plans


def test_a_loss_is_notified_or_detected(variant):
    told = read_scenario(EXAMPLE)
    starts, plans = controller_of(told)
    np.testing.assert_array_equal(starts, [0.0, 150.0, 410.0])
    np.testing.assert_array_equal(plans.detector.notified[2], [np.inf, 0.0, np.inf, np.inf])
    assert np.all(np.isinf(plans.detector.failure_torque))
    finds = read_scenario(variant(DETECTS, UNTOLD))
    starts, plans = controller_of(finds)
    np.testing.assert_array_equal(starts, [0.0, 150.0])
    assert np.all(np.isinf(plans.detector.notified))
    np.testing.assert_allclose(plans.detector.failure_torque, 2e-4)
    np.testing.assert_allclose(plans.detector.failure_time, 5.0)


def test_the_fault_detector_knows_the_delay(variant):
    late = read_scenario(variant(("[spacecraft]", "command_delay = 2\n[spacecraft]")))
    assert controller_of(late)[1].detector.delay == 2
    assert controller_of(read_scenario(EXAMPLE))[1].detector.delay == 0


@pytest.mark.parametrize(
    ("changes", "found"),
    [
        (
            [DETECTS],
            "key event[loss].detected_after: found '10 s', expected none: this controller ",
        ),
        (
            [('"wheel_array"', '"wheel_array_detecting"'), UNTOLD],
            "key controller.failure_torque: found none, expected above 0",
        ),
        (
            [("turn_gain", "failure_torque = 1\nturn_gain")],
            "key controller.failure_torque: found an unknown key",
        ),
        (
            [
                DETECTS,
                UNTOLD,
                ("[metrics]", '[[event]]\nkind = "seized"\nwheel = "a"\ntime = 9\n[metrics]'),
            ],
            "found working wheels that do not span space",
        ),
    ],
)
def test_what_a_detecting_controller_cannot_use_is_refused(variant, changes, found):
    with pytest.raises(InputError) as error:
        read_scenario(variant(*changes))
    assert found in str(error.value)
