"""Records of a bench against the profiles of its plan: swapped, shifted, cut, scaled, reversed."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.identification.bench_tests.bench_test import PlannedRecord
from gyrostat.identification.bench_tests.profile_match import match, require_profile
from gyrostat.telemetry import Record

TIME = np.arange(2400) / 10.0


def planned(name, current):
    return PlannedRecord(name, TIME, current)


COAST = planned("coast", np.where((TIME > 1.0) & (TIME < 80.0), 0.2, 0.0))
STAIRS = planned(
    "stairs", np.where(TIME < 200.0, (0.1 + 0.02 * (TIME // 40.0)) * (-1.0) ** (TIME // 20.0), 0.0)
)
SAWTEETH = 0.03 + 0.04 * (TIME % 20.0) / 20.0
RAMP = planned("ramp", np.where(TIME % 40.0 < 20.0, SAWTEETH, 0.0))
STAIRCASE = planned("staircase", np.where(TIME % 40.0 < 20.0, 2e-3 * (SAWTEETH // 2e-3), 0.0))
EVERY = (COAST, STAIRS, RAMP, STAIRCASE)


def record_of(profile, current=None, time=None):
    current = profile.current if current is None else current
    time = profile.time if time is None else time
    return Record("record", time, current, np.zeros(len(time)), np.ones(len(time), dtype=bool))


def require(record, profile):
    others = [each for each in EVERY if each is not profile]
    require_profile(record, "file.csv", "test", profile, others)


@pytest.mark.parametrize("profile", EVERY, ids=lambda each: each.name)
def test_real_records_of_a_profile_are_accepted(profile):
    random = np.random.default_rng(1)
    require(record_of(profile), profile)
    # another start of the clock, between samples; noise, rounding, a drive that sets 3 % more
    time = 1.7e9 + 0.037 + TIME
    noisy = 1.03 * profile.current + 5e-4 * random.standard_normal(len(TIME))
    require(record_of(profile, 1e-4 * np.round(noisy / 1e-4), time), profile)
    # the record starts before the profile, at another rate, and the tail is cut
    times = np.arange(-7.03, 185.0, 0.05)
    index = np.clip(np.floor(10.0 * times + 1e-6).astype(int), 0, None)
    later = np.where(times < 0.0, 0.0, profile.current[index])
    found = match(record_of(profile, later, times), profile)
    assert found.unexplained < 0.02
    require(record_of(profile, later, times), profile)


def test_lag_scale_and_share_are_those_of_the_record():
    random = np.random.default_rng(2)
    noise = 0.01 * random.standard_normal(len(TIME))
    found = match(record_of(STAIRS, 0.9 * STAIRS.current + noise, TIME + 12.3), STAIRS)
    # within the sample interval
    assert found.lag == pytest.approx(12.3, abs=0.1)
    assert found.scale == pytest.approx(0.9, rel=5e-3)
    power = 0.81 * np.mean(STAIRS.current**2)
    assert found.unexplained == pytest.approx(1e-4 / (power + 1e-4), rel=0.1)
    assert found.covered == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("own", EVERY, ids=lambda each: each.name)
@pytest.mark.parametrize("run", EVERY, ids=lambda each: each.name)
def test_a_swapped_record_is_named(own, run):
    if own is run:
        return
    current = run.current + 2e-4 * np.random.default_rng(3).standard_normal(len(TIME))
    with pytest.raises(InputError) as error:
        require(record_of(run, current), own)
    expected = f"found the current of {run.name}, expected that of profiles/{own.name}.csv"
    assert str(error.value) == f"file.csv: test test: {expected}"


@pytest.mark.parametrize(
    ("current", "message"),
    [
        (-STAIRS.current, "1 times the current of the profile with the opposite sign"),
        (1e-3 * STAIRS.current, "0.001 times the current of the profile,"),
        (np.zeros(len(TIME)), "found no current"),
        (STAIRS.current[::-1], "% (mean square) are not the profile at any time offset"),
        (np.where(TIME < 60.0, STAIRS.current, 0.0), "% (mean square) are not the profile"),
    ],
    ids=["reversed", "scaled", "still", "backwards", "switched off"],
)
def test_another_current_is_refused_with_its_difference(current, message):
    with pytest.raises(InputError) as error:
        require(record_of(STAIRS, current), STAIRS)
    assert message in str(error.value)
    assert str(error.value).endswith("expected that of profiles/stairs.csv")
    assert "\n" not in str(error.value)


def test_a_record_that_ends_early_is_refused():
    short = slice(0, 700)
    record = record_of(STAIRS, STAIRS.current[short], TIME[short])
    with pytest.raises(InputError, match="of the current of the profile"):
        require(record, STAIRS)


def test_profiles_that_are_the_same_are_no_rivals():
    twin = replace(STAIRS, name="twin")
    require_profile(record_of(STAIRS), "file.csv", "test", STAIRS, [twin, COAST])
