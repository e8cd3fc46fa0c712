"""Telemetry that cannot be used, or has another unit than it says: told with the reason."""

import re
from dataclasses import replace

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
import scipy.signal

import gyrostat
from gyrostat.core.errors import InputError
from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.stream import WheelMonitor
from tests.monitoring.closed_loop import NOMINAL, fly
from tests.monitoring.test_stream import WINDOW, flight, folder, known, table_of

__all__ = ["flight", "folder"]


def changed(flight, every=1, **columns):
    part = flight.part(slice(None, None, every))
    return replace(part, **{name: change(getattr(part, name)) for name, change in columns.items()})


@pytest.mark.parametrize(
    ("every", "columns", "reason"),
    [
        (20, {}, r"0 of \d+ blocks are usable, at least 30 are needed: \d+ with a gap, less than"),
        (1, {"drive": lambda i: np.nan * i}, r"needed: 360 with no current or torque$"),
        (1, {"speed": lambda w: 0.01 * w}, r"360 with a speed below 2.5 rad/s or of both signs$"),
        (1, {"drive": lambda i: 0.0 * i + 0.06}, "needed: 360 with a stuck sensor of cur"),
        (1, {"drive": lambda i: -i}, "the drive opposes the speed where nothing else brakes"),
        (1, {"drive": lambda i: 1e3 * i}, r"torque is 1.*e\+03 times .*: is the unit of current"),
        (1, {"drive": lambda i: 1e-3 * i}, r"torque is 0.001.* times that of the stated friction"),
    ],
)
def test_telemetry_that_cannot_be_used_has_rows_that_say_why(flight, every, columns, reason):
    table = table_of(changed(flight, every, **columns))
    assert len(table) == 3
    assert not table["valid"].any()
    for parameter in ("coulomb", "motor_constant"):
        assert re.search(reason, table[f"{parameter}_reason"][0])
    assert re.search(reason, table["why"][0])


@pytest.mark.parametrize(
    ("times", "reason"),
    [
        (np.pi / 30.0, "0.10.* stated one, as if speeds in rad/s were read as rpm: are the units"),
        (30.0 / np.pi, "9.* stated one, as if speeds in rpm were read as rad/s: are the units"),
        (3.1, r"3\.[01]\d* times the stated one: are the units"),
    ],
)
def test_speeds_in_another_unit_are_told_without_body_rates(flight, times, reason):
    fast = table_of(replace(changed(flight, speed=lambda w: times * w), rate=None))
    assert len(fast) == 3
    assert not fast["valid"].any()
    assert re.search(reason, fast["why"][0])


def test_times_in_another_unit_are_told(run, folder):
    lines = (folder / "two.csv").read_text().splitlines()
    rows = [line.split(",", 1) for line in lines[1:]]
    command = ["--wheels", folder / "wheels.toml", "--out", folder / "out"]
    for name, factor in (("fast.csv", 1e-3), ("slow.csv", 1e3)):
        times = [f"{float(time) * factor!r},{rest}" for time, rest in rows]
        (folder / name).write_text("\n".join([lines[0], *times]))
    code, _, err = run("monitor", folder / "fast.csv", *command)
    assert code == 1  # no result
    assert "no window yet: the telemetry lasts 21.8" in err
    code, _, err = run("monitor", folder / "slow.csv", *command)
    assert code == 2
    assert "found times 1000 s apart, expected 15 s at most: is the unit of the times right?" in err


@pytest.mark.parametrize(
    ("torque", "noise", "share"), [(0.0, 0.0, np.nan), (0.0, 0.05, np.nan), (0.2, 0.05, 1.0)]
)
def test_a_wheel_that_is_off_does_not_seize(flight, torque, noise, share):
    full = NOMINAL["coulomb"] / NOMINAL["motor_constant"]
    random = np.random.default_rng(0).standard_normal(flight.drive.shape)
    current = (torque + noise * random) * full
    still = {"speed": lambda w: 0.0 * w, "drive": lambda i: current}
    np.testing.assert_equal(table_of(changed(flight, **still))["standstill_share"], share)


def test_dates_without_a_log_are_told_where_they_are_read(run, folder):
    (folder / "dates.csv").write_text("time,a_speed_rpm\n2026-03-01T12:00:00Z,1\n")
    wheels = folder / "wheels.toml"
    code, _, err = run("monitor", folder / "dates.csv", "--wheels", wheels, "--out", folder / "out")
    assert code == 2
    assert "are read with [[log]] in a file of columns, which --columns-template writes" in err


def test_kelvin_taken_for_degrees_are_told(folder):
    table = pyarrow.parquet.read_table(folder / "one.parquet")
    warm = table.append_column("temperature_degC", pyarrow.array(np.full(len(table), 293.0)))
    pyarrow.parquet.write_table(warm, folder / "warm.parquet")
    health = gyrostat.monitor(folder / "warm.parquet", wheels=folder / "wheels.toml")
    assert "temperatures of up to 293 °C: is their unit right?" in health.notes


@pytest.mark.parametrize("steady", [True, False])
def test_a_speed_of_one_value_is_told_and_may_be_held(folder, steady):
    table = pyarrow.parquet.read_table(folder / "one.parquet")
    constant = {"a_speed": 1437.3, "a_current": 0.061} if steady else {"a_speed": 1437.3}
    for start, value in constant.items():
        name = next(each for each in table.column_names if each.startswith(start))
        values = np.full(len(table), value)
        values[::2] += 1e-3 * (start == "a_current")
        table = table.set_column(table.column_names.index(name), name, pyarrow.array(values))
    pyarrow.parquet.write_table(table, folder / "held.parquet")
    health = gyrostat.monitor(folder / "held.parquet", wheels=folder / "wheels.toml")
    told = [note for note in health.notes if "one value" in note]
    assert len(told) == 1
    if steady:
        assert told[0].startswith("the speed of a has one value in ")
        assert told[0].endswith("is it held, or is its sensor stuck?")
    else:  # slews that the speed does not show
        assert "a sensor of speed or drive of a holds one value for minutes" in told[0]


