"""Clock of telemetry: resets, repeats and wild times, against times stated sample by sample."""

import numpy as np
import pytest

from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.clock import AFTER_RESET, CONFIRMING, Clock
from tests.monitoring.test_stream import WHEELS

STEADY = np.arange(5000.0, 5040.0)


def samples_at(times):
    times = np.asarray(times, float)
    return Samples(times, np.arange(times.size)[:, None] * 1.0, np.zeros((times.size, 1)))


def through(clock, times, cuts=()):
    """Corrected times and the places of their samples, with the times fed in pieces."""
    whole = samples_at(times)
    pieces = np.split(np.arange(len(whole)), cuts)
    parts = [clock.corrected(whole.part(slice(p[0], p[-1] + 1))) for p in pieces if p.size]
    joined = Samples.joined(parts)
    return joined.time, joined.speed[:, 0].astype(int)


def test_a_reset_goes_on_and_an_older_file_does_not():
    times = np.r_[7000.0:7020.0, 10.0:30.0]
    clock = Clock()
    corrected, _ = through(clock, times)
    np.testing.assert_allclose(corrected[20:], 7019.0 + AFTER_RESET + np.arange(20.0))
    assert (clock.resets, clock.wild) == (1, 0)
    fresh = Clock()
    fresh.corrected(samples_at(times[:20]))
    fresh.begin_file()
    assert len(fresh.corrected(samples_at(times[20:]))) == 0
    assert (fresh.resets, fresh.repeats) == (0, 20)


@pytest.mark.parametrize("wild", [0.0, 1.0, 9e9, -4e9, 5020.0 + 3601.0])
@pytest.mark.parametrize("count", [1, CONFIRMING - 1])
@pytest.mark.parametrize("at", [0, CONFIRMING, 20])
def test_a_few_wild_times_are_left_out_and_the_rest_is_as_without_them(wild, count, at):
    times = np.insert(STEADY, at, np.full(count, wild) + 1e-3 * np.arange(count))
    clock = Clock()
    corrected, places = through(clock, times)
    np.testing.assert_array_equal(corrected, STEADY)
    assert not np.isin(places, np.arange(at, at + count)).any()
    assert (clock.wild, clock.resets, clock.repeats) == (count, 0, 0)


def test_different_wild_times_in_a_row_and_at_the_end_of_a_file():
    clock = Clock()
    corrected, _ = through(clock, np.r_[STEADY[:20], 9e9, -1e9, 3e9, STEADY[20:], 1e9])
    np.testing.assert_array_equal(corrected, STEADY)
    assert len(clock.held) == 1
    clock.begin_file()
    corrected, _ = through(clock, STEADY + 40.0)
    np.testing.assert_array_equal(corrected, STEADY + 40.0)
    assert (clock.wild, clock.resets) == (4, 0)


def test_few_samples_between_long_gaps_are_used():
    times = np.r_[STEADY, 10000.0, 20000.0, 20001.0, 30000.0 + STEADY]
    clock = Clock()
    corrected, _ = through(clock, times)
    np.testing.assert_array_equal(corrected, times)
    assert clock.wild == 0


def test_any_division_of_a_bad_clock_gives_the_same_times():
    times = np.r_[
        STEADY, 9e9, STEADY + 40.0, 3.0:60.0, -5.0, 1e9, 60.0:90.0, 80.0:99.0, 90000:90015
    ]
    whole = through(Clock(), times)
    assert whole[0].size > 150
    for cuts in ([1], [40, 41, 42], np.arange(1, times.size), np.arange(3, times.size, 7)):
        clock = Clock()
        for one, other in zip(whole, through(clock, times, cuts), strict=True):
            np.testing.assert_array_equal(one, other)
        assert (clock.wild, clock.resets, clock.repeats) == (2, 1, 11)


def test_a_file_in_decreasing_time_is_refused(run, tmp_path):
    rows = [f"{t},{1000 + t},20" for t in range(2000, 0, -1)]
    telemetry, wheels = tmp_path / "newest first.csv", tmp_path / "wheels.toml"
    telemetry.write_text("\n".join(["time_s,a_speed_rpm,a_current_mA", *rows]))
    wheels.write_text(WHEELS)
    code, out, err = run("monitor", telemetry, "--wheels", wheels, "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    expected = "found times that decrease, expected increasing times: sort its rows"
    assert f"{telemetry}: {expected}" in err
    assert not (tmp_path / "out").exists()


def test_a_few_samples_before_a_wild_time_at_the_start_of_a_file_are_lost():
    """Which of the two few is wild, nothing tells."""
    clock = Clock()
    corrected, _ = through(clock, np.insert(STEADY, 7, 9e9))
    np.testing.assert_array_equal(corrected, STEADY[7:])
    assert clock.wild == 8
