"""Interpolation of external torques within a step, against the torques themselves."""

from functools import partial
from types import SimpleNamespace

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector, rate_of_quaternion, to_body, to_inertial
from gyrostat.spacecraft import Gyrostat, Spacecraft
from gyrostat.spacecraft.interpolated_torque import with_interpolated_torque
from gyrostat.wheel import WheelArray, orthogonal_axes

RATE = np.array([0.03, -0.02, 0.01])
MOTORS = np.array([2e-4, -1e-4, 1e-4])
BODY = np.diag([0.1, 0.14, 0.17])
SPEED = 100.0


def inertial(spacecraft, attitude, time):
    """Torque that is constant in direction and swings slowly."""
    del spacecraft
    return to_body(attitude, jnp.array([1e-3, 2e-3, -1e-3]) * (1.0 + jnp.sin(0.01 * time)))


@pytest.fixture(scope="module")
def plant():
    wheels = WheelArray(orthogonal_axes(), np.full(3, 1e-5))
    return Gyrostat(Spacecraft(BODY, wheels), environment=(inertial,))


def interpolated(plant, state, time, duration):
    """Torque over an interval, with the motor torques MOTORS."""
    contacts = SimpleNamespace(
        body=plant,
        friction=plant.spacecraft.wheels.friction,
        torque=MOTORS,
        added_viscous=np.zeros(3),
        inverse=np.linalg.inv(BODY),
    )
    return with_interpolated_torque(contacts, state, time, duration)


started = eqx.filter_jit(lambda plant: plant.start(rate=RATE, wheel_speed=SPEED))


@eqx.filter_jit
def _derivative(plant, time, motion):
    attitude, total, rate = motion[:4], motion[4:7], motion[7:]
    torque = plant.torque(attitude, 5.0 + time)
    gained = torque - jnp.cross(rate, to_body(attitude, total)) - MOTORS
    spin, turn = rate_of_quaternion(attitude, rate), np.linalg.inv(BODY) @ gained
    return jnp.concatenate([spin, to_inertial(attitude, torque), turn])


@eqx.filter_jit
def _errors(plant, state, duration, times, attitudes):
    found = interpolated(plant, state, 5.0, duration)
    return jax.vmap(lambda t, q: found.torque(q, 5.0 + t) - plant.torque(q, 5.0 + t))(
        times, attitudes
    )


def largest_error(plant, duration):
    """Error along the motion, which SciPy integrates with the wheels' torque."""
    state = started(plant)
    derivative = partial(_derivative, plant)
    first = np.concatenate([state.attitude, state.momentum, RATE])
    times = duration * np.array([0.3, 0.6, 0.9])
    way = solve_ivp(derivative, (0.0, duration), first, "DOP853", times, rtol=1e-13, atol=1e-14)
    return np.max(np.linalg.norm(_errors(plant, state, duration, times, way.y[:4].T), axis=1))


def test_error_is_of_fourth_order(plant):
    errors = [largest_error(plant, np.asarray(duration)) for duration in (1.6, 0.8, 0.4)]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.3)
    # 3 a² t⁴ / 384 of the torque, as the body accelerates by a
    level = np.array([1.0, 0.0, 0.0, 0.0])
    torque = np.linalg.norm(eqx.filter_jit(plant.torque)(level, 5.0))
    acceleration = np.linalg.norm(np.linalg.inv(BODY) @ (torque + np.abs(MOTORS)))
    assert errors[2] < 3.0 * acceleration**2 * 0.4**4 / 384.0 * torque


def test_value_and_slope_at_the_start_are_those_of_the_torque(plant):
    @jax.jit
    def values():
        state = plant.start(rate=RATE)
        found = interpolated(plant, state, 7.0, 0.25)
        slope = jax.grad(lambda t: plant.torque(from_rotation_vector((t - 7.0) * RATE), t)[1])(7.0)
        torques = found.torque(state.attitude, 7.0), plant.torque(state.attitude, 7.0)
        return *torques, found.cubic[1][1], slope

    torque, expected, found_slope, slope = values()
    np.testing.assert_allclose(torque, expected)
    assert found_slope == pytest.approx(float(slope), rel=1e-12)


def test_an_interval_of_no_length_is_finite(plant):
    @jax.jit
    def torque():
        state = plant.start(rate=RATE)
        return interpolated(plant, state, 1.0, 0.0).torque(state.attitude, 1.0)

    assert np.all(np.isfinite(torque()))
