"""The compensator `estimating` in a scenario, as it is exported for flight."""

import subprocess

import gyrostat as gs
from gyrostat.scenario_files.scenario_file import read_scenario

SCENARIO = """
[run]
duration = "20 s"
control_period = "0.25 s"
command_delay = 1
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
torque_time = 20.0
[compensator]
kind = "estimating"
[sensors]
attitude_sigma = "0.003 deg"
rate_sigma = "0.002 deg/s"
tachometer_pulses = 24
"""


def test_it_is_exported_as_c(folder, tmp_path, tools):
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        (tmp_path / name).write_text((folder / name).read_text())
    (tmp_path / "scenario.toml").write_text(SCENARIO)
    crossing = read_scenario(tmp_path / "scenario.toml")
    out = tmp_path / "flight"
    gs.export(crossing, out, to="c")
    tools.build(out, "controller.c", "controller_test.c", "-O1", "-lm", "-o", "program")
    done = subprocess.run([out / "program"], capture_output=True, text=True)
    assert done.returncode == 0, [line for line in done.stdout.splitlines() if "not as" in line]
    assert "command.torque[3]: as in Python" in done.stdout
    assert "command.friction_torque[0]: as in Python" in done.stdout
