"""Directed nonsense: impossible numbers are refused by their key, unlikely ones are named by it."""

from pathlib import Path

import pytest

from gyrostat.core.errors import InputError
from gyrostat.scenario.unlikely import unlikely_numbers, unlikely_spacecraft
from gyrostat.scenario_files import scenario_file
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft import read_spacecraft
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements, checksum

EXAMPLES = Path(__file__).parents[2] / "examples"
FILES = ("wheel_array.toml", "cubesat.toml", "cubesat_wheel.toml")
MODE = '[[flexible]]\nname = "wing"\nfrequency = "{}"\ndamping = {}\nparticipation = [0.05, 0, 0]\n'
INERTIA = "inertia = [0.06, 0.12, 0.14]"


def changed(folder, name, old, new):
    """Copy of the example with one text replaced, or with a text at its end."""
    for each in FILES:
        text = (EXAMPLES / "scenarios" / each).read_text()
        if each == name:
            assert old in text
            text = text.replace(old, new, 1) if old else text + new
        (folder / each).write_text(text)
    return folder / FILES[0]


SCENARIO, CRAFT, WHEEL = FILES
REQUIREMENT = """
[[requirement]]
index = "{}"
level = 0.9
value = "{}"
interpretation = "mixed"
axis = "full"
"""
REFUSED = (
    (CRAFT, INERTIA, "inertia = [1e-5, 1e-5, 1e-5]", "body.inertia"),
    (CRAFT, INERTIA, "inertia = [6e-6, 1.2e-5, 1.4e-5]", "body.inertia"),
    (CRAFT, INERTIA, "inertia = [0.06, 0.12, 0.18]", "body.inertia"),
    (CRAFT, INERTIA, "inertia = [0.06, 0.12, 0.25]", "body.inertia"),
    (CRAFT, INERTIA, "inertia = [0.06, -0.12, 0.14]", "body.inertia"),
    (CRAFT, INERTIA, "inertia = [0.0, 0.12, 0.14]", "body.inertia"),
    (CRAFT, INERTIA, "inertia = [nan, 0.12, 0.14]", "body.inertia"),
    (CRAFT, INERTIA, "inertia = [inf, 0.12, 0.14]", "body.inertia"),
    (CRAFT, INERTIA, 'inertia = [0.06, 0.12, "0.14 kg"]', "body.inertia"),
    (CRAFT, INERTIA, INERTIA + '\nmass = "0 kg"', "body.mass"),
    (CRAFT, INERTIA, INERTIA + '\nmass = "-8 kg"', "body.mass"),
    (CRAFT, "axis = [1.0, 1.0, 1.0]", "axis = [0, 0, 0]", "axis"),
    (CRAFT, "1 mN·m", "-1 mN·m", "torque_limit"),
    (CRAFT, '"10 mN·m·s"', '"0 N·m·s"', "momentum_limit"),
    (CRAFT, '"10 mN·m·s"', '"10 mN·m"', "momentum_limit"),
    (CRAFT, "", MODE.format("1e6 Hz", 0.0), "flexible.wing.frequency"),
    (CRAFT, "", MODE.format("100 Hz", 0.0), "flexible.wing.frequency"),
    (CRAFT, "", MODE.format("0 Hz", 0.0), "frequency"),
    (CRAFT, "", MODE.format("1 Hz", -0.1), "damping"),
    (WHEEL, "2.0e-05         # kg", "20.0         # kg", "body.inertia"),
    (WHEEL, "2.0e-05         # kg", "-2.0e-05         # kg", "inertia"),
    (WHEEL, "coulomb = 2.0e-05", "coulomb = -2.0e-05", "coulomb"),
    (WHEEL, "viscous = 1.0e-07", "viscous = -1.0e-07", "viscous"),
    (WHEEL, "stribeck_speed = 2.0", "stribeck_speed = 0.0", "stribeck_speed"),
    (SCENARIO, '"97.4 deg"', "97.4", "inclination"),
    (SCENARIO, '"97.4 deg"', '"181 deg"', "inclination"),
    (SCENARIO, '"97.4 deg"', '"-1 deg"', "inclination"),
    (SCENARIO, '"97.4 deg"', "3.15", "inclination"),
    (SCENARIO, "altitude = 500e3", "altitude = -500e3", "altitude"),
    (SCENARIO, "tracker_periods = 4", "tracker_periods = 0", "tracker_periods"),
    (SCENARIO, '"0.25 s"', '"0 s"', "control_period"),
    (SCENARIO, '"600 s"', '"-600 s"', "duration"),
    (SCENARIO, '"0.003 deg"', '"-0.003 deg"', "attitude_sigma"),
    (SCENARIO, '"1500 rpm", "-1500', '"1e6 rpm", "-1500', "wheel"),
    (SCENARIO, 'sigma = "20 %"', 'sigma = "-20 %"', "sigma"),
    (SCENARIO, 'sigma = "20 %"', 'sigma = "２０ %"', "sigma"),
    *(
        (SCENARIO, 'after = "300 s"', f'[[metrics.window]]\nname = "{name}"\nfrom = 10.0', name)
        for name in ("error_max", "error_p95", "settling", "energy", "status", "run", "ended")
    ),
)
UNLIKELY = (
    (CRAFT, INERTIA, INERTIA + '\nmass = "8000 kg"', "body.mass"),
    (CRAFT, INERTIA, INERTIA + "\nmass = 8e-6", "body.mass"),
    (
        CRAFT,
        INERTIA,
        INERTIA + '\nmass = "8 kg"\ncentre_of_mass = [1e3, 0, 0]',
        "centre_of_mass",
    ),
    (CRAFT, INERTIA, INERTIA + "\ncentre_of_mass = [0, 0, 2000.0]", "centre_of_mass"),
    (CRAFT, "", MODE.format("0.5 Hz", 1.5), "flexible.wing.damping"),
    (CRAFT, "", MODE.format("0.5 Hz", 50), "flexible.wing.damping"),
    (CRAFT, "1 mN·m", "1 µN·m", "wheel.a"),
    (WHEEL, "static = 3.0e-05", "static = 3.0e-02", "wheel.a"),
    (WHEEL, "coulomb = 2.0e-05", "coulomb = 2.0e-02", "wheel.a"),
    (WHEEL, "viscous = 1.0e-07", "viscous = 1.0e-04", "wheel.a"),
    (SCENARIO, '"0.003 deg"', '"1.5 deg"', "sensors.attitude_sigma"),
    (SCENARIO, '"0.003 deg"', "10.0", "sensors.attitude_sigma"),
    (SCENARIO, '"0.003 deg"', "0.03", "sensors.attitude_sigma"),
    (SCENARIO, '"0.5 deg", "-0.3 deg"', '30.0, "-0.3 deg"', "start.attitude_error.x"),
    (SCENARIO, '"0.5 deg", "-0.3 deg"', '"0.5 deg", -5.0', "start.attitude_error.y"),
    (SCENARIO, 'sigma = "20 %"', 'sigma = "300 %"', "coulomb"),
    (SCENARIO, 'sigma = "3 %"', 'sigma = "300 %"', "body.inertia.yy"),
    (SCENARIO, 'sigma = "0.003 deg/s"', 'sigma = "300 %"', "sensors.bias.z"),
    (SCENARIO, 'sigma = "0.003 deg/s"', 'sigma = "150 %"', "sensors.bias.z"),
    (SCENARIO, "altitude = 500e3", "altitude = 500e3\nlatitude = 45.0", "environment.latitude"),
    (SCENARIO, "altitude = 500e3", "altitude = 5e11", "environment.altitude"),
    (CRAFT, "1 mN·m", "1e3 N·m", "wheel.a.torque_limit"),
    (SCENARIO, 'sigma = "3 %"', 'sigma = "30 %"', "body.inertia"),
    (SCENARIO, '"0.25 s"', '"1 s"\ncommand_delay = 600', "command_delay"),
    (SCENARIO, "", REQUIREMENT.format("APE", "180 deg"), "requirement"),
    (SCENARIO, "", REQUIREMENT.format("RPE", "7") + "window = 1.0", "requirement"),
    (SCENARIO, "altitude = 500e3", "altitude = 5e5\nascending_node = 120", "ascending_node"),
)


