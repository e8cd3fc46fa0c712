"""Wheels in speed loops on a body, against a reference with every event located."""

import importlib.util
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import check_parts
from gyrostat.simulation import simulate
from gyrostat.spacecraft import (
    SinusoidalMomentum,
    Spacecraft,
    SpeedDrivenSpacecraft,
    SpeedLoopSpacecraft,
    WheelSpeedCommand,
)
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

BODY = np.array([[400.0, 10.0, -5.0], [10.0, 500.0, 8.0], [-5.0, 8.0, 600.0]])
AXES = np.array([[1.0, 0.02, 0.0], [0.03, 1.0, 0.05]])
AXES = (AXES / np.linalg.norm(AXES, axis=1)[:, None]).T
ROTORS, COULOMB, LIMIT = np.array([0.45, 0.3]), np.array([0.9e-3, 2e-3]), 0.1
FREQUENCY, TICK = 2.0, 0.05
STILL = SinusoidalMomentum(jnp.zeros(3), 1e-3, jnp.zeros(3), jnp.array([0.1, -0.2, 0.15]))
MOVING = SinusoidalMomentum(
    jnp.array([0.2, 0.1, -0.15]), 1e-2, jnp.array([0.3, 1.0, -2.0]), jnp.array([0.05, 0.0, 0.1])
)
START = np.array([0.5, -0.5, 0.1, 0.7]) / np.linalg.norm([0.5, -0.5, 0.1, 0.7])


def spacecraft(coulomb=COULOMB, **limits):
    friction = ViscousCoulomb(viscous=jnp.zeros(2), coulomb=jnp.asarray(coulomb))
    fields = {"torque_limit": jnp.full(2, LIMIT), "momentum_limit": jnp.full(2, 30.0)} | limits
    wheels = WheelArray(
        axes=jnp.asarray(AXES), inertia=jnp.asarray(ROTORS), friction=friction, **fields
    )
    return Spacecraft(inertia=jnp.asarray(BODY), wheels=wheels)


def plant(momentum=STILL, **fields):
    return SpeedLoopSpacecraft(spacecraft(**fields), momentum)


def flown(body, start, speeds, period):
    """States and rates after each period."""
    return jax.tree.map(np.asarray, _flown(body, start, speeds, period))


@eqx.filter_jit
def _flown(body, start, speeds, period):
    def carry(state, now):
        number, speed = now
        state, _ = body(state, WheelSpeedCommand(speed), number * period, period)
        return state, (state, body.rate(state))

    number = jnp.arange(len(speeds), dtype=float)
    return jax.lax.scan(carry, start, (number, jnp.asarray(speeds)))[1]


