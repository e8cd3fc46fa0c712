"""Current and speed of two loggers: a simulated wheel, whose lag and clock rate are known."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import Record, read_record, write_record
from gyrostat.telemetry.clocks import _gains, clock_difference
from gyrostat.telemetry.two_logs import combine

LAG, RATE = 12.345, 4e-4
STEP, SPAN, DRIVE, TACHO = 2.5e-3, 160.0, 0.05, 0.035
RECORDS = 20


@pytest.fixture(scope="module")
def wheels():
    """Times of the drive, currents (records, N), fine times and speeds (records, M)."""
    noise = np.random.default_rng(7)
    time = DRIVE * np.arange(int(SPAN / DRIVE))
    current = np.zeros((RECORDS, time.size))
    for row in current:
        start = 0
        while start < time.size:
            stop = start + int(noise.uniform(1.0, 4.0) / DRIVE)
            row[start:stop] = noise.uniform(0.1, 0.5) * noise.choice([-1.0, 1.0])
            start = stop
    per_sample = round(DRIVE / STEP)
    speed = np.zeros((RECORDS, time.size * per_sample + 1))
    for k in range(speed.shape[1] - 1):
        w = speed[:, k]
        friction = 1e-3 * (1.0 + 2.0 * np.exp(-((w / 5.0) ** 2))) * np.tanh(w / 0.05) + 5e-6 * w
        torque = 0.03 * current[:, k // per_sample] - friction
        speed[:, k + 1] = w + STEP * torque / 1.5e-3
    return time, current, STEP * np.arange(speed.shape[1]), speed


def logs(wheels, record, sigma=0.5, rate=0.0, current=None, averaged=False):
    """Current log, and speed log with t = s + LAG + rate (s - 60)."""
    time, currents, fine, speed = wheels
    noise = np.random.default_rng(record)
    at = np.arange(5.0, SPAN - 5.0, TACHO)
    clock = (at - LAG + rate * 60.0) / (1.0 + rate)
    if averaged:
        angle = np.cumsum(speed[record]) * STEP - 0.5 * STEP * speed[record]
        values = np.diff(np.interp(np.append(at[0] - TACHO, at), fine, angle)) / TACHO
    else:
        values = np.interp(at, fine, speed[record])
    values = values + noise.normal(0.0, sigma, at.size)
    drive = currents[record] if current is None else current
    none = np.zeros(time.size, bool)
    return (
        Record("drive.csv", time, drive, np.full(time.size, np.nan), none),
        Record("tacho.csv", clock, 0.0 * at, values, at > 0.0, averaged=averaged),
    )


def pulls(wheels, **options):
    rate = options.get("rate", 0.0)
    found = [clock_difference(*logs(wheels, k, **options)) for k in range(RECORDS)]
    assert max(each.lag_sigma for each in found) < 0.02
    return found, np.array(
        [(each.lag - LAG - rate * (each.centre - 60.0)) / each.lag_sigma for each in found]
    )


@pytest.fixture(scope="module")
def of_one_rate(wheels):
    return pulls(wheels)


@pytest.mark.parametrize("averaged", [False, True])
def test_lag_is_found_with_its_sigma(wheels, of_one_rate, averaged):
    _, deviations = pulls(wheels, averaged=True) if averaged else of_one_rate
    # 20 standard normal deviations: rms of 1 +- 0.16, mean of 0 +- 0.22
    assert 0.6 < np.sqrt(np.mean(deviations**2)) < 1.5
    assert abs(np.mean(deviations)) < 0.7


def test_rate_is_found_where_it_shows(wheels, of_one_rate):
    found, deviations = pulls(wheels, rate=RATE, sigma=0.1)
    rates = [each for each in found if each.rate]
    assert len(rates) > RECORDS // 2
    assert all(abs(each.rate - RATE) < 4.5 * each.rate_sigma for each in rates)
    assert np.sqrt(np.mean(deviations**2)) < 1.5
    assert sum(bool(each.rate) for each in of_one_rate[0]) <= 1


@pytest.mark.parametrize("kind", ["constant", "periodic", "noise", "other wheel"])
def test_records_without_one_lag_are_refused(wheels, kind):
    time = wheels[0]
    if kind == "constant":
        current = np.full(time.size, 0.2)
    elif kind == "periodic":
        current = np.where(time % 8.0 < 4.0, 0.25, -0.25)
    else:
        current = wheels[1][1] if kind == "other wheel" else None
    sigma = 500.0 if kind == "noise" else 0.5
    with pytest.raises(InputError, match="expected currents that change at irregular times"):
        clock_difference(*logs(wheels, 0, sigma, current=current))


def test_record_has_the_speeds_and_the_mean_currents_between_them(wheels):
    drive, tacho = logs(wheels, 3, sigma=0.1)
    record = combine(drive, tacho)
    np.testing.assert_array_equal(record.speed, tacho.speed)
    lag = record.time[0] - tacho.time[0]
    assert abs(lag - LAG) < 0.01
    assert record.notes[-1].startswith("speed: +12.3")
    # by brute force: the mean over many times within an interval
    for k in (0, 500, 2000):
        times = np.linspace(record.time[k], record.time[k + 1], 20001)[:-1]
        held = drive.current[np.searchsorted(drive.time, times, "right") - 1]
        assert record.current[k] == pytest.approx(held.mean(), abs=2e-5)


def test_command_line_reads_two_files(wheels, tmp_path, run):
    drive, tacho = logs(wheels, 4, sigma=0.1)
    rows = "\n".join(
        f"{t!r},{i!r}" for t, i in zip(drive.time.tolist(), drive.current.tolist(), strict=True)
    )
    (tmp_path / "drive.csv").write_text(f"time_s,iq_A\n{rows}\n")
    write_record(tacho, tmp_path / "tacho.csv")
    (tmp_path / "tacho.toml").write_text('[columns]\nspeed = "speed"\n[units]\nspeed = "rad/s"\n')
    reading = {
        "columns": {"current": "iq"},
        "speed_from": tmp_path / "tacho.csv",
        "speed_columns": tmp_path / "tacho.toml",
    }
    record = read_record(tmp_path / "drive.csv", **reading)
    np.testing.assert_array_equal(record.speed, tacho.speed)
    code, out, error = run(
        *("identify", tmp_path / "drive.csv", "--columns", "current=iq"),
        *("--speed-from", tmp_path / "tacho.csv", "--speed-columns", "speed=none"),
        *("--inertia", "1.5e-3", "--out", tmp_path / "out"),
    )
    assert (code, out, error.count("\n")) == (2, "", 1)
    assert "tacho.csv: row 1: found columns" in error
    with pytest.raises(InputError, match="found edges and speed_from, expected one of the two"):
        read_record(tmp_path / "drive.csv", edges=tmp_path / "tacho.csv", **reading)
    with pytest.raises(InputError, match="found an unsigned current, expected a setpoint"):
        read_record(tmp_path / "drive.csv", unsigned_current=True, **reading)


def test_gap_of_the_current_is_refused(wheels):
    drive, tacho = logs(wheels, 5)
    part = (drive.time < 40.0) | (drive.time > 60.0)
    series = (each[part] for each in (drive.time, drive.current, drive.speed, drive.valid))
    with pytest.raises(InputError, match=r"drive\.csv: found a gap of 20.1 s after 39\.95 s"):
        combine(Record("drive.csv", *series), tacho)


def test_an_offset_of_the_current_is_friction_and_shows_no_lag():
    random = np.random.default_rng(0)
    current = np.convolve(random.normal(size=404), np.ones(5) / 5.0, "valid")
    acceleration = 2.0 * current[41:341] + 0.01 * random.normal(size=300)
    speed = 0.1 * np.cumsum(current[41:341])
    shifts = np.arange(-100, 200)
    scores = _gains(current, acceleration, speed, shifts)
    assert shifts[np.argmax(scores)] == 41
    # its noise of rounding is 1e-11 of an offset of 1e5
    offset = _gains(current + 1e5, acceleration, speed, shifts)
    np.testing.assert_allclose(offset, scores, rtol=1e-4, atol=1e-6)
