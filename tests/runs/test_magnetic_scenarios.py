"""Rods, further sensors, star tracker heads and their controllers in scenario files."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.core.rotations import to_body
from gyrostat.runs import plans
from gyrostat.runs.plans import plans_of
from gyrostat.scenario.sensing import first_measurement
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
HEAD = """
[run]
duration = "10 s"
control_period = "0.5 s"
[spacecraft]
file = "cubesat.toml"
[start]
rate = ["1 deg/s", "-2 deg/s", "1 deg/s"]
"""
ORBIT = """
[orbit]
kind = "circular"
epoch = "2026-11-22T10:00:00Z"
altitude = "500 km"
inclination = "97.4 deg"
"""
RODS = """
[[actuator]]
kind = "torque_rods"
limit = ["200 mA·m²", "200 mA·m²", 0.1]
duty = 0.8
"""
MAGNETOMETER = """
[[sensor]]
kind = "magnetometer"
sigma = "100 nT"
bias = [1e-7, 0.0, 0.0]
periods = 2
latency = 1
"""
DETUMBLING = """
[controller]
kind = "detumbling"
"""
UNLOADING = """
[controller]
kind = "lqr"
[unloading]
kind = "torque_rods"
limit = [0.2, 0.2, 0.1]
compensation = 1.0
duty = 0.8
"""
SUN = """
[controller]
kind = "sun_pointing"
axis = [1.0, 0.0, 0.0]
[[sensor]]
kind = "sun_sensor"
sigma = "0.1 deg"
field_of_view = "60 deg"
[[sensor]]
kind = "coarse_sun_sensors"
sigma = 0.02
[[sensor]]
kind = "position"
sigma = "10 m"
"""
TRACKER = """
[controller]
kind = "wheel_array"
[sensors]
kind = "star_tracker_gyro"
attitude_sigma = "60 arcsec"
tracker_periods = 2
angle_walk = 1e-5
[[star_tracker]]
name = "left"
across_sigma = "5 arcsec"
about_sigma = "50 arcsec"
boresight = [0.0, 1.0, 0.0]
sun_exclusion = "40 deg"
earth_exclusion = "20 deg"
[[star_tracker]]
name = "right"
across_sigma = "5 arcsec"
about_sigma = "50 arcsec"
rate_limit = "0.5 deg/s"
"""
DISPERSION = """
[[dispersion]]
key = "{}"
distribution = "uniform"
low = "-20 %"
high = "20 %"
"""


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    folder = tmp_path_factory.mktemp("magnetic")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder / name)

    def make(*texts):
        (folder / "scenario.toml").write_text(HEAD + "".join(texts), encoding="utf-8")
        return read_scenario(folder / "scenario.toml")

    return make


def setup_of(scenario, **changes):
    values = {key: np.asarray(value) for key, value in {**scenario.values, **changes}.items()}
    # the program that has checked the scenario when it was read
    return plans._build(structure_of(scenario), values, plans_of(scenario))


def field_of(setup):
    """Earth's field in body axes at time 0, T."""
    rods = setup.plant.actuators["torque_rods"]
    return np.asarray(to_body(setup.start.attitude, rods.orbit.field(0.0)))


def test_detumbling_commands_the_rods_of_the_scenario(read):
    scenario = read(DETUMBLING, ORBIT, RODS, MAGNETOMETER)
    setup = setup_of(scenario, **{"sensor.magnetometer.sigma": 0.0})
    seen = first_measurement(setup.sensor, setup.start, 0.5)
    field = field_of(setup)
    np.testing.assert_allclose(seen.magnetometer, field + np.array([1e-7, 0.0, 0.0]), rtol=1e-10)
    _, command = setup.controller(setup.controller.start(0.5), seen)
    inertia = np.linalg.eigvalsh(setup.plant.spacecraft.inertia_locked())[0]
    gain = 4e-3 * inertia / np.sum(np.square(seen.magnetometer))
    rate = np.asarray(setup.plant.rate(setup.start))
    expected = gain * np.cross(rate, seen.magnetometer)
    np.testing.assert_allclose(command.torque_rods, expected, rtol=1e-10)
    rods = setup.plant.actuators["torque_rods"]
    torque = rods(command.torque_rods, setup.start.attitude, 0.0)
    clipped = np.clip(command.torque_rods, [-0.2, -0.2, -0.1], [0.2, 0.2, 0.1])
    np.testing.assert_allclose(torque, 0.8 * np.cross(clipped, field), rtol=1e-10)


