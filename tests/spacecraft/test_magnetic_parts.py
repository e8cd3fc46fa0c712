"""Torque rods, magnetometer and sampled sensors against the cross product and the true field."""

from types import SimpleNamespace

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft.actuators.torque_rods import TorqueRods
from gyrostat.spacecraft.sensors.magnetometer import Magnetometer
from gyrostat.spacecraft.sensors.sampled import LONGEST, Sampled
from tests.spacecraft import orbit_samples

ATTITUDE = np.array([0.5, -0.1, 0.7, 0.5]) / np.linalg.norm([0.5, -0.1, 0.7, 0.5])
BODY = Rotation.from_quat(ATTITUDE, scalar_first=True).inv()


@pytest.fixture(scope="module")
def orbit():
    return orbit_samples.noon(6000.0)


called = eqx.filter_jit(lambda function, *given: function(*given))


def field_in_body(orbit, time):
    return BODY.apply(np.array(called(orbit.field, np.asarray(time))))


def test_the_torque_is_dipole_cross_field_within_the_limits(orbit):
    limit, duty, time = np.array([0.2, 0.1, 0.3]), 0.8, 1234.0
    rods = TorqueRods(orbit, limit, duty=duty)
    rods.check()
    field = field_in_body(orbit, time)
    for dipole in np.random.default_rng(1).normal(0.0, 0.3, (8, 3)):
        torque = np.asarray(called(rods, dipole, ATTITUDE, time))
        expected = duty * np.cross(np.clip(dipole, -limit, limit), field)
        np.testing.assert_allclose(torque, expected, rtol=1e-13, atol=1e-20)
        assert abs(torque @ field) <= 1e-15 * np.linalg.norm(torque) * np.linalg.norm(field)
    along = 0.1 * field / np.linalg.norm(field)
    np.testing.assert_allclose(called(rods, along, ATTITUDE, time), 0.0, atol=1e-20)


def test_rods_on_any_axes_add_their_dipoles(orbit):
    axes = np.array([[1.0, 0.0, 0.6, 0.0], [0.0, 1.0, 0.8, 0.0], [0.0, 0.0, 0.0, -1.0]])
    dipole = np.array([0.1, -0.05, 0.2, 0.3])
    many = called(TorqueRods(orbit, np.inf, axes), dipole, ATTITUDE, 10.0)
    three = called(TorqueRods(orbit, 10.0), axes @ dipole, ATTITUDE, 10.0)
    np.testing.assert_allclose(many, three, rtol=1e-13)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"limit": -0.1}, "dipole limit: found -0.1"),
        ({"limit": 0.1, "duty": 0.0}, "duty of the torque rods: found 0, expected in"),
        ({"limit": 0.1, "axes": 2.0 * np.eye(3)}, "expected unit vectors"),
        ({"limit": 0.1, "axes": np.eye(2)}, r"found shape \(2, 2\)"),
    ],
)
def test_bad_rods_are_refused(orbit, options, message):
    with pytest.raises(InputError, match=message):
        TorqueRods(orbit, **options).check()


def test_a_command_for_other_rods_is_refused(orbit):
    with pytest.raises(InputError, match=r"torque rods: found a command of shape \(2,\)"):
        TorqueRods(orbit, 1.0)(np.zeros(2), ATTITUDE, 0.0)


def test_the_magnetometer_measures_the_field_with_its_errors(orbit):
    bias, scale, turn = (
        np.array(x) for x in ([1e-7, -2e-7, 3e-8], [0.01, -0.02, 0.0], [0.02, 0.0, -0.05])
    )
    sensor = Magnetometer(orbit, 5e-8, bias, scale, turn)
    sensor.check()
    state = SimpleNamespace(attitude=jnp.asarray(ATTITUDE))
    keys = jax.random.split(jax.random.key(3), 4000)
    seen = np.asarray(jax.jit(jax.vmap(lambda key: sensor(state, 700.0, key)))(keys))
    mounted = Rotation.from_rotvec(turn).inv().apply(field_in_body(orbit, 700.0))
    np.testing.assert_allclose(seen.mean(0), (1.0 + scale) * mounted + bias, atol=4 * 5e-8 / 63.0)
    np.testing.assert_allclose(seen.std(0), 5e-8, rtol=0.06)
    assert np.abs(np.corrcoef(seen.T) - np.eye(3)).max() < 0.07


class Clock:
    """The time of the sample and the first number of the state."""

    unit = "s"

    def __call__(self, state, time, key):
        return jnp.stack([time, state[0]])


@pytest.mark.parametrize(("periods", "latency"), [(1, 0), (4, 0), (1, 3), (4, 2), (3, LONGEST)])
def test_a_sampled_sensor_holds_and_delays_its_values(periods, latency):
    sensor = Sampled(Clock(), float(periods), float(latency))
    sensor.check()
    assert sensor.unit == "s"
    memory = sensor.start(jnp.array([7.0]), 0.1)
    step = jax.jit(sensor)
    for k in range(30):
        memory, value = step(memory, jnp.array([7.0 + k]), jax.random.key(0))
        taken = max(k - latency, 0) // periods * periods
        np.testing.assert_allclose(value, [0.1 * taken, 7.0 + taken], rtol=1e-13)


def test_bad_sampling_is_refused():
    for options, message in (
        ({"periods": 1.5}, "sampling interval: found 1.5"),
        ({"latency": LONGEST + 1.0}, f"latency of a sensor: found {LONGEST + 1}"),
    ):
        with pytest.raises(InputError, match=message):
            Sampled(Clock(), **options).check()
