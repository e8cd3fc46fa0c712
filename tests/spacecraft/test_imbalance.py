"""Imbalance of wheels against Newton and Euler, integrated at the wheels' rate."""

from types import SimpleNamespace

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Gyrostat, Imbalance, ImbalancedGyrostat, Spacecraft
from gyrostat.wheel import WheelArray, pyramid_axes

AXES = pyramid_axes(4)
ROTORS = np.full(4, 2e-5)
INERTIA = np.array([[0.12, 0.004, 0.0], [0.004, 0.10, -0.003], [0.0, -0.003, 0.06]])
CRAFT = Spacecraft(INERTIA, WheelArray(AXES, ROTORS))
IMBALANCE = Imbalance(
    np.array([1e-6, 2e-6, 0.5e-6, 1e-6]), np.array([1e-7, 3e-7, 2e-7, 1e-7]), 0.1 * AXES[::-1]
)
"""Ten times and more what cubesats' wheels have."""
SPEED = np.array([300.0, -200.0, 410.0, -150.0])
ANGLE = np.array([0.0, 1.0, 2.0, 3.0])
RATE = np.array([0.01, -0.02, 0.015])
PERIOD, COUNT = 0.25, 12
jitters = jax.jit(jax.vmap(lambda angle: IMBALANCE.jitter(CRAFT, SPEED, angle)))


@pytest.fixture(scope="module")
def flown(frictionless):
    """Attitudes of a body with balanced and with imbalanced wheels, and the rate at the start."""
    plant = ImbalancedGyrostat(frictionless(Gyrostat(CRAFT)), IMBALANCE)
    state = plant.start(rate=RATE, wheel_speed=SPEED, wheel_angle=ANGLE)

    @eqx.filter_jit
    def fly(state):
        def step(state, _):
            state, _ = plant(state, SimpleNamespace(torque=jnp.zeros(4)), 0.0, PERIOD)
            return state, state

        return jax.lax.scan(step, state, length=COUNT)[1]

    return plant, state, jax.tree.map(np.array, fly(state))


def test_attitudes_sampled_far_apart_have_the_jitter_of_their_time(flown):
    """At 4 Hz, against an integration that resolves 65 Hz, to a thousandth of the jitter.

    The reference keeps the momentum of body, rotors and imbalances. Forces of constant size in
    Euler's equation would not: they miss what the turning of the body adds to them, and drift.
    """
    _, start, states = flown
    own = ROTORS * (SPEED + AXES.T @ RATE)
    momentum_of = jax.jit(lambda s, a: -INERTIA @ IMBALANCE.jitter_rate(CRAFT, s, a))

    def slope(time, y):
        attitude, angle = y[:4], y[4:]
        turn = Rotation.from_quat(attitude, scalar_first=True).inv()
        left = turn.apply(np.array(start.momentum)) - AXES @ own
        speed = own / ROTORS - AXES.T @ np.linalg.solve(INERTIA, left)
        rate = np.linalg.solve(INERTIA, left - np.array(momentum_of(speed, angle)))
        vector = attitude[0] * rate + np.cross(attitude[1:], rate)
        return np.array([-0.5 * attitude[1:] @ rate, *(0.5 * vector), *speed])

    begin = np.concatenate([start.attitude, ANGLE])
    times = PERIOD * (1 + np.arange(COUNT))
    found = (
        solve_ivp(
            slope, (0.0, times[-1]), begin, "DOP853", times, rtol=1e-10, atol=1e-12, max_step=4e-3
        )
        .y[:4]
        .T
    )
    true = Rotation.from_quat(found.copy(), scalar_first=True)
    error = (true.inv() * Rotation.from_quat(states.attitude, scalar_first=True)).magnitude()
    largest = np.max(np.linalg.norm(jitters(states.wheel_angle), axis=1))
    assert np.max(error) < 1e-3 * largest
    assert largest > 3e-6


def test_the_jitter_is_that_of_forces_and_torques_that_go_round():
    """J d²(jitter)/dt² is the torque r x F and U_d W²; both across the axis, of their size."""

    def twice(function, time):
        return jax.jvp(lambda t: jax.jvp(function, (t,), (1.0,))[1], (time,), (1.0,))[1]

    def jitter(time):
        return jitters((ANGLE + SPEED * time)[None])[0]

    bend = twice(jitter, 0.3)
    _, torque = IMBALANCE.loads(AXES, SPEED, ANGLE + 0.3 * SPEED)
    np.testing.assert_allclose(INERTIA @ bend, torque, rtol=1e-9)
    rate = jax.jvp(jitter, (0.3,), (1.0,))[1]
    told = IMBALANCE.jitter_rate(CRAFT, SPEED, ANGLE + 0.3 * SPEED)
    np.testing.assert_allclose(told, rate, rtol=1e-9)
    alone = SPEED * [0, 1, 0, 0]
    force, torque = IMBALANCE.loads(AXES, alone, ANGLE)
    assert np.linalg.norm(force) == pytest.approx(2e-6 * 200.0**2)
    assert float(force @ AXES[:, 1]) == pytest.approx(0.0, abs=1e-15)
    central = Imbalance(IMBALANCE.static, IMBALANCE.dynamic, np.zeros((3, 4)))
    _, torque = central.loads(AXES, alone, ANGLE)
    assert np.linalg.norm(torque) == pytest.approx(3e-7 * 200.0**2)
    assert float(torque @ AXES[:, 1]) == pytest.approx(0.0, abs=1e-15)


def test_the_peak_is_reached_by_no_more_than_all_wheels_together():
    angles = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, (COUNT * 400, 4))
    seen = np.max([np.abs(jitters(some)) for some in np.split(angles, 400)], axis=(0, 1))
    peak = np.asarray(IMBALANCE.peak(CRAFT))
    assert np.all(seen <= peak)
    assert np.all(seen > 0.95 * peak)


def test_record_and_rate_have_the_jitter(flown):
    plant, start, _ = flown
    record = plant.record(start, SimpleNamespace(torque=np.zeros(4)))
    assert np.allclose(record.jitter, IMBALANCE.jitter(CRAFT, SPEED, ANGLE))
    jitter = IMBALANCE.jitter_rate(CRAFT, SPEED, ANGLE)
    assert np.allclose(plant.rate(start) - record.rate, jitter, atol=1e-12)
    assert np.linalg.norm(jitter) > 1e-4


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"static": -np.ones(4)}, "static imbalance"),
        ({"dynamic": np.full(4, np.nan)}, "dynamic imbalance"),
        ({"position": np.full((3, 4), np.inf)}, "position"),
        ({"static": np.ones(3)}, "imbalance static"),
    ],
)
def test_an_imbalance_that_is_none_is_refused(change, message):
    fields = {name: getattr(IMBALANCE, name) for name in ("static", "dynamic", "position")}
    plant = ImbalancedGyrostat(Gyrostat(CRAFT), Imbalance(**{**fields, **change}))
    with pytest.raises(InputError, match=message):
        plant.check()


def test_a_state_without_an_angle_for_every_wheel_is_refused():
    plant = ImbalancedGyrostat(Gyrostat(CRAFT), IMBALANCE)
    plant.check_state(plant.start())
    with pytest.raises(InputError, match="wheel_angle"):
        plant.check_state(plant.start()._replace(wheel_angle=np.zeros(3)))