@pytest.mark.parametrize("case", REFUSED, ids=lambda case: case[2][:40])
def test_an_impossible_number_is_refused_by_its_key(tmp_path, case):
    *change, key = case
    path = changed(tmp_path, *change)
    with pytest.raises(InputError, match=r"found .*expected") as error:
        read_scenario(path)
    assert key in str(error.value)
    assert ".toml" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("case", UNLIKELY, ids=lambda case: case[2][:40])
def test_an_unlikely_number_is_named_by_its_key(tmp_path, case):
    *change, key = case
    lines = unlikely_numbers(read_scenario(changed(tmp_path, *change)))
    assert any(key in line for line in lines)
    assert all("\n" not in line for line in lines)


HUMP = """import jax.numpy as jnp
from gyrostat.wheel.friction import Friction, parameter

class Hump(Friction):
    coulomb: float = parameter("torque")

    def torque(self, speed, direction):
        hump = jnp.exp(-(((jnp.abs(speed) - 250.0) / 80.0) ** 2))
        return direction * self.coulomb * (1.0 + 50.0 * hump)

    def speed_scale(self):
        return 30.0
"""


def test_friction_is_compared_with_the_motor_between_rest_and_the_fastest_speed(tmp_path):
    (tmp_path / "mine.py").write_text(HUMP)
    old = (EXAMPLES / "scenarios" / WHEEL).read_text().partition("[friction]")[2]
    path = changed(tmp_path, WHEEL, old, '\nmodel = "mine.py:Hump"\ncoulomb = 2.1e-5\n')
    lines = unlikely_numbers(read_scenario(path))
    assert "wheel.a: friction of 0.001071 N·m at 250 rad/s is above torque_limit" in lines[0]