@pytest.fixture(scope="module")
def reference():
    path = Path(__file__).with_name("gyrostat_reference.py")
    spec = importlib.util.spec_from_file_location("gyrostat_reference", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    still = 1e-9  # the reference tells Stribeck's level apart; here there is none
    return module.Reference(BODY, AXES, ROTORS, (np.zeros(2), COULOMB, COULOMB, still))


@pytest.fixture(scope="module")
def commands():
    # jumps beyond the torque limit, a creep through zero, rest
    time = 0.1 * np.arange(150)
    first = np.where(time < 5.0, 0.6, np.where(time < 9.0, 0.02 - 0.01 * (time - 5.0), 0.0))
    second = 0.03 * np.sin(1.3 * time) * ((time > 3.0) & (time < 10.0))
    return np.stack([first, second], axis=1)


class Loop:
    """The speed loop written apart."""

    def __init__(self, speed):
        self.point = np.array(speed)
        self.integral = self.point / FREQUENCY
        self.demand = np.zeros(2)

    def torque(self, speed, step):
        self.point = self.point + step
        miss = self.point - speed
        integral = self.integral + TICK * miss
        demand = ROTORS * (FREQUENCY**2 * integral + 2.0 * FREQUENCY * (0.5 * self.point - speed))
        torque = np.clip(demand, -LIMIT, LIMIT)
        winds = (demand - torque) * miss > 0.0
        self.integral = np.where(winds, self.integral, integral)
        self.demand = np.where(np.abs(demand) > np.abs(self.demand), demand, self.demand)
        return torque


def test_motion_is_that_of_a_reference_with_events(commands, reference):
    body = plant()
    start = body.start(attitude=START, wheel_speed=[0.05, 0.0])
    states, rates = flown(body, start, commands, 2.0 * TICK)
    y = np.concatenate([START, body.rate(start), start.wheel_speed])
    loop, rested, worst = Loop(y[7:]), 0, np.zeros(3)
    for k, command in enumerate(commands):
        step, loop.demand = (command - loop.point) / 2.0, np.zeros(2)
        for _ in range(2):
            y = reference.carry(y, loop.torque(y[7:], step), TICK)
        rested += np.sum(y[7:] == 0.0)
        assert np.array_equal(states.wheel_speed[k] == 0.0, y[7:] == 0.0)
        found = (states.attitude[k] - y[:4], rates[k] - y[4:7], states.wheel_speed[k] - y[7:])
        worst = np.maximum(worst, [np.max(np.abs(x)) for x in found])
        assert states.torque_demand[k] == pytest.approx(loop.demand, abs=1e-6)
    # a change of friction inside a tick moves the body by some c T^2 / 4J = 3e-9 rad
    assert np.all(worst < [1e-8, 1e-10, 5e-8])
    # the run has what it is for: rest, both senses, a demand beyond the limit
    assert rested > 20
    assert np.all(np.min(states.wheel_speed, axis=0) < 0.0)
    assert np.max(np.abs(states.torque_demand)) > 2.0 * LIMIT


def test_momentum_is_the_one_given_and_body_and_wheels_hold_it(commands):
    body = plant(MOVING)
    states, rates = flown(body, body.start(attitude=START), commands, 0.1)
    given = jax.jit(jax.vmap(MOVING))(0.1 * (1.0 + np.arange(len(commands))))
    assert np.allclose(states.momentum, given, atol=1e-12)
    rotors = (ROTORS * (states.wheel_speed + rates @ AXES)) @ AXES.T
    own = rates @ BODY + rotors
    length = np.linalg.norm(given, axis=1)
    assert np.allclose(np.linalg.norm(own, axis=1), length, rtol=1e-10)


def test_wheels_that_stick_leave_a_rigid_body_of_the_speed_driven_model():
    stuck = np.zeros((300, 2))
    body = plant(MOVING, coulomb=[1.0, 1.0])
    states, _ = flown(body, body.start(attitude=START), stuck, 0.1)
    assert np.all(states.wheel_speed == 0.0)
    driven = SpeedDrivenSpacecraft(spacecraft(torque_limit=jnp.full(2, jnp.inf)), MOVING)
    exact, _ = flown(driven, driven.start(attitude=START), stuck, 0.1)
    assert np.allclose(states.attitude[-1], exact.attitude[-1], atol=1e-9)


def test_error_falls_with_the_square_of_the_tick():
    # without friction and loop limits the only error is that of the midpoint rule
    ends = []
    for ticks in (1, 2, 4, 64):
        one = SpeedLoopSpacecraft(spacecraft(coulomb=[0.0, 0.0]), MOVING, 1e-9, ticks)
        state = one.start(attitude=START, wheel_speed=[40.0, -30.0])
        state = state._replace(integral=state.integral * 0.0)
        states, _ = flown(one, state, np.zeros((20, 2)), 2.0)
        ends.append(np.asarray(states.attitude[-1]))
    errors = [np.max(np.abs(end - ends[-1])) for end in ends[:-1]]
    assert 3.5 < errors[0] / errors[1] < 4.6
    assert 3.5 < errors[1] / errors[2] < 4.6


def test_wheels_keep_to_their_momentum():
    body = plant(momentum_limit=jnp.full(2, 0.3))
    states, _ = flown(body, body.start(), np.full((150, 2), 50.0), 0.1)
    momentum = ROTORS * np.asarray(states.wheel_speed)
    assert np.all(momentum <= 0.3 * (1.0 + 1e-4))
    assert np.all(momentum[-1] > 0.29)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"natural_frequency": 0.0}, "natural frequency"),
        ({"ticks": 0}, "ticks"),
        ({"momentum": SinusoidalMomentum(jnp.zeros(3), np.nan, jnp.zeros(3))}, "momentum freq"),
    ],
)
def test_bad_parameters_are_refused(change, words):
    fields = {"spacecraft": spacecraft(), "momentum": STILL} | change
    with pytest.raises(InputError, match=words):
        check_parts(SpeedLoopSpacecraft(**fields))


def test_viscous_friction_and_fast_loops_are_refused():
    friction = ViscousCoulomb(viscous=jnp.full(2, 1e-4), coulomb=jnp.zeros(2))
    wheels = eqx.tree_at(lambda w: w.friction, spacecraft().wheels, friction)
    with pytest.raises(InputError, match="no viscous part"):
        SpeedLoopSpacecraft(Spacecraft(jnp.asarray(BODY), wheels), STILL).check()
    with pytest.raises(InputError, match="unstable"):
        plant().check_period(1.0)
    plant().check_period(0.1)
    with pytest.raises(InputError, match="length"):
        plant().start(attitude=(1.0, 0.1, 0.0, 0.0))


class Holding(eqx.Module):
    """Controller that commands the same wheel speeds at every sample."""

    speed: np.ndarray

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        return memory, WheelSpeedCommand(jnp.asarray(self.speed))


class Sight(eqx.Module):
    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, state


@pytest.mark.parametrize("kind", [SpeedDrivenSpacecraft, SpeedLoopSpacecraft])
def test_wheels_keep_their_speeds_until_the_first_command_arrives(kind):
    """Commanded to keep them from the first sample on, they feel nothing of a delay."""
    speed = np.array([7.8, -3.0])
    body = kind(spacecraft(), STILL)
    prompt, late = (
        simulate(
            body,
            Holding(speed),
            Sight(),
            start=body.start(attitude=START, wheel_speed=speed),
            duration=6 * 0.1,
            control_period=0.1,
            command_delay=delay,
            engine="jax",
        )
        for delay in (0, 3)
    )
    np.testing.assert_array_equal(late.speed, np.broadcast_to(speed, (7, 2)))
    for name in ("wheel_speed", "attitude"):
        np.testing.assert_allclose(late[name], prompt[name], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(late.wheel_speed[-1], speed, rtol=1e-2)
