"""Tables along an orbit against the functions that they sample."""

from dataclasses import replace

import equinox as eqx
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.rotations import to_body
from gyrostat.spacecraft.orbit.orbit_environment import (
    OrbitEnvironment,
    OrbitSamples,
    interpolated,
    spline_of,
)
from tests.spacecraft import orbit_samples

TIMES = np.linspace(3.0, 5990.0, 400)

# the tables are arguments, so that a function of them is compiled once
along = eqx.filter_jit(lambda function, times: jax.vmap(function)(times))
at = eqx.filter_jit(lambda function, *given: function(*given))


@pytest.fixture(scope="module")
def orbit():
    return orbit_samples.environment()


@pytest.mark.parametrize("name", ["position", "velocity", "field", "density", "earth"])
def test_values_between_rows(orbit, name):
    found = along(getattr(orbit, name), TIMES)
    true = getattr(orbit_samples, name)(TIMES)
    # error of a spline, 5/384 of step⁴ times the fourth derivative; more in the first and last step
    bound = 3.0 * 5.0 / 384.0 * (2.0 * orbit_samples.RATE * 10.0) ** 4
    assert np.max(np.abs(found - true)) < bound * np.max(np.abs(true))


def test_a_spline_is_that_of_scipy_with_its_derivatives():
    rows = np.random.default_rng(4).standard_normal((9, 3))
    spline, places = spline_of(rows), np.array([0.0, 0.3, 3.0, 4.999, 7.5, 8.0])

    def channels(place):
        return interpolated(jax.numpy.asarray(spline), place, 1, 3)

    slopes = jax.jacfwd(channels)
    for order, function in enumerate((channels, slopes, jax.jacfwd(slopes))):
        found = along(function, places)
        np.testing.assert_allclose(
            found, CubicSpline(range(9), rows)(places, order)[:, 1:], atol=1e-13
        )


def test_error_is_of_fourth_order():
    errors = []
    for step in (80.0, 40.0):
        found = along(orbit_samples.environment(step=step).position, TIMES)
        errors.append(np.max(np.abs(found - orbit_samples.position(TIMES))))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.2)


def test_velocity_is_the_slope_of_the_position_at_the_first_row_too(orbit):
    slope_at = jax.jit(lambda time: jax.jvp(orbit.position, (time,), (1.0,))[1])
    for time in (0.0, 1234.5):
        slope = slope_at(time)
        np.testing.assert_allclose(slope, orbit_samples.velocity(time), rtol=0, atol=0.05)


def test_offset_is_a_later_time(orbit):
    later = replace(orbit, offset=700.0)
    np.testing.assert_allclose(at(later.field, 55.0), at(orbit.field, 755.0), rtol=1e-15)


def test_beyond_the_tables_the_last_row_holds(orbit):
    np.testing.assert_array_equal(at(orbit.position, 1e6), at(orbit.position, 2e6))
    first = orbit_samples.position(0.0)
    np.testing.assert_allclose(at(orbit.position, -5.0), first, rtol=1e-15)


def test_tables_until_a_time_are_the_same_until_then(orbit):
    later = replace(orbit, offset=700.0)
    short, times = later.until(95.0), np.linspace(-30.0, 95.0, 26)
    assert len(short.splines) < 0.2 * len(orbit.splines)
    for name in ("position", "field", "density", "earth"):
        found, whole = (along(getattr(each, name), times) for each in (short, later))
        np.testing.assert_array_equal(found, whole)
    assert len(orbit.until(1e9).splines) == len(orbit.splines)


def test_ground_point_turns_with_the_earth(orbit):
    equator = at(orbit.ground, 0.0, 0.0, 0.0, 3600.0)
    turned = orbit_samples.EARTH_RATE * 3600.0
    true = 6378137.0 * np.array([np.cos(turned), np.sin(turned), 0.0])
    np.testing.assert_allclose(equator, true, rtol=1e-10, atol=1e-2)
    pole = at(orbit.ground, np.pi / 2, 0.3, 10.0, 0.0)
    np.testing.assert_allclose(pole, [0.0, 0.0, 6356752.3142 + 10.0], atol=1e-3)


def test_ground_point_against_erfa(orbit):
    erfa = pytest.importorskip("erfa")
    point = at(orbit.ground, 0.7, -1.9, 350.0, 2000.0)
    fixed = at(to_body, at(orbit.earth, 2000.0), point)
    np.testing.assert_allclose(fixed, erfa.gd2gc(1, -1.9, 0.7, 350.0), rtol=1e-12)


def test_values_that_cannot_be_are_refused():
    times = np.arange(5.0)
    good = OrbitSamples(
        *(orbit_samples.position(times) for _ in range(4)), np.ones(5), orbit_samples.earth(times)
    )
    with pytest.raises(InputError, match="expected above 0"):
        OrbitEnvironment.of(1.0, good._replace(density=np.zeros(5)), 6000.0)
    bad = good.field.copy()
    bad[3, 1] = np.nan
    with pytest.raises(InputError, match="row 3"):
        OrbitEnvironment.of(1.0, good._replace(field=bad), 6000.0)
    with pytest.raises(InputError, match="four or more"):
        OrbitEnvironment.of(1.0, OrbitSamples(*(part[:3] for part in good[:6])), 6000.0)
