"""Targets and scan patterns, against geometry that is computed in another way."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from gyrostat.control.guidance import (
    Celestial,
    GroundStrip,
    GroundTarget,
    Limb,
    Mosaic,
    OtherSpacecraft,
    Pointing,
    Raster,
    Scanned,
    SecondAxis,
    StationView,
    Sunlight,
    to_earth,
)
from gyrostat.control.guidance.targets import NORMAL, SUN, VELOCITY
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.units import parse_quantity
from gyrostat.spacecraft.orbit.orbit_environment import spline_of
from tests.spacecraft import orbit_samples

ORBIT = orbit_samples.environment()
# half axes of WGS 84, m
EQUATOR, POLE = 6378137.0, 6356752.314245


def unit(vector):
    return np.asarray(vector) / np.linalg.norm(vector)


def fixed(vector, time):
    """Vector in axes that turn with the Earth of the samples."""
    return Rotation.from_rotvec([0.0, 0.0, -orbit_samples.EARTH_RATE * time]).apply(vector)


def height(place):
    """Geodetic height by the point of the ellipsoid that is nearest, found by a search."""
    across, up = np.hypot(place[0], place[1]), place[2]

    def distance(angle):
        return np.hypot(EQUATOR * np.cos(angle) - across, POLE * np.sin(angle) - up)

    near = np.arctan2(up, across)
    found = minimize_scalar(distance, (near - 0.01, near + 0.01), tol=1e-15)
    sign = 1.0 if np.hypot(across / EQUATOR, up / POLE) > 1.0 else -1.0
    return sign * found.fun


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("18h36m56.336s", (18 + 36 / 60 + 56.336 / 3600) * 15),
        ("+38d47m01.28s", 38 + 47 / 60 + 1.28 / 3600),
        ("-0d30m", -0.5),
        ("-8°12'05\"", -(8 + 12 / 60 + 5 / 3600)),
        ("24 deg", 24.0),
    ],
)
def test_angles_are_read_in_hours_and_in_degrees_with_minutes(text, degrees):
    assert np.degrees(parse_quantity(text, "angle", "here")) == pytest.approx(degrees, rel=1e-14)


@pytest.mark.parametrize("text", ["25h00m00s", "361d00m00s", "12h60m00s", "1d00m60s"])
def test_impossible_angles_are_refused(text):
    with pytest.raises(InputError, match="minutes and seconds below 60"):
        parse_quantity(text, "angle", "here")


def test_a_celestial_direction_is_that_of_a_rotation():
    first, _ = Celestial(2.1, -0.7)(ORBIT, 100.0)
    expected = Rotation.from_euler("ZY", [2.1, 0.7]).apply([1.0, 0.0, 0.0])
    np.testing.assert_allclose(first, expected, atol=1e-15)


@pytest.mark.parametrize("choice", [VELOCITY, SUN, NORMAL])
def test_the_second_axis_is_the_chosen_one(choice):
    time = 700.0
    place, velocity = orbit_samples.position(time), orbit_samples.velocity(time)
    expected = (velocity, orbit_samples.SUN - place, np.cross(place, velocity))[choice]
    attitude = Pointing.of(ORBIT, SecondAxis(Celestial(2.1, -0.7), choice), [0, 0, 1], [1, 0, 0])(
        time
    )
    seen = Rotation.from_quat(np.array(attitude), scalar_first=True).inv().apply(expected)
    assert seen[0] > 0.0
    assert abs(seen[1]) < 1e-6 * np.linalg.norm(seen)


@pytest.mark.parametrize("tangent_height", [0.0, 60e3, 300e3])
@pytest.mark.parametrize("azimuth", [0.0, 1.2, np.pi, -2.0])
def test_the_line_of_sight_grazes_the_height(tangent_height, azimuth):
    """The least geodetic height along the line is the tangent height, to 1e-5 of it."""
    time = 900.0
    place = orbit_samples.position(time)
    first, _ = Limb(tangent_height, azimuth)(ORBIT, time)
    line, distance = unit(first), np.linalg.norm(first)
    found = minimize_scalar(
        lambda way: height(fixed(place + way * line, time)),
        bounds=(0.8 * distance, 1.2 * distance),
        method="bounded",
        options={"xatol": 1.0},
    )
    assert found.fun == pytest.approx(tangent_height, abs=1e-5 * tangent_height + 0.05)
    # the azimuth from ahead, to the left: toward the orbit normal
    up, ahead = unit(place), unit(orbit_samples.velocity(time))
    level = line - (line @ up) * up
    left = np.cross(up, ahead)
    turned = np.arctan2(level @ left, level @ ahead) - azimuth
    assert np.remainder(turned + np.pi, 2.0 * np.pi) == pytest.approx(np.pi, abs=1e-9)


def test_a_strip_runs_from_end_to_end():
    first, last = GroundTarget(0.4, 0.8, 100.0), GroundTarget(0.5, 0.7, 300.0)
    strip = GroundStrip(first, last, begin=100.0, duration=50.0)
    for time, target in (
        (20.0, first),
        (100.0, first),
        (125.0, GroundTarget(0.45, 0.75, 200.0)),
        (150.0, last),
        (400.0, last),
    ):
        for found, expected in zip(strip(ORBIT, time), target(ORBIT, time), strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_strip_across_180_degrees_takes_the_shorter_way():
    ends = [GroundTarget(0.1, np.radians(angle)) for angle in (179.0, -179.0)]
    found, _ = GroundStrip(*ends, begin=0.0, duration=60.0)(ORBIT, 15.0)
    expected, _ = GroundTarget(0.1, np.radians(179.5))(ORBIT, 15.0)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_another_spacecraft_is_seen_where_it_is():
    times = np.arange(0.0, 3000.0, 10.0)
    other = OtherSpacecraft(spline_of(orbit_samples.position(times + 30.0)), 10.0)
    found, _ = other(ORBIT, 1234.5)
    expected = orbit_samples.position(1264.5) - orbit_samples.position(1234.5)
    # 228 km ahead
    np.testing.assert_allclose(found, expected, atol=0.02)


def offsets(pattern, times):
    both = jax.jit(jax.vmap(pattern))(np.asarray(times))
    return np.stack(both, axis=-1)


def is_smooth(pattern, times):
    """Continuous rates and accelerations: the largest step of both falls with the sampling."""
    step = times[1] - times[0]
    path = offsets(pattern, times)
    second = np.diff(path, 2, axis=0) / step**2
    return np.max(np.abs(np.diff(second, axis=0))) < 0.05 * np.max(np.abs(second))


RASTER = Raster(length=0.02, spacing=0.001, lines=3, line_time=20.0, turn_time=5.0, begin=50.0)


def test_lines_are_run_through_at_a_constant_rate():
    for line in range(3):
        times = 50.0 + 25.0 * line + np.linspace(0.0, 20.0, 41)
        path = offsets(RASTER, times)
        sign = 1.0 if line % 2 == 0 else -1.0
        np.testing.assert_allclose(path[:, 0], sign * np.linspace(-0.01, 0.01, 41), atol=1e-15)
        np.testing.assert_allclose(path[:, 1], 0.001 * (line - 1.0), atol=1e-15)


def test_between_lines_and_at_both_ends_the_motion_is_smooth():
    assert is_smooth(RASTER, np.linspace(40.0, 150.0, 55_001))
    ends = offsets(RASTER, [0.0, 40.0, 45.0, 125.0, 130.0, 900.0])
    # half the way of a turn at full rate
    run = 0.5 * 5.0 * 0.02 / 20.0
    np.testing.assert_allclose(ends[:3, 0], -0.01 - run, atol=1e-15)
    np.testing.assert_allclose(ends[3:, 0], 0.01 + run, atol=1e-15)


MOSAIC = Mosaic(3, 2, width=0.01, height=0.02, dwell=10.0, step_time=4.0, begin=30.0)


def test_each_tile_is_looked_at_for_its_dwell_time():
    tiles = [(-1, -0.5), (0, -0.5), (1, -0.5), (1, 0.5), (0, 0.5), (-1, 0.5)]
    for number, tile in enumerate(tiles):
        times = 30.0 + 14.0 * number + np.array([0.0, 3.0, 10.0])
        expected = np.array(tile) * [0.01, 0.02]
        np.testing.assert_allclose(offsets(MOSAIC, times), [expected] * 3, atol=1e-15)
    before, after = offsets(MOSAIC, [0.0, 1e4])
    np.testing.assert_allclose(before, [-0.01, -0.01])
    np.testing.assert_allclose(after, [-0.01, 0.01])
    assert is_smooth(MOSAIC, np.linspace(25.0, 120.0, 47_501))


def test_a_pattern_turns_the_line_of_sight_by_its_offsets():
    time = 57.0
    along, beside = (float(each) for each in RASTER(time))
    first, second = to_earth(ORBIT, time)
    found, kept = Scanned(to_earth, RASTER)(ORBIT, time)
    np.testing.assert_array_equal(kept, second)
    one = unit(second - (unit(first) @ second) * unit(first))
    other = np.cross(unit(first), one)
    assert found @ one / (found @ unit(first)) == pytest.approx(np.tan(along))
    assert found @ other / (found @ unit(first)) == pytest.approx(np.tan(beside))


def test_the_elevation_is_the_angle_above_the_horizon():
    erfa = pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")
    time, where = 400.0, (0.9, 0.5, 800.0)
    station = np.array(erfa.gd2gc(1, where[1], where[0], where[2]))
    sight = fixed(orbit_samples.position(time), time) - station
    above = np.array(erfa.gd2gc(1, where[1], where[0], where[2] + 1e5))
    expected = np.pi / 2 - np.arccos(unit(sight) @ unit(above - station))
    view = StationView(ORBIT, *where, least_elevation=0.1)
    assert float(view.elevation(time)) == pytest.approx(expected, abs=1e-9)
    assert float(view(time)) == pytest.approx(expected - 0.1, abs=1e-9)


def test_sunlight_ends_in_the_shadow_of_the_earth():
    """Behind the Earth and within its radius of the line to the Sun, but for the penumbra."""
    sun, light = unit(orbit_samples.SUN), Sunlight(ORBIT)
    times = np.linspace(0.0, 5600.0, 500)
    place = orbit_samples.position(times)
    along = place @ sun
    apart = np.linalg.norm(place - along[:, None] * sun, axis=1)
    dark = (along < 0.0) & (apart < EQUATOR)
    found = np.array(jax.jit(jax.vmap(light))(times)) < 0.0
    sure = np.abs(apart - EQUATOR) > 30e3
    np.testing.assert_array_equal(found[sure], dark[sure])
    assert dark.any()