@pytest.mark.parametrize("times", [0.6, 0.8, 1.3, 1.5])
def test_a_stated_motor_constant_that_is_far_off_does_not_hold(flight, times):
    # speeds and stated inertia give the motor constant; 0.5 % is stated of it, which is wrong
    table = table_of(replace(changed(flight, speed=lambda w: times * w), rate=None))
    right = table_of(replace(flight, rate=None))
    assert table["valid"].all()
    for name in ("motor_constant", "coulomb"):
        sigma = np.hypot(table[f"{name}_sigma"] / times, right[f"{name}_sigma"])
        assert np.all(np.abs(table[name] / times - right[name]) < 3.0 * sigma)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        (([1.0, 2.0], [0.1]), r"speed: found shape \(1, 2\), expected \(1, 1\)"),
        (([1.0], [0.1], [1.0, 2.0]), r"rate: found shape \(1, 2\), expected \(1, 3\)"),
        (([1.0], [0.1], None, 20.0), r"temperature: found shape \(1,\), expected \(1, 1\)"),
        (([1.0], [[0.1], [0.2]]), r"drive: found shape \(2, 1\), expected \(1, 1\)"),
    ],
)
def test_samples_of_another_shape_are_refused_and_nothing_is_lost(flight, values, text):
    monitor = WheelMonitor(known(), window=WINDOW)
    monitor.add(flight.part(slice(20000)))
    with pytest.raises(InputError, match=text):
        monitor.add_sample(20000.0, *values)
    with pytest.raises(InputError, match=r"speed: found shape \(6, 2\), expected \(6, 1\)"):
        monitor.add(replace(flight.part(slice(6)), speed=np.ones((6, 2))))
    monitor.add(flight.part(slice(20000, None)))
    np.testing.assert_equal(monitor.windows()["coulomb"], table_of(flight)["coulomb"])


def test_a_motor_constant_that_falls_by_half_in_flight_is_no_wrong_unit(flight):
    second = flight.time >= WINDOW
    weak = replace(flight, drive=np.where(second[:, None], flight.drive / 0.45, flight.drive))
    right, table = table_of(flight), table_of(weak)
    assert table["valid"].all()
    ratio = table["motor_constant"] / right["motor_constant"]
    assert ratio == pytest.approx([1.0, 0.45, 0.45], rel=2e-3)


def test_a_motor_constant_stated_exactly_is_not_used_if_it_is_wrong(flight):
    wheel = known().wheels[0]
    exact = replace(wheel, motor_constant=1.25 * wheel.motor_constant)
    exact = replace(exact, sigma={**wheel.sigma, "motor_constant": 1e-9})
    monitor = WheelMonitor(replace(known(), wheels=(exact,)), window=WINDOW)
    monitor.add(flight)
    table, right = monitor.windows(), table_of(flight)
    assert np.all(np.abs(table["coulomb"] / right["coulomb"] - 1.0) < 0.03)


def test_viscous_friction_that_is_off_leaves_the_motor_constant_as_stated():
    # without slews, either could be wrong: motor constants vary less than viscous friction
    random, time = np.random.default_rng(3), np.arange(WINDOW + 3.0)
    speed = 150.0 + 200.0 * time / WINDOW
    keep = np.exp(-1.0 / 1200.0)
    shocks = 0.02 * np.sqrt(1.0 - keep**2) * random.standard_normal(time.size)
    noise = scipy.signal.lfilter([1.0], [1.0, -keep], shocks)
    torque = NOMINAL["coulomb"] * (1.0 + noise) + 1.6 * NOMINAL["viscous"] * speed
    torque += NOMINAL["inertia"] * 200.0 / WINDOW
    current = np.round(torque / NOMINAL["motor_constant"], 3)
    row = table_of(Samples(time, speed[:, None], current[:, None]))
    assert row["valid"][0]
    for name, factor in {"coulomb": 1.0, "viscous": 1.6, "motor_constant": 1.0}.items():
        value, sigma = row[name][0], row[f"{name}_sigma"][0]
        assert value == pytest.approx(factor * NOMINAL[name], abs=3.0 * sigma)
        assert sigma < 0.2 * NOMINAL[name]


@pytest.mark.parametrize(("current", "reason"), [(0.0, "is the wheel driven"), (0.06, "sensor st")])
def test_a_current_of_one_value_is_told_from_none(current, reason):
    quiet = fly(4, slews=False, days=0.25)[0]
    table = table_of(replace(quiet, drive=0.0 * quiet.drive + current))
    assert not table["valid"].any()
    assert reason in table["why"][0]


@pytest.mark.parametrize("slews", [False, True])
def test_viscous_friction_stated_as_zero_without_a_sigma_is_not_known(slews):
    samples, truth = fly(4, slews=slews, days=0.25)
    wheel = replace(known().wheels[0], viscous=0.0, sigma={"motor_constant": 1.35e-4})
    monitor = WheelMonitor(replace(known(), wheels=(wheel,)), window=WINDOW)
    monitor.add(samples)
    table = monitor.windows()
    assert table["valid"].all()
    for name, value in {"coulomb": truth.mean, "viscous": truth.viscous}.items():
        assert np.all(np.abs(table[name] - value) < 3.0 * table[f"{name}_sigma"])
