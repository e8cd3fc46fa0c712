"""Streaming, clocks and files: the same numbers for any division of the telemetry."""

import json

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest

import gyrostat
from gyrostat.core.errors import InputError
from gyrostat.monitoring import execute
from gyrostat.monitoring.blocks import Samples, blocks_of
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.windows import COLUMNS, read_windows
from tests.monitoring.closed_loop import NOMINAL, fly
from tests.monitoring.test_estimate import known

WHEELS = """
[[wheel]]
name = "a"
inertia = 1.5e-3
motor_constant = "27 mN·m/A"
coulomb = "0.9 mN·m"
viscous = 5e-6
stribeck_speed = 0.5
[wheel.sigma]
motor_constant = 1.35e-4
viscous = 1e-7
offset = 1e-9
[telemetry]
speed_resolution = "0.4 rpm"
"""
WINDOW = 21600.0


@pytest.fixture(scope="module")
def flight():
    return fly(4, slews=True, days=0.6)[0]


@pytest.fixture
def folder(tmp_path, flight):
    """Telemetry in two files, the second a CSV, and wheels.toml."""
    half = 30000
    columns = {
        "time": flight.time,
        "a_speed_rpm": flight.speed[:, 0] * 30.0 / np.pi,
        "a_current_mA": flight.drive[:, 0] * 1e3,
    }
    table = pyarrow.table({name: values[:half] for name, values in columns.items()})
    table = table.rename_columns(["time_s", *table.column_names[1:]])
    pyarrow.parquet.write_table(table, tmp_path / "one.parquet", row_group_size=7000)
    rows = np.column_stack([values[half:] for values in columns.values()])
    lines = ["time_s,a_speed_rpm,a_current_mA", *(",".join(map(repr, r)) for r in rows.tolist())]
    (tmp_path / "two.csv").write_text("\n".join(lines))
    (tmp_path / "wheels.toml").write_text(WHEELS)
    return tmp_path


def table_of(samples, cuts=()):
    monitor = WheelMonitor(known(), window=WINDOW)
    for piece in np.split(np.arange(len(samples)), cuts):
        monitor.add(samples.part(slice(piece[0], piece[-1] + 1)))
    return monitor.windows()


def assert_same(first, second):
    for name in COLUMNS:
        np.testing.assert_array_equal(first[name], second[name], name)


