"""Frames, geodetic coordinates and the Sun against independent compositions and formulas."""

import erfa
import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.rotations import to_inertial
from gyrostat.spacecraft.orbit.frames import (
    States,
    earth_attitude,
    gcrs_to_itrf,
    geodetic,
    rotated,
    teme_to_gcrs,
    to_gcrs,
    transposed,
)
from gyrostat.spacecraft.orbit.sun import ASTRONOMICAL_UNIT, moon_position, sun_position
from gyrostat.spacecraft.orbit.time_scales import Epoch

EPOCH = Epoch.of("2026-11-22T10:00:00Z", 0.05)
ARCSECOND = np.radians(1.0 / 3600.0)


def angles(first, second):
    """Angles of the rotations between matrices, rad, accurate where small."""
    turn = transposed(first) @ second
    off = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], axis=1)
    off -= np.stack([turn[:, 1, 2], turn[:, 2, 0], turn[:, 0, 1]], axis=1)
    return 0.5 * np.linalg.norm(off, axis=1)


def test_the_earth_turns_by_its_rotation_angle_about_the_intermediate_pole():
    times = np.linspace(0.0, 5 * 86400.0, 23)
    celestial = erfa.c2i06a(*EPOCH.tt(times))
    turned = erfa.rz(erfa.era00(*EPOCH.ut1_at(times)), celestial)
    # they differ by the locator of the terrestrial origin, 47 microarcseconds a century
    assert np.max(angles(turned, gcrs_to_itrf(EPOCH, times))) < 20e-6 * ARCSECOND


def test_the_attitude_of_the_earth_turns_vectors_as_the_matrices_do():
    times = np.linspace(0.0, 3 * 86400.0, 2000)
    matrices = gcrs_to_itrf(EPOCH, times)
    quaternions = earth_attitude(matrices)
    vectors = np.random.default_rng(1).normal(size=(len(times), 3))
    turned = jax.vmap(to_inertial)(quaternions, vectors)
    np.testing.assert_allclose(turned, rotated(transposed(matrices), vectors), atol=1e-13)
    # a turn of three days passes both signs, without a jump
    assert quaternions[0, 0] >= 0.0
    assert np.min(quaternions[:, 0]) < -0.99
    assert np.max(np.linalg.norm(np.diff(quaternions, axis=0), axis=1)) < 0.06


@pytest.mark.parametrize("text", ["2000-06-27T18:50:19Z", "2015-06-30T23:59:00Z", EPOCH])
def test_teme_agrees_with_the_models_of_1976_and_1980(text):
    # True equator and equinox of date, turned back by the equation of the equinoxes: no Earth
    # rotation angle. Without observed corrections, these models of precession and nutation are off
    # by up to 0.05 arcseconds; a wrong sign of the equation of the equinoxes is above 3.
    epoch = text if isinstance(text, Epoch) else Epoch.of(text)
    times = np.linspace(0.0, 30 * 86400.0, 31)
    tt = epoch.tt(times)
    of_date = erfa.nutm80(*tt) @ erfa.pmat76(*tt)
    teme = transposed(of_date) @ erfa.rz(-erfa.eqeq94(*tt), np.eye(3))
    off = angles(teme, teme_to_gcrs(epoch, times))
    assert np.max(off) < 0.06 * ARCSECOND
    assert np.max(angles(transposed(of_date), teme)) > 1.0 * ARCSECOND


@pytest.mark.parametrize("frame", ["TEME", "ITRF"])
def test_inertial_velocities_are_derivatives_of_positions(frame):
    times = np.array([-1.0, 0.0, 1.0]) * 0.5 + 1000.0
    velocity = np.array([100.0, -7000.0, 500.0])
    position = np.array([6.9e6, 1e5, -2e5]) + np.outer(times - 1000.0, velocity)
    states = to_gcrs(States(position, np.tile(velocity, (3, 1))), frame, EPOCH, times)
    difference = states.position[2] - states.position[0]
    # central difference: error w^3 r h^2 / 6, 1e-7 m/s, and rounding, 1e-8
    np.testing.assert_allclose(states.velocity[1], difference, atol=1e-6)


def test_eme2000_is_biased_by_milliarcseconds():
    # IERS Conventions (2010), section 5.5.4: pole (-16.617, -6.819) mas, equinox -14.6 mas
    states = to_gcrs(States(np.eye(3), np.eye(3)), "EME2000", EPOCH, np.zeros(3))
    mas = 1e-3 * ARCSECOND
    np.testing.assert_allclose(states.position[2, :2], [-16.617 * mas, -6.819 * mas], rtol=1e-3)
    np.testing.assert_allclose(states.position[0, 1], -14.6 * mas, rtol=1e-3)
    np.testing.assert_allclose(states.velocity, states.position)


def test_refuses_a_frame_that_is_unknown():
    with pytest.raises(InputError, match="frame: found 'MOON', expected one of GCRS"):
        to_gcrs(States(np.eye(3), np.eye(3)), "MOON", EPOCH, np.zeros(3))


