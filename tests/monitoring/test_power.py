"""Electrical power as the drive: inversion, what is left out, honest intervals, files."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import gyrostat
from gyrostat.core.errors import InputError
from gyrostat.monitoring import window
from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.power import current_of_power, shows_torque
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels
from tests.monitoring.closed_loop import NOMINAL
from tests.monitoring.test_stream import WHEELS

IDLE, RESISTANCE, DAY = 1.2, 1.1, 43200
WHEEL = KnownWheel("a", **NOMINAL, stribeck_speed=0.5, idle_power=IDLE, resistance=RESISTANCE)
KEYS = f'stribeck_speed = 0.5\nidle_power = "{1e3 * IDLE} mW"\nresistance = "{RESISTANCE} Ω"\n'


def power_of(current, speed, resistance=RESISTANCE):
    return IDLE + NOMINAL["motor_constant"] * speed * current + resistance * current**2


@pytest.mark.parametrize("resistance", [0.0, 1.1])
def test_the_current_is_that_of_the_power_with_the_sign_of_its_torque(resistance):
    current = np.array([[1e-6, 0.06, 1.9], [-1e-6, -0.06, -1.9]])
    speed = np.array([[3.0, 150.0, 600.0], [-3.0, -150.0, -600.0]])
    known = KnownWheels((replace(WHEEL, resistance=resistance),) * 3)
    found = current_of_power(power_of(current, speed, resistance), speed, known)
    np.testing.assert_allclose(found, current, rtol=1e-9)


def test_a_power_that_shows_no_torque_gives_no_current():
    power = IDLE + np.array([[-0.1], [0.0], [0.1], [np.nan], [0.1]])
    speed = np.array([[150.0], [150.0], [2.0], [150.0], [0.0]])
    assert np.isnan(current_of_power(power, speed, KnownWheels((WHEEL,)))).all()


def flight(slew_time, change, every):
    """Half a day of eight wheels that brake in each slew: times, speeds, currents, mean Coulomb.

    The drive takes power from its supply also to brake.
    """
    random = np.random.default_rng(5)
    time, names = np.arange(DAY + 2.0), np.arange(8)
    phase = (time[:, None] + 450.0 * names) % every
    turn = 0.5 * change * (1.0 - np.cos(2.0 * np.pi * phase / slew_time))
    slew = np.where(phase < slew_time, turn, 0.0)
    speed = 150.0 + 20.0 * np.sin(2.0 * np.pi * time[:, None] / 5700.0 + names) + slew
    keep = np.exp(-1.0 / 1200.0)
    shocks = 0.02 * np.sqrt(1.0 - keep**2) * random.standard_normal(speed.shape)
    coulomb = NOMINAL["coulomb"] * (1.1 + lfilter([1.0], [1.0, -keep], shocks, axis=0))
    torque = coulomb + NOMINAL["viscous"] * speed
    torque += NOMINAL["inertia"] * np.gradient(speed, axis=0)
    current = torque / NOMINAL["motor_constant"]
    current += 5e-4 * random.standard_normal(current.shape)
    return time, speed, current, coulomb.mean(axis=0)


@pytest.fixture(scope="module")
def flown():
    return flight(300.0, 150.0, 3600.0)


def scores(flown, stated, sigma):
    """Errors of the mean Coulomb torque in their sigma, and over its value."""
    time, speed, current, coulomb = flown
    power = IDLE + np.abs(power_of(current, speed) - IDLE)
    wheels = tuple(
        replace(
            WHEEL,
            name=f"w{k}",
            idle_power=idle,
            sigma={"idle_power": sigma, "power_gain": 1e-3, "viscous": 1e-7, "offset": 1e-9},
        )
        for k, idle in enumerate(stated)
    )
    known = KnownWheels(wheels)
    monitor = WheelMonitor(known, window=DAY, drive="power")
    monitor.add(Samples(time, speed, current_of_power(power, speed, known)))
    table = monitor.windows()
    assert table["valid"].all()
    error = table["coulomb"] - coulomb
    return error / table["coulomb_sigma"], error / coulomb


def test_intervals_contain_the_error_of_the_idle_power(flown):
    idle = IDLE * (1.0 + 0.02 * np.random.default_rng(6).standard_normal(8))
    scored, error = scores(flown, idle, 0.02 * IDLE)
    assert np.max(np.abs(scored)) < 2.8
    assert np.sqrt(np.mean(scored**2)) > 0.3
    # without its sigma the same error is far outside
    assert np.max(np.abs(scores(flown, idle, 1e-6)[0])) > 5.0
    assert np.sqrt(np.mean(error**2)) > 0.01


def test_braking_does_not_bias(flown, monkeypatch):
    exact = np.full(8, IDLE)
    scored, error = scores(flown, exact, 1e-3)
    assert np.max(np.abs(scored)) < 2.8
    assert abs(np.mean(error)) < 0.01  # three standard errors of eight wheels
    monkeypatch.setattr(window, "shows_torque", lambda blocks, known, wheel: len(blocks) * [True])
    # which way it biases then, differs between wheels
    assert np.sqrt(np.mean(scores(flown, exact, 1e-3)[1] ** 2)) > 0.05


@pytest.mark.parametrize(("slew_time", "change"), [(40.0, 20.0), (100.0, 50.0)])
def test_braking_within_a_block_does_not_bias(monkeypatch, slew_time, change):
    braking = flight(slew_time, change, 490.0)
    low = np.full(8, 0.98 * IDLE)
    assert np.max(np.abs(scores(braking, low, 0.02 * IDLE)[0])) < 2.8

    def by_blocks_alone(blocks, known, wheel):
        still = np.full_like(blocks.deceleration, -1.0)
        return shows_torque(replace(blocks, deceleration=still), known, wheel)

    monkeypatch.setattr(window, "shows_torque", by_blocks_alone)
    assert np.max(np.abs(scores(braking, low, 0.02 * IDLE)[0])) > 4.0


def windows_of(flown, speed_noise=0.0, **changes):
    """Windows of the eight wheels where the drive burns the energy of braking."""
    time, speed, current, _ = flown
    sigma = {"idle_power": 1e-3, "power_gain": 1e-2, "viscous": 1e-7, "offset": 1e-9}
    wheel = replace(WHEEL, sigma=sigma, **changes)
    known = KnownWheels(tuple(replace(wheel, name=f"w{k}") for k in range(8)))
    power = IDLE + np.maximum(power_of(current, speed) - IDLE, 0.0)
    measured = speed + speed_noise * np.random.default_rng(8).standard_normal(speed.shape)
    monitor = WheelMonitor(known, window=DAY, drive="power")
    monitor.add(Samples(time, measured, current_of_power(power, measured, known)))
    return monitor.windows()


def test_noise_of_the_tachometer_is_no_braking():
    quiet = flight(300.0, 0.0, 3600.0)
    # 1 rad/s: over five seconds up to 0.6 times the torque of friction
    for noise, error in ((0.0, 0.03), (1.0, 0.1)):
        table = windows_of(quiet, noise)
        assert table["valid"].all()
        np.testing.assert_allclose(table["coulomb"], quiet[3], rtol=error)


def test_a_stated_friction_that_hides_braking_is_said():
    braking = flight(40.0, 20.0, 490.0)
    table = windows_of(braking, coulomb=10.0 * NOMINAL["coulomb"])
    assert not table["valid"].any()
    assert all("state them anew" in why for why in table["why"])
    assert windows_of(braking)["valid"].all()


def test_a_wheel_that_seizes_is_valid():
    time, speed, current, coulomb = flight(300.0, 0.0, 3600.0)
    more = 20.0 * NOMINAL["coulomb"]
    table = windows_of((time, speed, current + more / NOMINAL["motor_constant"], None))
    assert table["valid"].all()
    np.testing.assert_allclose(table["coulomb"], coulomb + more, rtol=0.03)


@pytest.mark.parametrize("stated", [True, False])
def test_intervals_contain_the_rounding_of_the_power_only_if_it_is_stated(flown, stated):
    time, _, _, _ = flown
    speed = 150.0 + 1e-4 * np.sin(time)[:, None] + np.linspace(0.0, 3.0, 8)
    torque = NOMINAL["coulomb"] + NOMINAL["viscous"] * speed
    power = power_of(torque / NOMINAL["motor_constant"], speed)
    power = 0.03 * np.round(power / 0.03)
    sigma = {"idle_power": 1e-6, "resistance": 1e-6, "power_gain": 1e-4}
    sigma |= {"viscous": 1e-9, "offset": 1e-9}
    wheels = tuple(replace(WHEEL, name=f"w{k}", sigma=sigma) for k in range(8))
    known = KnownWheels(wheels, power_resolution=0.03 if stated else 0.0)
    monitor = WheelMonitor(known, window=DAY, drive="power")
    monitor.add(Samples(time, speed, current_of_power(power, speed, known)))
    table = monitor.windows()
    score = np.max(np.abs(table["coulomb"] - NOMINAL["coulomb"]) / table["coulomb_sigma"])
    assert (score < 2.8) == stated


@pytest.fixture
def folder(tmp_path, flown):
    time, speed, current, _ = flown
    time, speed, current = time[:14460], speed[:14460, 0], current[:14460, 0]
    columns = {
        "time_s": time,
        "a_speed_rad_s": speed,
        "a_power_mW": 1e3 * power_of(current, speed),
        "a_torque_N·m": NOMINAL["motor_constant"] * current,
        "a_current_A": current,
    }
    for name, count in (("power", 3), ("torque", 4), ("current", 5)):
        rows = np.column_stack([*columns.values()][:count])
        header = ",".join([*columns][:count])
        np.savetxt(tmp_path / f"{name}.csv", rows, "%.12g", ",", header=header, comments="")
    (tmp_path / "bare.toml").write_text(WHEELS)
    (tmp_path / "wheels.toml").write_text(WHEELS.replace("stribeck_speed = 0.5\n", KEYS))
    return tmp_path


@pytest.mark.parametrize(
    ("wheels", "telemetry", "drive"),
    [
        ("wheels", "power", "power"),
        ("wheels", "torque", "power"),
        ("bare", "torque", "torque"),
        ("wheels", "current", "current"),
    ],
)
def test_the_drive_is_the_best_measured(folder, wheels, telemetry, drive):
    health = gyrostat.monitor(
        folder / f"{telemetry}.csv", wheels=folder / f"{wheels}.toml", window="2 h"
    )
    assert health.telemetry["drive"] == drive
    assert health.windows["valid"][0]
    assert sum("electrical power shows" in note for note in health.notes) == (drive == "power")


@pytest.mark.parametrize(("factor", "reason"), [(1e3, "is its unit right?"), (1e-3, "0 blocks")])
def test_a_power_in_another_unit_is_not_valid(folder, factor, reason):
    table = np.loadtxt(folder / "power.csv", delimiter=",", skiprows=1) * [1.0, 1.0, factor]
    header = "time_s,a_speed_rad_s,a_power_mW"
    np.savetxt(folder / "other.csv", table, "%.12g", ",", header=header, comments="")
    health = gyrostat.monitor(folder / "other.csv", wheels=folder / "wheels.toml", window="2 h")
    assert not health.windows["valid"][0]
    assert reason in health.windows["why"][0]


@pytest.mark.parametrize("key", [1, 2])
def test_a_power_that_cannot_be_read_is_no_drive_unless_it_is_named(folder, key):
    wheels = folder / "wheels.toml"
    wheels.write_text(wheels.read_text().replace(KEYS.splitlines()[key], ""))
    # also without a unit, as a flag "power" may be
    text = (folder / "power.csv").read_text()
    (folder / "flag.csv").write_text(text.replace("a_power_mW", "a_power", 1))
    for name in ("power", "flag"):
        health = gyrostat.monitor(folder / f"{name}.csv", wheels=wheels, window="2 h")
        assert health.telemetry["drive"] == "none"
        assert any("states idle_power and resistance" in note for note in health.notes)
    with pytest.raises(InputError, match=r"power.csv: (idle_power|resistance) of a: found none"):
        gyrostat.monitor(folder / "power.csv", wheels=wheels, columns={"a_power": "a_power_mW"})


def test_a_later_call_goes_on_with_the_power(folder):
    options = {"wheels": folder / "wheels.toml", "window": "2 h"}
    first = gyrostat.monitor(folder / "power.csv", folder / "out", **options)
    again = gyrostat.monitor(folder / "power.csv", folder / "out", **options)
    for name in ("coulomb", "coulomb_sigma"):
        np.testing.assert_array_equal(first.windows[name], again.windows[name])
    # the power does not show the motor constant
    model = gyrostat.read_model(folder / "out" / "wheels" / "a" / "model.toml")
    assert model.values["motor_constant"] == NOMINAL["motor_constant"]
    assert json.loads((folder / "out" / "health.json").read_text())["telemetry"]["drive"] == "power"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (f'"{RESISTANCE} Ω"', '"-1 Ohm"', "resistance: found -1.0, expected a number above 0"),
        (f'"{1e3 * IDLE} mW"', '"1.2 N·m"', "expected a unit of power: W, mW"),
        ('"0.4 rpm"', '"0.4 rpm"\npower_resolution = -0.1', "power_resolution: found -0.1 W"),
        ("offset = 1e-9", "power_gain = 0.0", "sigma.power_gain: found 0.0"),
    ],
)
def test_impossible_values_are_refused_in_one_line(folder, old, new, message):
    text = (folder / "wheels.toml").read_text()
    assert old in text
    (folder / "wheels.toml").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message) as caught:
        gyrostat.monitor(folder / "power.csv", wheels=folder / "wheels.toml")
    assert "\n" not in str(caught.value)
