"""Time scales against definitions and leap seconds."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.time_scales import Epoch, read_utc


def seconds(julian, other):
    return np.ravel((julian.day - other.day + (julian.fraction - other.fraction)) * 86400.0)[0]


@pytest.mark.parametrize(
    ("text", "leap_seconds"),
    [("1972-07-15T12:00:00Z", 11), ("1999-01-01T00:00:00Z", 32), ("2026-11-22T10:00:00Z", 37)],
)
def test_terrestrial_time_is_tai_and_32_seconds(text, leap_seconds):
    epoch = Epoch.of(text)
    assert seconds(epoch.tt(np.zeros(1)), epoch.utc) == pytest.approx(
        leap_seconds + 32.184, abs=1e-6
    )


def test_a_leap_second_has_a_second():
    epoch = Epoch.of("2016-12-31T23:59:59Z", ut1_utc=-0.4)
    after = Epoch.of("2017-01-01T00:00:00Z", ut1_utc=0.6)
    assert epoch.seconds_to(read_utc("2016-12-31T23:59:60", "")) == pytest.approx(1.0, abs=1e-9)
    assert epoch.seconds_to(after.utc) == pytest.approx(2.0, abs=1e-9)
    # UT1 has no leap second
    late = epoch.ut1_at(np.array([2.0]))
    assert seconds(late, after.ut1_at(np.zeros(1))) == pytest.approx(0.0, abs=1e-6)


def test_the_calendar_counts_from_the_epoch():
    epoch = Epoch.of("2024-02-28T23:59:59.25Z")
    expected = ["2024-02-28T23:59:59.250000", "2024-02-29T00:00:00.000000"]
    assert list(epoch.calendar(np.array([0.0, 0.75])).astype(str)) == expected


def test_a_day_of_the_year_is_a_date():
    assert read_utc("2024-366T01:02:03.5", "") == read_utc("2024-12-31T01:02:03.5", "")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("2026-11-22T10:00:00", "with a Z"),
        ("2026-11-22T10:00:00+01:00", "with a Z"),
        ("22 Nov 2026Z", "such as"),
        ("2026-13-01T00:00:00Z", "such as"),
        ("2026-02-29T00:00:00Z", "such as"),
        ("2026-366T00:00:00Z", "such as"),
        ("2026-000T00:00:00Z", "such as"),
        ("2026-11-22T24:00:00Z", "such as"),
        ("2026-11-22T10:61:00Z", "such as"),
        ("2026-11-22T10:00:60Z", "such as"),
        ("0000-001T00:00:00Z", "1972"),
        ("1960-01-01T00:00:00Z", "1972"),
        ("9999-01-01T00:00:00Z", "leap seconds"),
    ],
)
def test_refuses_an_epoch_that_is_none(text, words):
    with pytest.raises(InputError, match=words) as caught:
        Epoch.of(text)
    assert str(caught.value).startswith("epoch: found '")


@pytest.mark.parametrize("ut1_utc", [1.0, -37.0, float("nan")])
def test_refuses_a_difference_that_leap_seconds_exclude(ut1_utc):
    with pytest.raises(InputError, match="UT1 - UTC"):
        Epoch.of("2026-11-22T10:00:00Z", ut1_utc)
