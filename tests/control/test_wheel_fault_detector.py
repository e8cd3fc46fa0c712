"""The watch over the wheels: what it says of torques that act late, by the books of a rotor."""

import dataclasses

import numpy as np
import pytest

from gyrostat.control import (
    AttitudeTargets,
    MomentumUnloading,
    WheelArrayControl,
    WheelFaultDetector,
)
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import simulate
from gyrostat.spacecraft import Gyrostat, Spacecraft, SpacecraftMeasurement, SpacecraftSensor
from gyrostat.wheel import WheelArray, pyramid_axes

PERIOD, COUNT, DELAY = 0.25, 80, 3
DRAG = np.array([2e-5, 0.0])
TORQUE = 1e-3 * np.sign(np.random.default_rng(3).normal(size=(COUNT, 2)))


def watched(delay):
    """The watch's opinions of two rotors with drag whose commands act three periods late."""
    detector = WheelFaultDetector(failure_torque=2e-4, failure_time=2.0, delay=delay)
    acted = np.concatenate([np.zeros((DELAY, 2)), TORQUE[: COUNT - DELAY]])
    momentum = np.cumsum(PERIOD * (acted - DRAG), axis=0)  # at the samples after the first
    momentum = np.concatenate([np.zeros((1, 2)), momentum[:-1]])
    known, limit = jnp.ones(2, bool), jnp.full(2, 1e-3)

    def step(memory, sample):
        time, momentum, torque = sample
        memory = detector(memory, momentum, known, limit, time, PERIOD)
        memory = detector.commanded(memory, torque)
        return memory, (memory.lost, memory.drag, memory.works)

    samples = (PERIOD * np.arange(COUNT), jnp.asarray(momentum), jnp.asarray(TORQUE))
    return jax.tree.map(
        np.array, jax.jit(lambda: jax.lax.scan(step, detector.start(2), samples))()[1]
    )


def test_a_delay_that_is_told_is_no_loss():
    """The low passes of a constant, in closed form."""
    lost, drag, works = watched(DELAY)
    assert np.all(works)
    samples = np.arange(COUNT)[:, None]
    for found, constant in ((lost, 2.0), (drag, 10.0)):
        share = PERIOD / (constant + PERIOD)
        expected = DRAG * (1.0 - (1.0 - share) ** samples)
        np.testing.assert_allclose(found, expected, atol=1e-15)


def test_a_delay_that_is_not_told_looks_like_a_failure():
    assert not np.all(watched(0)[2])


def test_drag_is_compensated_up_to_half_of_the_torque_limit():
    """Rotors that lose a tenth, four tenths and all of their limit, for ever."""
    detector, limit = WheelFaultDetector(drag_time=1.0), np.array([2e-3, 1e-3, 3e-3])
    lost = np.array([2e-4, -4e-4, 3e-3])
    memory = detector.start(3)
    for k in range(60):
        momentum = -PERIOD * k * lost
        memory = detector(memory, momentum, np.ones(3, bool), limit, PERIOD * k, PERIOD)
    np.testing.assert_allclose(memory.drag, [2e-4, -4e-4, 1.5e-3], rtol=1e-5)


AXES = pyramid_axes(4)
WHEELS = WheelArray(AXES, np.full(4, 2e-5), np.full(4, 3e-3), np.full(4, 1.5e-2))
CONTROL = WheelArrayControl(
    Spacecraft(np.diag([0.12, 0.10, 0.06]), WHEELS),
    AttitudeTargets.hold([np.cos(0.3), 0.0, 0.0, np.sin(0.3)]),
    torque_time=2.0,
    unloading=MomentumUnloading(np.full(3, 2e-5), 0.05),
    detector=WheelFaultDetector(failure_torque=1e-6, failure_time=1.0, delay=2),
)


def test_a_slew_with_late_commands_leaves_all_wheels_at_work(frictionless):
    plant = Gyrostat(CONTROL.spacecraft)
    flown = simulate(
        frictionless(plant),
        dataclasses.replace(CONTROL, unloading=None),
        SpacecraftSensor(plant),
        start=plant.start(),
        duration=40.0,
        control_period=0.1,
        command_delay=2,
    )
    assert np.max(np.abs(flown.torque)) > 1e-4
    assert np.all(flown.works)
    np.testing.assert_allclose(flown.target, [[np.cos(0.3), 0.0, 0.0, np.sin(0.3)]] * 401)


def test_an_external_torque_that_acts_late_is_no_unknown_one():
    """A body held at rest, whose momentum changes by what the actuator was told two samples ago."""
    still, known = jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.ones(4, bool)

    def step(carry, _):
        memory, momentum, under_way = carry
        wheels = jnp.linalg.pinv(AXES) @ momentum
        speed = wheels / CONTROL.spacecraft.wheels.inertia
        sample = SpacecraftMeasurement(still, jnp.zeros(3), speed, known)
        memory, command = CONTROL(memory, sample)
        momentum = momentum + PERIOD * under_way[0]
        under_way = jnp.stack([under_way[1], command.external_torque])
        return (memory, momentum, under_way), (memory.unknown.torque, momentum)

    start = (CONTROL.start(PERIOD), jnp.array([1e-3, -2e-3, 1e-3]), jnp.zeros((2, 3)))
    unknown, momentum = jax.jit(lambda: jax.lax.scan(step, start, length=COUNT)[1])()
    assert np.linalg.norm(momentum[-1]) < 0.8 * np.linalg.norm(momentum[0])
    np.testing.assert_allclose(unknown, 0.0, atol=1e-15)


def test_a_delay_below_none_is_refused():
    with pytest.raises(InputError, match="command delay: found -1"):
        WheelFaultDetector(delay=-1).check()
