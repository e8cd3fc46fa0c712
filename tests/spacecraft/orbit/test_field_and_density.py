"""Magnetic field and air density against the libraries called directly, point by point."""

import datetime

import numpy as np
import ppigrf
import pymsis
import pytest

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.atmosphere import Activity, air_density
from gyrostat.spacecraft.orbit.field import magnetic_field
from gyrostat.spacecraft.orbit.frames import geodetic
from gyrostat.spacecraft.orbit.time_scales import Epoch

ACTIVITY = Activity(f107=140.0, f107a=120.0, ap=7.0)
PLACE = (np.array([0.6]), np.array([-1.1]), np.array([4.5e5]))
"""Latitude, longitude, rad, and height, m."""


def positions(count, seed):
    rng = np.random.default_rng(seed)
    ahead = rng.normal(size=(count, 3))
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    return ahead * rng.uniform(6.7e6, 4.2e7, count)[:, None]


def geodetic_field(date, latitude, longitude, height):
    """Field, ITRF axes, T, of the library's function of geodetic coordinates, for one point."""
    degrees = np.degrees([longitude, latitude])
    east, north, up = (
        float(np.ravel(part)[0]) for part in ppigrf.igrf(*degrees, height / 1e3, date)
    )
    sine, cosine = np.sin(latitude), np.cos(latitude)
    level = up * cosine - north * sine
    ahead = np.array([np.cos(longitude), np.sin(longitude)])
    left = np.array([-np.sin(longitude), np.cos(longitude)])
    return 1e-9 * np.array([*(level * ahead + east * left), up * sine + north * cosine])


# within a year, and over the change of coefficients at 2025
@pytest.mark.parametrize(
    ("text", "span"), [("2026-11-22T10:00:00Z", 86400.0), ("2024-06-01T00:00:00Z", 3.1e7)]
)
def test_the_field_is_that_of_the_library_at_single_points_and_dates(text, span):
    epoch, rows = Epoch.of(text), 12
    times, position = np.linspace(0.0, span, rows), positions(rows, 3)
    field = magnetic_field(epoch, times, position)
    start = datetime.datetime.fromisoformat(text[:-1])
    places = np.transpose(geodetic(position))
    for row in range(rows):
        date = start + datetime.timedelta(seconds=float(times[row]))
        expected = geodetic_field(date, *places[row])
        # the library turns to geodetic axes by a series, good to about 1e-9 rad
        assert np.linalg.norm(field[row] - expected) < 1e-7 * np.linalg.norm(expected)


def test_the_field_is_finite_and_continuous_at_the_poles():
    epoch, times = Epoch.of("2026-11-22T10:00:00Z"), np.arange(4.0)
    position = np.array([[0.0, 0.0, 7e6], [7.0, 0.0, 7e6], [0.0, 0.0, -7e6], [0.0, -7.0, -7e6]])
    field = magnetic_field(epoch, times, position)
    np.testing.assert_allclose(field[[0, 2]], field[[1, 3]], atol=1e-10)
    assert 3e-5 < np.linalg.norm(field[0]) < 7e-5
    # it points into the Earth in the north and out of it in the south
    assert np.all(field[:, 2] < -3e-5)


def test_refuses_dates_beyond_the_coefficients():
    epoch = Epoch.of("2028-12-30T00:00:00Z")
    with pytest.raises(InputError, match="expected the years 1900 to 2030 of the magnetic field"):
        magnetic_field(epoch, np.array([0.0, 400 * 86400.0]), positions(2, 1))


def direct(date):
    latitude, longitude, height = PLACE
    date = np.array([date], dtype="datetime64[s]")
    latitude, longitude = np.degrees(latitude), np.degrees(longitude)
    aps = [[7.0] * 7]
    values = pymsis.calculate(date, longitude, latitude, height / 1e3, [140.0], [120.0], aps)
    return float(np.ravel(values)[0])


def density(text, seconds=0.0):
    return float(air_density(Epoch.of(f"{text}Z"), np.array([seconds]), *PLACE, ACTIVITY)[0])


@pytest.mark.parametrize("date", ["2024-02-29", "2026-11-22"])
def test_the_density_is_that_of_the_library_at_noon(date):
    assert density(f"{date}T12:00:00") == pytest.approx(direct(f"{date}T12:00:00"), rel=1e-12)
    assert density(f"{date}T00:00:00", 43200.0) == density(f"{date}T12:00:00")


def test_the_density_lies_between_two_days_of_the_library():
    # six hours after noon: a quarter of the way to the next day's value for the same time of day
    times = [f"{day}T18:00:00" for day in ("2026-12-31", "2027-01-01")]
    first, second = map(direct, times)
    assert density(times[0]) == pytest.approx(first**0.75 * second**0.25, rel=1e-12)
    before = direct("2026-12-30T06:00:00"), direct("2026-12-31T06:00:00")
    assert density("2026-12-31T06:00:00") == pytest.approx(
        before[0] ** 0.25 * before[1] ** 0.75, rel=1e-12
    )


def test_the_density_passes_seconds_and_midnight_without_a_jump():
    seconds = np.array([-0.5, -1e-3, 0.0, 1e-3, 0.5, 0.75, 1.0])
    places = [np.repeat(part, len(seconds)) for part in PLACE]
    values = air_density(Epoch.of("2026-11-30T23:59:50Z"), 10.0 + seconds, *places, ACTIVITY)
    # the library's own value jumps by half a percent at midnight and by 4e-5 from second to second
    assert abs(direct("2026-12-01T00:00:00") / direct("2026-11-30T23:59:59") - 1.0) > 3e-3
    assert np.max(np.abs(np.diff(np.log(values)))) < 6e-5
    assert np.abs(np.log(values[3] / values[1])) < 1e-6


def test_refuses_an_orbit_in_the_air():
    latitude, longitude, _ = PLACE
    with pytest.raises(InputError, match=r"a height of 99 km at 0 s, expected 100 km or more"):
        air_density(
            Epoch.of("2026-11-22T10:00:00Z"),
            np.zeros(1),
            latitude,
            longitude,
            np.array([99e3]),
            ACTIVITY,
        )


@pytest.mark.parametrize(
    ("activity", "words"),
    [
        ((0.0, 120.0, 7.0), "f107: found 0 sfu|solar flux f107: "),
        ((140.0, float("nan"), 7.0), "solar flux f107a"),
        ((140.0, 120.0, -1.0), "geomagnetic index ap"),
    ],
)
def test_refuses_an_activity_of_no_sun(activity, words):
    with pytest.raises(InputError, match=words):
        Activity(*activity).check()
