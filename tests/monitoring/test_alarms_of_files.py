"""`gyrostat monitor` on files of a fleet: alarm, class and forecast, and bad settings."""

import json

import pytest
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat.cli import app
from gyrostat.core.errors import InputError
from gyrostat.monitoring.fleet.faults.motor_constant import MotorConstant
from gyrostat.monitoring.fleet.faults.tachometer import Tachometer
from gyrostat.monitoring.fleet.files import write_fleet
from gyrostat.monitoring.fleet.flight import Cell, Fleet, Flight
from gyrostat.monitoring.fleet.pointing import LOW, SLEWS
from gyrostat.monitoring.fleet.sampling import Sampling
from gyrostat.monitoring.fleet.vehicle import LARGE


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Six days of a flight; a motor weakens on the fourth, a tachometer fails on the sixth."""
    faults = (MotorConstant(wheel=1, day=3.0, size=-0.06), Tachometer(2, day=5.0, size=-0.03))
    there = tmp_path_factory.mktemp("fleet")
    fleet = Fleet(Cell(LARGE, LOW, SLEWS), [Flight(2, faults)])
    write_fleet(there, fleet, 6, Sampling(period=10.0))
    return there / "flight2"


def test_alarm_names_the_wheel_and_its_class(folder, tmp_path):
    command = ["monitor", str(folder / "telemetry.parquet"), "--wheels"]
    command += [str(folder / "wheels.toml"), "--spacecraft", str(folder / "spacecraft.toml")]
    command += ["--out", str(tmp_path / "out"), "--friction-limit", "4 mN·m"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 1, result.output
    health = json.loads((tmp_path / "out" / "health.json").read_text(encoding="utf-8"))
    # the body rates contradict the speed of the third wheel, not those of the others
    assert [alarm["wheel"] for alarm in health["alarms"]] == ["wheel2", "wheel3"]
    assert health["changes"]["wheel3"]["classes"] == ["tachometer fault"]
    for wheel, scale in (("wheel1", 1.0), ("wheel3", 1.0 / 0.97)):
        found = health["wheels"][wheel]["latest"]["speed_scale"]
        assert found["interval"][0] < scale < found["interval"][1]
        assert f"speed_scale     {found['value']:.4f}" in result.output
    change = health["changes"]["wheel2"]
    assert change["classes"][0] == "motor constant"
    assert change["onset"]["start"] == pytest.approx(3 * 86400.0)
    assert health["changes"]["wheel1"]["forecast"]["reached_within_a_year"] < 0.5
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert '<a href="#wheel2">wheel2</a>: ALARM: motor constant' in page
    assert page.count("true over measured speed") == 4
    assert health["assumed"]["faults_per_wheel_year"]["motor constant"] > 0.0


def test_settings_that_cannot_be_used(folder):
    files = {"wheels": folder / "wheels.toml", "spacecraft": folder / "spacecraft.toml"}
    with pytest.raises(InputError, match=r"fault_rates: found the class 'rust', expected one of"):
        gs.monitor(folder / "telemetry.parquet", **files, fault_rates="rust=0.1")
    with pytest.raises(InputError, match=r"friction.limit: found -0.003"):
        gs.monitor(folder / "telemetry.parquet", **files, friction_limit="-3 mN·m")
    with pytest.raises(InputError, match=r"false_alarms: found 0, expected"):
        gs.monitor(folder / "telemetry.parquet", **files, false_alarms=0.0)
