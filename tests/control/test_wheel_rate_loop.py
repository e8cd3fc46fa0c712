"""The rate loop of wheels: damping, drag, limits."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import WheelRateLoop
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import SpacecraftMeasurement

AXES = np.array([[1.0, 0.0, 0.6], [0.0, 1.0, 0.8], [0.0, 0.0, 0.0]])
WORKING = AXES * [1.0, 1.0, 0.0]
LOOP = WheelRateLoop(
    inertia=jnp.diag(jnp.array([8.0, 12.0, 16.0])),
    axes=jnp.asarray(WORKING),
    allocation=jnp.asarray(np.linalg.pinv(WORKING)),
    rotor_inertia=jnp.array([0.01, 0.01, 0.0]),
    torque_limit=0.1 * jnp.ones(3),
    momentum_limit=3.0 * jnp.ones(3),
)
STILL = np.zeros(3)
step = eqx.filter_jit(LOOP)


def measured(rate, momentum):
    return SpacecraftMeasurement(
        np.array([1.0, 0.0, 0.0, 0.0]),
        np.asarray(rate),
        np.asarray(momentum) / 0.01,
        np.ones(3, dtype=bool),
    )


def test_takes_energy_from_a_body_that_tumbles():
    random = np.random.default_rng(3)
    seen = 0
    for _ in range(50):
        rate, carried = random.uniform(-0.5, 0.5, 3), random.uniform(-2.0, 2.0, 3) * [1, 1, 0]
        momentum = LOOP.inertia @ rate + WORKING @ carried
        if np.abs(np.cross(momentum, rate)[:2]).max() < 0.45:
            continue
        seen += 1
        _, command = LOOP(LOOP.start(0.5), measured(rate, carried), momentum, STILL, STILL)
        assert rate @ WORKING @ command.torque > 0.0
        assert np.abs(command.torque).max() <= 0.1
        assert command.torque[2] == 0.0
    assert seen > 20


def test_wheels_turn_their_momentum_with_the_body():
    # at the wanted rate the wheels need what keeps their momentum fixed in space, no more
    rate, carried = jnp.array([0.0, 0.0, 0.02]), jnp.array([1.0, -2.0, 0.0])
    momentum = LOOP.inertia @ rate + jnp.asarray(WORKING) @ carried
    _, command = LOOP(LOOP.start(0.5), measured(rate, carried), momentum, rate, STILL)
    np.testing.assert_allclose(command.torque, [-2.0 * 0.02, -1.0 * 0.02, 0.0], atol=1e-12)


def test_finds_the_drag():
    drag, period = np.array([0.004, -0.002, 0.0]), 0.5
    # no weak types, so that it is compiled once
    memory = jax.tree.map(np.asarray, LOOP.start(period))
    momentum = np.array([1.0, -1.0, 0.0])
    for _ in range(400):
        memory, command = step(memory, measured(STILL, momentum), STILL, STILL, STILL)
        momentum = momentum + (np.asarray(command.torque) - drag) * period
    np.testing.assert_allclose(memory.drag, drag, atol=1e-9)


def test_never_asks_for_momentum_that_a_wheel_has_not_left():
    carried = jnp.array([2.98, 0.0, 0.0])
    wanted = jnp.array([-0.1, 0.0, 0.0])
    memory = LOOP.start(0.5)
    _, command = LOOP(
        memory, measured(STILL, carried), jnp.asarray(WORKING) @ carried, wanted, STILL
    )
    assert 0.0 < command.torque[0] * 0.5 <= 0.02 + 1e-12


def test_room_is_how_far_the_first_wheel_goes():
    up, down = LOOP.room(jnp.array([2.0, -1.0, 0.0]), jnp.array([0.5, 0.1, 7.0]))
    assert up == pytest.approx(2.0)
    assert down == pytest.approx(10.0)


def test_refuses_gains_that_are_none():
    with pytest.raises(InputError, match="rate gain"):
        WheelRateLoop(*[getattr(LOOP, name) for name in list(LOOP.__dict__)[:6]], gain=0.0).check()


def test_drag_is_compensated_up_to_half_of_the_torque_limit():
    drag, period = np.array([0.03, -0.08, 0.0]), 0.5
    memory, momentum = LOOP.start(period), np.zeros(3)
    for _ in range(300):
        total = jnp.asarray(WORKING @ momentum)
        memory, command = step(memory, measured(STILL, momentum), total, STILL, STILL)
        momentum = momentum + (np.asarray(command.torque) - drag) * period
    np.testing.assert_allclose(memory.drag, [0.03, -0.05, 0.0], rtol=1e-6)


def test_a_delay_that_is_known_is_no_drag():
    loop = dataclasses.replace(LOOP, delay=2)
    memory, period = loop.start(0.5), 0.5
    momentum, sent = np.array([1.0, -1.0, 0.0]), [np.zeros(3)] * 2
    seen = 0.0
    for step in range(20):
        wanted = jnp.array([0.01 * np.sin(step), 0.01 * np.cos(step), 0.0])
        total = LOOP.inertia @ wanted + jnp.asarray(WORKING) @ momentum
        memory, command = loop(memory, measured(STILL, momentum), total, wanted, STILL)
        assert np.abs(memory.drag).max() < 1e-15
        sent.append(np.asarray(command.torque))
        seen = max(seen, np.abs(sent[-1]).max())
        momentum = momentum + period * sent.pop(0)
    assert seen > 1e-3