def test_geodetic_coordinates_are_those_of_the_ellipsoid():
    rng = np.random.default_rng(2)
    latitude, longitude = rng.uniform(-1.57, 1.57, 50), rng.uniform(-3.14, 3.14, 50)
    height = rng.uniform(0.0, 4e7, 50)
    squared = 2.0 / 298.257223563 - 1.0 / 298.257223563**2
    radius = 6378137.0 / np.sqrt(1.0 - squared * np.sin(latitude) ** 2)
    level = (radius + height) * np.cos(latitude)
    up = (radius * (1.0 - squared) + height) * np.sin(latitude)
    position = np.stack([level * np.cos(longitude), level * np.sin(longitude), up], axis=1)
    found = geodetic(position)
    np.testing.assert_allclose(found[:2], [latitude, longitude], atol=1e-12)
    np.testing.assert_allclose(found[2], height, atol=1e-6)


@pytest.mark.parametrize("year", [1975, 2000, 2026])
def test_the_sun_is_where_a_short_formula_has_it(year):
    # J. Meeus, "Astronomical Algorithms", chapter 25: geometric longitude to 0.01 degrees, mean
    # equinox of date
    epoch = Epoch.of(f"{year}-01-03T00:00:00Z")
    times = np.linspace(0.0, 365 * 86400.0, 40)
    centuries = (epoch.tt(times).day - 2451545.0 + epoch.tt(times).fraction) / 36525.0
    mean = np.radians(357.52911 + 35999.05029 * centuries)
    eccentricity = 0.016708634 - 0.000042037 * centuries
    centre = np.radians(
        (1.914602 - 0.004817 * centuries) * np.sin(mean)
        + (0.019993 - 0.000101 * centuries) * np.sin(2.0 * mean)
        + 0.000289 * np.sin(3.0 * mean)
    )
    longitude = np.radians(280.46646 + 36000.76983 * centuries) + centre
    distance = 1.000001018 * (1.0 - eccentricity**2) / (1.0 + eccentricity * np.cos(mean + centre))
    tilt = np.radians(23.4392911 - 0.0130042 * centuries)
    sine = np.sin(longitude)
    of_date = np.stack([np.cos(longitude), sine * np.cos(tilt), sine * np.sin(tilt)], axis=1)
    expected = rotated(transposed(erfa.pmat06(*epoch.tt(times))), of_date)
    sun = sun_position(epoch, times) / ASTRONOMICAL_UNIT
    length = np.linalg.norm(sun, axis=1)
    off = np.linalg.norm(np.cross(sun / length[:, None], expected), axis=1)
    assert np.max(np.degrees(off)) < 0.01
    np.testing.assert_allclose(length, distance, atol=1e-4)


@pytest.mark.parametrize("year", [1975, 2000, 2026])
def test_the_moon_is_where_a_short_formula_has_it(year):
    # The Astronomical Almanac, page D22: ecliptic longitude to 0.3 and latitude to 0.2 degrees,
    # parallax to 0.003 degrees, mean equinox of date
    epoch = Epoch.of(f"{year}-01-03T00:00:00Z")
    times = np.linspace(0.0, 60 * 86400.0, 60)
    t = (epoch.tt(times).day - 2451545.0 + epoch.tt(times).fraction) / 36525.0

    def sine(size, start, rate):
        return size * np.sin(np.radians(start + rate * t))

    longitude = 218.32 + 481267.881 * t + sine(6.29, 135.0, 477198.87)
    longitude += sine(-1.27, 259.3, -413335.36) + sine(0.66, 235.7, 890534.22)
    longitude += sine(0.21, 269.9, 954397.74) + sine(-0.19, 357.5, 35999.05)
    longitude += sine(-0.11, 186.5, 966404.03)
    latitude = sine(5.13, 93.3, 483202.02) + sine(0.28, 228.2, 960400.89)
    latitude += sine(-0.28, 318.3, 6003.15) + sine(-0.17, 217.6, -407332.21)
    parallax = 0.9508 + sine(0.0518, 225.0, 477198.87) + sine(0.0095, 349.3, -413335.36)
    parallax += sine(0.0078, 325.7, 890534.22) + sine(0.0028, 359.9, 954397.74)
    east, north = np.radians(longitude), np.radians(latitude)
    ecliptic = np.stack(
        [np.cos(north) * np.cos(east), np.cos(north) * np.sin(east), np.sin(north)], axis=1
    )
    tilt = np.radians(23.4392911 - 0.0130042 * t)
    x, y, z = ecliptic.T
    of_date = np.stack(
        [x, y * np.cos(tilt) - z * np.sin(tilt), y * np.sin(tilt) + z * np.cos(tilt)], axis=1
    )
    expected = rotated(transposed(erfa.pmat06(*epoch.tt(times))), of_date)
    moon = moon_position(epoch, times)
    length = np.linalg.norm(moon, axis=1)
    off = np.linalg.norm(np.cross(moon / length[:, None], expected), axis=1)
    assert np.max(np.degrees(off)) < 0.4
    np.testing.assert_allclose(length, 6378137.0 / np.sin(np.radians(parallax)), rtol=0.004)


def test_the_moon_is_opposite_to_the_sun_in_a_lunar_eclipse():
    # NASA's catalogue of lunar eclipses: total, greatest at 06:58:43 UT, gamma 0.3485
    epoch, now = Epoch.of("2025-03-14T06:58:43Z"), np.zeros(1)
    moon, sun = moon_position(epoch, now)[0], sun_position(epoch, now)[0]
    away = -sun / np.linalg.norm(sun)
    distance = np.linalg.norm(moon - (moon @ away) * away)  # from the axis of the shadow
    assert distance == pytest.approx(0.3485 * 6378137.0, rel=0.02)
