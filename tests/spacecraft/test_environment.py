"""External torques against libration, Jacobi's integral and momentum balances."""

from types import SimpleNamespace

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import to_body
from gyrostat.spacecraft import (
    CircularOrbit,
    GravityGradient,
    Gyrostat,
    HarmonicTorque,
    Spacecraft,
    WheelTorqueCommand,
)
from gyrostat.wheel import WheelArray, orthogonal_axes
from gyrostat.wheel.friction import ViscousCoulomb

ORBIT = CircularOrbit.at_altitude(500e3, inclination=0.9, ascending_node=0.4, latitude=-0.3)
STUCK = ViscousCoulomb(0.0, 1.0)
"""Wheels that stay at rest: the spacecraft is one rigid body."""
CALM = HarmonicTorque(0.0, cosine=np.zeros((2, 3)), sine=np.zeros((2, 3)))
COUNT = 200
ROUNDS = 1e-8
"""Error after two turns in Runge-Kutta steps of 0.02 rad, about 600 (0.02)^5 / 120, rad."""


def craft(inertia, *, orbit=ORBIT, torque=None, limit=0.0):
    """One structure, so that it is compiled once."""
    wheels = WheelArray(orthogonal_axes(), np.full(3, 0.01), friction=STUCK)
    return Gyrostat(
        Spacecraft(np.asarray(inertia, dtype=float), wheels),
        environment=(GravityGradient(orbit), torque or CALM),
        external_torque_limit=np.full(3, limit),
    )


@eqx.filter_jit
def _fly(plant, state, external, period):
    def step(state, k):
        command = SimpleNamespace(torque=jnp.zeros(3), external_torque=external)
        state, resolved = plant(state, command, k * period, period)
        return state, (state, resolved)

    return jax.lax.scan(step, state, jnp.arange(COUNT))[1]


def fly(plant, state, period, external=(0.0, 0.0, 0.0)):
    arrays = jax.tree.map(
        lambda x: jnp.asarray(x, dtype=float), (plant, state, np.asarray(external), period)
    )
    states, resolved = _fly(*arrays)
    assert np.all(resolved)
    return jax.tree.map(np.array, states)


def aligned(orbit):
    """Attitude with x along the zenith and z along the orbit's normal, at time 0."""
    turn = Rotation.from_euler("ZXZ", [orbit.ascending_node, orbit.inclination, orbit.latitude])
    return turn.as_quat(scalar_first=True)


def test_the_zenith_goes_round_the_plane_of_the_orbit():
    """500 km: 94.6 min. Turned into the orbit's axes it is (cos, sin, 0)."""
    assert 2.0 * np.pi / ORBIT.rate == pytest.approx(94.62 * 60.0, rel=1e-4)
    for time in (0.0, 1000.0, 4000.0):
        seen = to_body(jnp.asarray(aligned(ORBIT)), ORBIT.zenith(time))
        angle = ORBIT.rate * time
        assert np.allclose(seen, [np.cos(angle), np.sin(angle), 0.0], atol=1e-14)


def test_a_body_librates_in_pitch_at_its_frequency():
    """n sqrt(3 (J_y - J_x) / J_z), the least inertia along the zenith."""
    inertia = np.array([1.0, 1.7, 1.8])
    plant = craft(np.diag(inertia - 0.01))
    frequency = ORBIT.rate * np.sqrt(3.0 * (inertia[1] - inertia[0]) / inertia[2])
    pitch = 1e-3
    turned = Rotation.from_quat(aligned(ORBIT), scalar_first=True) * Rotation.from_rotvec(
        [0.0, 0.0, pitch]
    )
    state = plant.start(attitude=turned.as_quat(scalar_first=True), rate=[0.0, 0.0, ORBIT.rate])
    period = 40.0
    states = fly(plant, state, period)
    time = period * (1.0 + np.arange(COUNT))
    zenith = np.array(jax.vmap(ORBIT.zenith)(time))
    seen = Rotation.from_quat(states.attitude, scalar_first=True).inv().apply(zenith)
    expected = pitch * np.cos(frequency * time)
    assert np.allclose(np.arctan2(-seen[:, 1], seen[:, 0]), expected, rtol=0.0, atol=2 * ROUNDS)
    assert np.ptp(expected) > 1.9 * pitch


