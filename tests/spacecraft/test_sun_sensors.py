"""Sun sensors against geometry: cosines, noise, eclipse and field of view."""

from types import SimpleNamespace

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft.sensors.sun_sensor import CoarseSunSensors, SunSensor
from tests.spacecraft import orbit_samples

ATTITUDE = np.array([0.5, -0.1, 0.7, 0.5]) / np.linalg.norm([0.5, -0.1, 0.7, 0.5])
SUN = Rotation.from_quat(ATTITUDE, scalar_first=True).inv().apply([1.0, 0.0, 0.0])
"""Direction of the Sun in body axes; the parallax of an orbit is below 5e-5 rad."""
STATE = SimpleNamespace(attitude=jnp.asarray(ATTITUDE))
KEY = jax.random.key(0)
sensed = eqx.filter_jit(lambda sensor, time: sensor(STATE, time, KEY))
drawn = eqx.filter_jit(
    lambda sensor: jax.vmap(lambda key: sensor(STATE, 0.0, key))(jax.random.split(KEY, 2000))
)


@pytest.fixture(scope="module")
def orbit():
    """It starts between Earth and Sun; half a period later it is in the umbra."""
    return orbit_samples.noon(6000.0)


def test_cells_give_cosines_and_nothing_in_the_umbra(orbit):
    sensor = CoarseSunSensors(orbit, scale_factor=0.1)
    sensor.check()
    cells = np.array(sensed(sensor, np.zeros(())))
    expected = 1.1 * np.maximum(np.stack([SUN, -SUN], 1).ravel(), 0.0)
    np.testing.assert_allclose(cells, expected, atol=1e-4)
    np.testing.assert_array_equal(sensed(sensor, np.asarray(0.5 * orbit.period)), 0.0)


def test_cells_have_independent_noise(orbit):
    sensor = CoarseSunSensors(orbit, np.array([SUN, -SUN]), sigma=0.02)
    cells = np.asarray(drawn(sensor))
    np.testing.assert_allclose(cells.mean(0), [1.0, 0.0], atol=2e-3)
    np.testing.assert_allclose(cells.std(0), 0.02, rtol=0.08)
    assert abs(np.corrcoef(cells.T)[0, 1]) < 0.09


def test_the_direction_has_unit_length_and_noise_across_the_sun(orbit):
    sensor = SunSensor(orbit, 2e-3, misalignment=np.array([0.0, 0.01, 0.0]))
    sensor.check()
    seen = np.asarray(drawn(sensor))
    np.testing.assert_allclose(np.linalg.norm(seen, axis=1), 1.0, rtol=1e-12)
    centre = Rotation.from_rotvec([0.0, 0.01, 0.0]).inv().apply(SUN)
    across = np.linalg.svd(centre[None])[2][1:]
    off = seen @ across.T
    np.testing.assert_allclose(off.mean(0), 0.0, atol=2e-4)
    np.testing.assert_allclose(off.std(0), 2e-3, rtol=0.08)


def test_the_sun_is_not_seen_in_the_umbra_or_outside_the_field_of_view(orbit):
    boresight, angle = np.array([0.0, 0.0, 2.0]), np.arccos(SUN[2])
    for share, seen in ((0.99, False), (1.01, True)):
        sensor = SunSensor(orbit, boresight=boresight, field_of_view=share * angle)
        value = np.asarray(sensed(sensor, np.zeros(())))
        np.testing.assert_allclose(value, SUN if seen else 0.0, atol=1e-4)
    umbra = np.asarray(0.5 * orbit.period)
    np.testing.assert_array_equal(sensed(SunSensor(orbit), umbra), 0.0)


def test_bad_sun_sensors_are_refused(orbit):
    for sensor, message in (
        (CoarseSunSensors(orbit, np.ones((2, 3))), "sun cells: found another length"),
        (CoarseSunSensors(orbit, np.ones((2, 2))), r"found shape \(2, 2\)"),
        (
            SunSensor(orbit, boresight=np.zeros(3)),
            "boresight of the sun sensor: found no direction",
        ),
        (SunSensor(orbit, field_of_view=0.0), "field of view: found 0"),
    ):
        with pytest.raises(InputError, match=message):
            sensor.check()