def test_sums_of_a_block_are_those_of_its_definition():
    random = np.random.default_rng(0)
    time = np.cumsum(random.uniform(0.5, 1.5, 400))
    samples = Samples(
        time, 5.0 * random.standard_normal((400, 2)), random.standard_normal((400, 2))
    )
    blocks, tail = blocks_of(samples, 60.0, 0.0)
    first = np.searchsorted(time, 120.0)
    last = np.searchsorted(time, 180.0)
    k = int(np.flatnonzero(blocks.start == time[first])[0])
    inside = slice(first, last + 1)
    span = time[last] - time[first]
    np.testing.assert_allclose(blocks.length[k], span)
    drive = samples.drive[inside]
    trapezoids = np.trapezoid(drive, time[inside], axis=0)
    start = (time[first + 1] - time[first]) * (drive[1] - drive[0])
    end = (time[last] - time[last - 1]) * (drive[-1] - drive[-2])
    np.testing.assert_allclose(blocks.drive[k], (trapezoids - (end - start) / 12.0) / span)
    np.testing.assert_allclose(blocks.change[k], samples.speed[last] - samples.speed[first])
    np.testing.assert_allclose(
        blocks.other_change[k], samples.speed[last + 1] - samples.speed[first + 1]
    )
    assert tail.time[0] == time[np.searchsorted(time, 60.0 * (time[-1] // 60.0))]


def test_slow_telemetry_of_a_slew_has_the_mean_of_its_current():
    """A sine has its integral in closed form; trapezoids of 10 s make it too small by 0.5 %."""
    time = 10.0 * np.arange(61.0)
    turn = 2.0 * np.pi / 250.0
    current = np.sin(turn * time)[:, None]
    blocks, _ = blocks_of(Samples(time, np.full((61, 1), 100.0), current), 60.0, 0.0)
    edges = np.cos(turn * np.append(blocks.start, blocks.start[-1] + 60.0))
    np.testing.assert_allclose(blocks.drive[:, 0], -np.diff(edges) / turn / 60.0, atol=1e-3)


def test_any_division_gives_the_same_table(flight):
    whole = table_of(flight)
    assert len(whole) == 3
    assert whole["valid"].all()
    assert_same(whole, table_of(flight, [1, 2, 59, 60, 61, 20000, 43199, 43201]))
    monitor = WheelMonitor(known(), window=WINDOW)
    for k in range(len(flight)):
        monitor.add_sample(flight.time[k], flight.speed[k], flight.drive[k])
    assert_same(whole, monitor.windows())


def test_a_current_of_the_opposite_sign_gives_no_valid_window(flight):
    opposite = Samples(flight.time, flight.speed, -flight.drive)
    table = table_of(opposite)
    assert not table["valid"].any()
    assert all("has the current the sign of its torque?" in why for why in table["why"])


def test_a_file_of_the_same_name_is_another_file_and_a_longer_one_is_not(folder, tmp_path):
    """Telemetry of another day often has the same name; telemetry that goes on is a longer file."""
    lines = (folder / "two.csv").read_text().splitlines()
    days = [tmp_path / "day1", tmp_path / "day2"]
    for day, rows in zip(days, (lines[:5001], [lines[0], *lines[5001:8001]]), strict=True):
        day.mkdir()
        (day / "two.csv").write_text("\n".join(rows) + "\n")
    out, said = tmp_path / "out", []
    for files in ([days[0]], [days[1]], [days[1]]):
        health = gyrostat.monitor(
            [day / "two.csv" for day in files],
            wheels=folder / "wheels.toml",
            out=out,
            window="6 h",
            say=said.append,
        )
    assert health.telemetry["rows"] == 8000 + 2  # with their headers
    assert health.telemetry["files"] == ["two.csv", "two.csv (2)"]
    assert sum("used before" in line for line in said) == 1
    (days[1] / "two.csv").write_text("\n".join([lines[0], *lines[5001:]]) + "\n")
    health = gyrostat.monitor(
        [days[1] / "two.csv"], wheels=folder / "wheels.toml", out=out, window="6 h"
    )
    assert health.telemetry["rows"] == len(lines) + 1
    assert health.telemetry["repeats"] == 0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("viscous = 5e-6", "viscous = -5e-6", "viscous: found -5e-06, expected a value of zero"),
        ("viscous = 1e-7", "", "found 0 without"),
        ('"0.4 rpm"', '"-0.4 rpm"', "speed_resolution: found -0.04"),
    ],
)
def test_impossible_values_of_wheels_are_refused(folder, old, new, message):
    text = WHEELS.replace(old, new)
    if "without" in message:
        text = text.replace("viscous = 5e-6", "viscous = 0.0")
    (folder / "wheels.toml").write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        gyrostat.monitor([folder / "two.csv"], wheels=folder / "wheels.toml")
    assert "\n" not in str(caught.value)


def test_blocks_with_a_gap_are_left_out_and_counted(flight):
    present = np.ones(len(flight), bool)
    present[10000:16000] = False
    table = table_of(flight.part(present))
    assert table["gap_share"][0] == pytest.approx(6000.0 / WINDOW, abs=0.005)
    assert table["samples"][0] < WINDOW - 6000.0 + 61.0
    assert table["valid"][0]


def test_repeats_are_left_out(flight):
    order = np.r_[0:9000, 8000:30000]
    assert_same(table_of(flight.part(slice(0, 30000))), table_of(flight.part(order)))


def test_files_give_the_numbers_of_the_samples(folder, flight):
    health = gyrostat.monitor(
        [folder / "two.csv", folder / "one.parquet"], wheels=folder / "wheels.toml", window="6 h"
    )
    table = table_of(flight)
    # units are converted there and back
    for name in ("coulomb", "viscous", "motor_constant"):
        np.testing.assert_allclose(health.windows[name], table[name], rtol=1e-6)


def test_a_wild_time_is_left_out_with_a_line_also_between_two_calls(folder):
    """The wild time is the last row of the first call: nothing has confirmed or denied it yet."""
    lines = (folder / "two.csv").read_text().splitlines()
    wild = ",".join(["9e9", *lines[5000].split(",")[1:]])
    options = {"wheels": folder / "wheels.toml", "window": "6 h"}
    (folder / "two.csv").write_text("\n".join([*lines[:5001], wild]) + "\n")
    gyrostat.monitor([folder / "one.parquet", folder / "two.csv"], folder / "out", **options)
    (folder / "two.csv").write_text("\n".join([*lines[:5001], wild, *lines[5001:]]) + "\n")
    health = gyrostat.monitor(folder / "two.csv", folder / "out", **options)
    (folder / "two.csv").write_text("\n".join(lines) + "\n")
    files = [folder / "one.parquet", folder / "two.csv"]
    assert_same(health.windows, gyrostat.monitor(files, **options).windows)
    assert health.telemetry["wild_times"] == 1
    assert any(note.startswith("1 sample with times an hour") for note in health.notes)


def test_a_call_goes_on_where_the_telemetry_ended(folder):
    options = {"wheels": folder / "wheels.toml", "window": "6 h"}
    files = [folder / "one.parquet", folder / "two.csv"]
    gyrostat.monitor(files, folder / "whole", **options)
    gyrostat.monitor(files[:1], folder / "parts", **options)
    assert len(read_windows(folder / "parts" / "windows.parquet")) == 2
    health = gyrostat.monitor(files, folder / "parts", **options)
    for name in ("windows.parquet", "health.json", "wheels/a/model.toml"):
        assert (folder / "parts" / name).read_bytes() == (folder / "whole" / name).read_bytes()
    model = gyrostat.read_model(folder / "whole" / "wheels" / "a" / "model.toml")
    assert model.values["coulomb"] == health.latest("a")["coulomb"]
    content = json.loads((folder / "whole" / "health.json").read_text())
    assert content["wheels"]["a"]["latest"]["coulomb"]["observable"]
    assert content["alarms"] == []


def test_a_killed_call_leaves_nothing_that_changes_the_next(folder, monkeypatch):
    options = {"wheels": folder / "wheels.toml", "window": "6 h"}
    files = [folder / "one.parquet", folder / "two.csv"]
    gyrostat.monitor(files, folder / "whole", **options)
    monkeypatch.setattr(execute, "CHECKPOINT", 0.0)
    monkeypatch.setattr(execute, "PART", 4000)
    save, calls, said = execute.save_state, [], []

    def killed(*arguments):
        save(*arguments)
        calls.append(1)
        if len(calls) == 5:
            raise KeyboardInterrupt

    monkeypatch.setattr(execute, "save_state", killed)
    with pytest.raises(KeyboardInterrupt):
        gyrostat.monitor(files, folder / "killed", say=said.append, **options)
    assert said[:2] == ["one.parquet: row 4000", "one.parquet: row 8000"]
    assert not (folder / "killed" / "windows.parquet").exists()
    gyrostat.monitor(files, folder / "killed", **options)
    name = "windows.parquet"
    assert (folder / "killed" / name).read_bytes() == (folder / "whole" / name).read_bytes()


def test_bad_input_is_one_line(folder):
    wheels = folder / "wheels.toml"
    other, bare = folder / "b.toml", folder / "c.toml"
    other.write_text(WHEELS.replace('"a"', '"b"'))
    bare.write_text('[[wheel]]\nname = "a"\ninertia = 1e-3\ncoulomb = 1e-3\nviscous = 1e-6\n')
    with pytest.raises(InputError, match=r"one.parquet.*b_speed"):
        gyrostat.monitor(folder / "one.parquet", wheels=other)
    with pytest.raises(InputError, match="multiple of 60 s"):
        gyrostat.monitor(folder / "one.parquet", wheels=wheels, window="100 s")
    with pytest.raises(InputError, match="motor_constant: found none"):
        gyrostat.monitor(folder / "one.parquet", wheels=bare)
    gyrostat.monitor(folder / "one.parquet", folder / "out", wheels=wheels)
    with pytest.raises(InputError, match="restart"):
        gyrostat.monitor(folder / "one.parquet", folder / "out", wheels=wheels, window="6 h")


def test_nominal_values_of_the_test_are_those_of_its_file(folder):
    wheel = gyrostat.monitoring.read_wheels(folder / "wheels.toml").wheels[0]
    assert {name: getattr(wheel, name) for name in NOMINAL} == pytest.approx(NOMINAL)