def test_a_tumbling_body_keeps_the_integral_of_jacobi():
    """w.J w / 2 + 3/2 n² r.J r - n c.H, c the normal of the orbit."""
    inertia = np.array([[1.2, 0.1, -0.05], [0.1, 1.5, 0.08], [-0.05, 0.08, 1.9]])
    plant = craft(inertia)
    n = ORBIT.rate
    state = plant.start(attitude=[0.7, 0.1, -0.5, 0.4], rate=[2 * n, -1.5 * n, n])
    period = 30.0
    states = fly(plant, state, period)
    locked = np.asarray(plant.spacecraft.inertia_locked())
    attitude = Rotation.from_quat(states.attitude, scalar_first=True)
    momentum = attitude.inv().apply(states.momentum)
    rate = np.linalg.solve(locked, momentum.T).T
    zenith = np.array(jax.vmap(ORBIT.zenith)(period * (1.0 + np.arange(COUNT))))
    seen = attitude.inv().apply(zenith)
    normal = Rotation.from_quat(aligned(ORBIT), scalar_first=True).apply([0.0, 0.0, 1.0])
    kinetic = 0.5 * np.sum(rate * momentum, axis=1)
    potential = 1.5 * n**2 * np.sum(seen * (seen @ locked), axis=1)
    integral = kinetic + potential - n * states.momentum @ normal
    assert np.ptp(integral) < ROUNDS * np.max(kinetic)
    assert np.ptp(kinetic) > 0.1 * np.max(kinetic)


HEAVY = np.eye(3) * 1e15
"""A body that does not turn: momentum in body axes is momentum in space."""


def test_momentum_is_the_integral_of_constant_and_harmonics():
    rate = 2.0 * np.pi / 5000.0
    torque = HarmonicTorque(
        rate,
        constant=np.array([1e-5, -2e-5, 0.0]),
        cosine=np.array([[1e-5, 0.0, 0.0], [0.0, 3e-5, 0.0]]),
        sine=np.array([[0.0, 0.0, 2e-5], [4e-5, 0.0, 0.0]]),
    )
    far = CircularOrbit(1e-12)
    plant = craft(HEAVY, orbit=far, torque=torque)
    states = fly(plant, plant.start(), 25.0)
    time = 25.0 * (1.0 + np.arange(COUNT))[:, None]
    expected = torque.constant * time
    for k in (1, 2):
        angle = k * rate * time
        expected = expected + torque.cosine[k - 1] * np.sin(angle) / (k * rate)
        expected = expected + torque.sine[k - 1] * (1.0 - np.cos(angle)) / (k * rate)
    assert np.allclose(states.momentum, expected, rtol=0.0, atol=1e-9)


def test_a_commanded_external_torque_acts_within_its_limit():
    plant = craft(HEAVY, orbit=CircularOrbit(1e-12), limit=2e-3)
    states = fly(plant, plant.start(), 25.0, external=[1e-3, -5e-3, 0.0])
    expected = np.array([1e-3, -2e-3, 0.0]) * 25.0 * COUNT
    assert np.allclose(states.momentum[-1], expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("item", "message"),
    [
        (GravityGradient(CircularOrbit(0.0)), "orbital rate"),
        (GravityGradient(CircularOrbit(1e-3, inclination=np.nan)), "inclination"),
        (HarmonicTorque(-1.0), "rate of the disturbance"),
        (HarmonicTorque(1e-3, constant=np.array([0.0, np.nan, 0.0])), "constant disturbance"),
        (HarmonicTorque(1e-3, sine=np.zeros((2, 3))), "shapes"),
    ],
)
def test_an_environment_that_is_none_is_refused(item, message):
    plant = eqx.tree_at(lambda plant: plant.environment, craft(np.eye(3)), (item,))
    with pytest.raises(InputError, match=message):
        plant.check()
    with pytest.raises(InputError, match="external torque limit"):
        craft(np.eye(3), limit=-1.0).check()


def test_an_actuator_that_is_not_commanded_is_refused():
    plant = craft(np.eye(3))
    with pytest.raises(InputError, match="found no external_torque"):
        plant(plant.start(), WheelTorqueCommand(jnp.zeros(3)), 0.0, 1.0)
    with pytest.raises(InputError, match=r"found shape \(2,\)"):
        eqx.tree_at(lambda plant: plant.external_torque_limit, plant, np.ones(2)).check()