def test_no_number_of_the_examples_is_unlikely(monkeypatch):
    """Those of the ready scenarios are tested where they are traced."""
    monkeypatch.setattr(scenario_file, "validated", lambda scenario: scenario)
    read = 0
    for path in sorted(EXAMPLES.rglob("*.toml")):
        text = path.read_text()
        if "[run]" in text and path.parent.name != "scenarios":
            assert unlikely_numbers(read_scenario(path)) == [], path
        elif "[body]" in text:
            assert unlikely_spacecraft(read_spacecraft(path)) == [], path
        else:
            continue
        read += 1
    assert read > 5


LINES = (
    "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
    "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
)


@pytest.mark.parametrize(
    ("line", "column", "text"),
    [
        *((1, column, " ") for column in (22, 25, 35, 38, 46, 48, 55, 57)),
        *((2, column, " ") for column in (12, 14, 20, 28, 32, 37, 46, 55, 58)),
        *((2, column, "٣") for column in (9, 14, 20, 30, 37, 46, 56)),
        *((2, column, "x") for column in (14, 20, 30, 37, 46, 56)),
        (2, 8, "194.2682"),
        (2, 8, " -4.2682"),
    ],
)
def test_a_field_of_two_line_elements_that_is_no_number_is_refused(line, column, text):
    row = LINES[line - 1]
    row = row[:column] + text + row[column + len(text) :]
    row = row[:-1] + str(checksum(row))
    lines = (row, LINES[1]) if line == 1 else (LINES[0], row)
    with pytest.raises(InputError, match=r"line \d.*found .*expected"):
        TwoLineElements(*lines)
