"""Actuators with a state: a lag against its closed form and against an adaptive integrator."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.codegen.simd import compiler
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body
from gyrostat.simulation import Status, simulate
from gyrostat.spacecraft import (
    ChangingPlant,
    DrivenGyrostat,
    Gyrostat,
    Imbalance,
    ImbalancedGyrostat,
    PlantChange,
    Spacecraft,
    SpacecraftSensor,
)
from gyrostat.wheel import Driver, WheelArray, orthogonal_axes
from gyrostat.wheel.friction import ViscousCoulomb

PERIOD, COUNT, LAG = 0.25, 6, 0.0625
WHEELS = WheelArray(
    *(orthogonal_axes(), np.full(3, 2e-5), np.full(3, 1e-2), np.full(3, 0.1)),
    ViscousCoulomb(np.full(3, 1e-6), np.full(3, 1e-5)),
)
FRICTIONLESS = ViscousCoulomb(np.zeros(3), np.zeros(3))
CRAFT = Spacecraft(np.array([[0.02, 1e-3, 0.0], [1e-3, 0.03, 0.0], [0.0, 0.0, 0.04]]), WHEELS)
MOTION = {"attitude": (0.6, 0.0, 0.8, 0.0), "rate": (0.2, -0.1, 0.3), "wheel_speed": 40.0}
ALONG = np.array([0.1, -0.2, 0.3])
COMMANDS = np.array([2e-3, -1e-3, 3e-3, 0.0, 1e-3, 1e-3])
NATIVE = pytest.mark.skipif(compiler() is None, reason="needs a C compiler")
FASTEST = "jax" if compiler() is None else "native"
"""Engine where the plant is tested: XLA compiles it for seconds."""


class Command(NamedTuple):
    torque: Any
    valve: Any


class Schedule(eqx.Module):
    """The commands, one after the other."""

    def start(self, period):
        return jnp.zeros((), int)

    def __call__(self, memory, measurement):
        return memory + 1, Command(jnp.zeros(3), jnp.asarray(COMMANDS)[memory % COUNT])


class Opening(NamedTuple):
    opened: Any
    impulse: Any


class Valve(eqx.Module):
    """First-order lag: torque along an inertial or a body axis."""

    share: Any = 0.1
    is_inertial: bool = eqx.field(static=True, default=True)

    @property
    def longest_step(self):
        return self.share * LAG

    def start(self):
        return Opening(jnp.zeros(()), jnp.zeros(()))

    def advanced(self, state, value, elapsed):
        opened = value + (state.opened - value) * jnp.exp(-elapsed / LAG)
        return Opening(opened, state.impulse + value * elapsed - LAG * (opened - state.opened))

    def __call__(self, state, value, attitude, time):
        torque = state.opened * jnp.asarray(ALONG)
        return to_body(attitude, torque) if self.is_inertial else torque


def lagged(commands):
    """Opening and impulse at the sample times, in closed form."""
    opened, impulse = [0.0], [0.0]
    for value in commands:
        decay = np.exp(-PERIOD / LAG)
        impulse.append(impulse[-1] + value * PERIOD + LAG * (opened[-1] - value) * (1.0 - decay))
        opened.append(value + (opened[-1] - value) * decay)
    return np.array(opened), np.array(impulse)


def fly(plant, **options):
    sensor = SpacecraftSensor(plant)
    given = {"duration": PERIOD * COUNT, "control_period": PERIOD, **options}
    return simulate(plant, Schedule(), sensor, start=plant.start(**MOTION), **given)


def momentum_gained(run):
    return run.momentum.values - run.momentum.values[0]


@pytest.mark.parametrize(("delay", "engine"), [(0, "jax"), pytest.param(2, "native", marks=NATIVE)])
def test_state_and_momentum_are_those_of_the_lag(delay, engine):
    run = fly(Gyrostat(CRAFT, actuators={"valve": Valve()}), command_delay=delay, engine=engine)
    opened, impulse = lagged([0.0] * delay + [*COMMANDS[: COUNT - delay]])
    np.testing.assert_allclose(run.actuator_valve_opened, opened, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(run.actuator_valve_impulse, impulse, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(momentum_gained(run), np.outer(impulse, ALONG), rtol=0, atol=3e-11)


def test_the_momentum_converges_with_the_fourth_power_of_the_step():
    errors = []
    for share in (0.5, 0.25):
        run = fly(Gyrostat(CRAFT, actuators={"valve": Valve(share)}))
        errors.append(np.linalg.norm(momentum_gained(run)[1] - lagged(COMMANDS[:1])[1][1] * ALONG))
    assert 15.5 < errors[0] / errors[1] < 16.5
    assert errors[0] > 1e-9  # else nothing was measured


def turned(plant):
    return eqx.tree_at(lambda p: p.gyrostat.spacecraft.inertia, plant, CRAFT.inertia * 1.2)


def test_plants_around_it_and_events_within_a_period_change_nothing():
    valve = Gyrostat(CRAFT, actuators={"valve": Valve()})
    imbalance = Imbalance(np.full(3, 1e-6), np.full(3, 1e-8), 0.05 * np.eye(3))
    driven = DrivenGyrostat(ImbalancedGyrostat(valve, imbalance), Driver(0.02, 1.0), 0.05)
    heavier = DrivenGyrostat(valve, Driver(0.02, 1.0), 0.05)
    changing = ChangingPlant(heavier, (PlantChange("heavier", 0.4 * PERIOD, turned),))
    expected = lagged(COMMANDS)
    for plant in (driven, changing):
        run = fly(plant, engine=FASTEST)
        np.testing.assert_allclose(run.actuator_valve_opened, expected[0], rtol=1e-12, atol=1e-18)
        gained = np.outer(expected[1], ALONG)
        np.testing.assert_allclose(momentum_gained(run), gained, rtol=0, atol=3e-11)


def test_a_torque_in_body_axes_turns_the_body_as_an_adaptive_integrator_says():
    wheels = eqx.tree_at(lambda w: w.friction, CRAFT.wheels, FRICTIONLESS)
    craft = Spacecraft(CRAFT.inertia, wheels)
    plant = Gyrostat(craft, actuators={"valve": Valve(0.05, False)})
    start = plant.start(**MOTION)
    axes, inertia = np.asarray(wheels.axes), np.asarray(CRAFT.inertia)
    rotors = np.asarray(wheels.inertia) * (start.wheel_speed + axes.T @ np.array(MOTION["rate"]))

    def motion(time, state, value):
        attitude, rate, opened = state[:4], state[4:7], state[7]
        w, x, y, z = attitude
        p, q, r = rate
        turning = [-x * p - y * q - z * r, w * p + y * r - z * q]
        turning += [w * q + z * p - x * r, w * r + x * q - y * p]
        torque = opened * ALONG - np.cross(rate, inertia @ rate + axes @ rotors)
        change = np.linalg.solve(inertia, torque)
        return np.concatenate([0.5 * np.array(turning), change, [(value - opened) / LAG]])

    state = np.concatenate([MOTION["attitude"], MOTION["rate"], [0.0]])
    states = [state]
    for value in COMMANDS:
        found = solve_ivp(
            *(motion, (0.0, PERIOD), state), args=(value,), method="DOP853", rtol=1e-12, atol=1e-14
        )
        state = found.y[:, -1]
        states.append(state)
    run = fly(plant, engine=FASTEST)
    expected = np.array(states)
    np.testing.assert_allclose(run.rate, expected[:, 4:7], rtol=0, atol=1e-8)
    np.testing.assert_allclose(run.attitude, expected[:, :4], rtol=0, atol=1e-8)
    assert np.ptp(run.rate.values[:, 0]) > 0.03


def test_a_step_that_is_too_short_for_the_period_ends_the_run():
    run = fly(Gyrostat(CRAFT, actuators={"valve": Valve(1e-3)}))  # 4167 parts
    assert run.status == Status.UNRESOLVED


def test_a_state_without_that_of_the_actuator_is_refused():
    plant = Gyrostat(CRAFT, actuators={"valve": Valve()})
    start = plant.start(**MOTION)
    with pytest.raises(InputError, match="found the states of none, expected those of valve"):
        plant.check_state(start._replace(actuators=None))
    with pytest.raises(InputError, match="found the states of valve, expected those of none"):
        Gyrostat(CRAFT).check_state(start)
