"""Telemetry in several logs: joined on the times of the first, against values at stated times."""

import numpy as np
import pyarrow.parquet
import pytest

import gyrostat
from gyrostat.core.errors import InputError
from gyrostat.monitoring.logs import join_logs, read_logs_map
from gyrostat.monitoring.wheels_file import read_wheels
from tests.monitoring.closed_loop import fly
from tests.monitoring.test_stream import WHEELS

MAP = """
[[log]]
file = "RW?.csv"
[log.columns]
time = "stamp"
a_speed = "rate"
[log.units]
a_speed = "rpm"
[[log]]
file = "control.csv"
[log.columns]
time = "seconds"
a_torque = "command"
temperature = "warm"
[log.units]
time = "s"
a_torque = "mN·m"
temperature = "°C"
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "wheels.toml").write_text(WHEELS)
    (tmp_path / "map.toml").write_text(MAP)
    day = [f"2026-03-01T00:00:{k:02d}Z,{10 * k}" for k in range(0, 40, 4)]
    for name, rows in (("RW1.csv", day[4:]), ("RW0.csv", day[:5])):  # one row is in both
        (tmp_path / name).write_text("\n".join(["stamp,rate", *rows]) + "\n")
    start = np.datetime64("2026-03-01T00:00:00", "s").astype(int)
    moments = [k for k in range(-3, 34, 3) if not 10 < k < 22]
    rows = [f"{start + k},{k},{20.0 + k}" for k in moments]
    (tmp_path / "control.csv").write_text("\n".join(["seconds,command,warm", *rows]) + "\n")
    return tmp_path


def join(folder, *names):
    known = read_wheels(folder / "wheels.toml")
    logs = read_logs_map(folder / "map.toml")
    join_logs([folder / name for name in names], logs, known, folder / "joined.parquet")
    return pyarrow.parquet.read_table(folder / "joined.parquet").to_pydict()


def test_commands_are_held_and_temperatures_interpolated_on_the_times_of_the_first_log(folder):
    table = join(folder, "control.csv", "RW1.csv", "RW0.csv")
    time = np.array(table["time [s]"])
    seconds = time - time[0]
    np.testing.assert_array_equal(seconds, np.arange(0.0, 40.0, 4.0))
    np.testing.assert_allclose(np.array(table["a_speed [rad/s]"]) * 30.0 / np.pi, 10.0 * seconds)
    # commands every 3 s until 9 s, then from 24 s to 33 s; held for 9 s at most
    held = np.array([0, 3, 6, 9, 9, np.nan, 24, 27, 30, 33])
    np.testing.assert_allclose(np.array(table["a_torque [N·m]"]) * 1e3, held)
    warm = np.array([20, 24, 28, np.nan, np.nan, np.nan, 44, 48, 52, np.nan])
    np.testing.assert_allclose(table["temperature [°C]"], warm)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("RW?.csv", "RWX.csv"), "RW0.csv: found no log of this name, expected one of RWX.csv"),
        (('"rate"', '"speed"'), "RW0.csv.*found columns 'stamp', 'rate'"),
        (('time = "stamp"\n', ""), "log 1: found no column for time"),
        (('a_torque = "command"', 'a_speed = "command"'), "found a_speed in two logs|a_speed"),
        (('[log.units]\na_speed = "rpm"\n', ""), "RW0.csv.*found no unit"),
    ],
)
def test_a_map_that_does_not_fit_is_refused_in_one_line(folder, change, message):
    (folder / "map.toml").write_text(MAP.replace(*change))
    with pytest.raises(InputError, match=message) as caught:
        join(folder, "RW0.csv", "control.csv")
    assert "\n" not in str(caught.value)
    assert not (folder / "joined.parquet").exists()


def test_logs_give_the_health_of_one_file(tmp_path):
    flight = fly(4, slews=True, days=0.3)[0]
    (tmp_path / "wheels.toml").write_text(WHEELS)
    speed = np.column_stack([flight.time, flight.speed[:, 0]])
    drive = np.column_stack([flight.time, flight.drive[:, 0]])
    text = 'file = "%s.csv"\n[log.columns]\ntime = "time [s]"\na_%s = "%s"\n'
    parts = []
    for name, role, unit, values in (("w", "speed", "rad/s", speed), ("i", "current", "A", drive)):
        column = f"x [{unit}]"
        np.savetxt(
            tmp_path / f"{name}.csv", values, "%.17g", ",", header=f"time [s],{column}", comments=""
        )
        parts.append("[[log]]\n" + text % (name, role, column))
    (tmp_path / "map.toml").write_text("".join(parts))
    both = np.column_stack([speed, drive[:, 1]])
    header = "time [s],a_speed [rad/s],a_current [A]"
    np.savetxt(tmp_path / "one.csv", both, "%.17g", ",", header=header, comments="")
    options = {"wheels": tmp_path / "wheels.toml", "window": "6 h"}
    expected = gyrostat.monitor(tmp_path / "one.csv", **options).windows
    files = [tmp_path / "w.csv", tmp_path / "i.csv"]
    options["columns"] = tmp_path / "map.toml"
    health = gyrostat.monitor(files, tmp_path / "out", **options)
    for name in ("coulomb", "viscous", "motor_constant"):
        np.testing.assert_allclose(health.windows[name], expected[name], rtol=1e-9)
    assert (tmp_path / "out" / "telemetry.parquet").exists()
    # a second call knows the joined telemetry
    said = []
    gyrostat.monitor(files, tmp_path / "out", say=said.append, **options)
    assert any("telemetry.parquet: left out, it was used before" in line for line in said)


def test_template_names_the_columns_and_is_filled_in_to_a_map(run, folder):
    command = ["monitor", folder / "RW0.csv", folder / "control.csv", "--wheels"]
    command += [folder / "wheels.toml", "--columns-template", "--out", folder / "out"]
    code, _, err = run(*command)
    assert code == 0, err
    path = folder / "out" / "columns.toml"
    text = path.read_text(encoding="utf-8")
    assert '# columns: "seconds", "command", "warm"' in text
    first, second = text.split("[[log]]")[1:]
    first = first.replace('time = ""', 'time = "stamp"').replace(
        '# a_speed = ""', 'a_speed = "rate"'
    )
    second = second.replace('time = ""', 'time = "seconds"').replace("# time =", "time =")
    second = second.replace('# a_torque = ""', 'a_torque = "command"').replace(
        "# a_torque =", "a_torque ="
    )
    (folder / "map.toml").write_text(
        "[[log]]" + first.replace("# a_speed =", "a_speed =") + "[[log]]" + second
    )
    table = join(folder, "RW0.csv", "control.csv")
    assert table["a_torque [N·m]"][1] == pytest.approx(3.0)