@pytest.mark.parametrize(
    ("texts", "keys"),
    [
        (
            (DETUMBLING, RODS, MAGNETOMETER),
            ("actuator.torque_rods.limit.x", "sensor.magnetometer.bias.x", "controller.gain"),
        ),
        ((UNLOADING, RODS, MAGNETOMETER), ("unloading.gain", "actuator.torque_rods.duty")),
        ((SUN,), ("sensor.sun_sensor.field_of_view", "sensor.coarse_sun_sensors.sigma")),
        ((TRACKER,), ("star_tracker.left.sun_exclusion", "star_tracker.right.about_sigma")),
    ],
)
def test_numbers_of_all_parts_can_be_dispersed_and_the_loop_has_a_command(read, texts, keys):
    scenario = read(*texts, ORBIT, *(DISPERSION.format(key) for key in keys))
    assert set(keys) <= set(scenario.dispersed)
    setup = setup_of(scenario)
    seen = first_measurement(setup.sensor, setup.start, 0.5)
    _, command = setup.controller(setup.controller.start(0.5), seen)
    for name in command._fields:
        assert np.all(np.isfinite(np.asarray(getattr(command, name), dtype=float))), name
    for name in ("sun_sensor", "coarse_sun_sensors", "position", "tracker_heads"):
        if name in seen._fields:
            assert np.shape(getattr(seen, name)) == {
                "coarse_sun_sensors": (6,),
                "tracker_heads": (2,),
            }.get(name, (3,))


def test_thrusters_of_a_scenario_get_the_control_period(read):
    text = '[[actuator]]\nkind = "thrusters"\narm = "10 cm"\nforce = 0.05\nminimum = "20 ms"\n'
    thrusters = setup_of(read('[controller]\nkind = "lqr"\n', text)).plant.actuators["thrusters"]
    value = np.array([0.1, 0.1, 0.019, *np.zeros(9)])
    torque = thrusters(value, np.array([1.0, 0.0, 0.0, 0.0]), 0.0)
    np.testing.assert_allclose(torque, [2.0 * 0.1 * 0.05 * 0.1 / 0.5, 0.0, 0.0], rtol=1e-12)


def test_heads_of_a_scenario_replace_the_tracker(read):
    setup = setup_of(read(TRACKER, ORBIT))
    seen = first_measurement(setup.sensor, setup.start, 0.5)
    assert not seen.tracker_heads[1]  # the body turns faster than its limit
    slow = setup_of(read(TRACKER, ORBIT), **{"star_tracker.right.rate_limit": 1.0})
    seen = first_measurement(slow.sensor, slow.start, 0.5)
    assert seen.tracker_heads[1]
    assert seen.attitude_measured


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        ((DETUMBLING, ORBIT, RODS), r"detumbling without magnetometer, expected a \[\[sensor\]\]"),
        ((DETUMBLING, ORBIT, MAGNETOMETER), r"expected an \[\[actuator\]\] named torque_rods"),
        (
            (DETUMBLING, RODS, MAGNETOMETER),
            r"found \w+ without orbit, expected a section \[orbit\]",
        ),
        ((UNLOADING, ORBIT, RODS), r"key unloading: found torque_rods without magnetometer"),
        (
            ('[controller]\nkind = "sun_pointing"\n', ORBIT),
            "named sun_sensor or coarse_sun_sensors",
        ),
        (
            (
                TRACKER.replace('kind = "star_tracker_gyro"', 'kind = "white_noise"').replace(
                    "tracker_periods = 2\nangle_walk = 1e-5\n", ""
                ),
                ORBIT,
            ),
            r"key star_tracker.left: found head without star tracker, expected sensors with a star",
        ),
        (
            (TRACKER.replace('name = "left"', 'python = "a.py:B"'), ORBIT),
            r"star_tracker\[head\].*python",
        ),
        ((DETUMBLING, ORBIT, RODS, MAGNETOMETER.replace("latency = 1", "latency = 17")), "latency"),
    ],
)
def test_mistakes_give_one_line(read, texts, message):
    with pytest.raises(InputError, match=message) as found:
        read(*texts)
    assert "\n" not in str(found.value)


def test_a_detumbling_run_of_a_scenario(read):
    found = gs.simulate(read(DETUMBLING, ORBIT, RODS, MAGNETOMETER), seed=1)
    assert found.magnetometer.attrs["units"] == "T"
    assert found.torque_rods.attrs["units"] == "A·m²"
    # samples every second period, used one period later
    value = found.magnetometer.values
    np.testing.assert_array_equal(value[1], value[0])
    np.testing.assert_array_equal(value[3], value[4])
    assert np.all(value[3] != value[2])
