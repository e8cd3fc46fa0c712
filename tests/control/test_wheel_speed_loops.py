"""Speed loops on torque-driven wheels: the lag that theory gives, friction, limits."""

import dataclasses
from typing import NamedTuple

import numpy as np
import pytest

from gyrostat.control import WheelSpeedLoops
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

ROTORS = np.array([0.45, 0.3])
FREQUENCY, PERIOD, COUNT = 0.1, 0.05, 2000
SPEEDS = np.array([20.0, -8.0])
START = np.array([5.0, 0.0])


class Speeds(NamedTuple):
    speed: object


class Wanted:
    """The same speeds at every sample."""

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        return memory, Speeds(jnp.asarray(SPEEDS))


class Sample(NamedTuple):
    wheel_speed: object


def flown(limit, friction):
    """Speeds of wheels under the loops' torque less a constant friction, and the torques."""
    loops = WheelSpeedLoops(Wanted(), ROTORS, np.full(2, limit), FREQUENCY)

    def step(carry, _):
        memory, speed = carry
        memory, command = loops(memory, Sample(speed))
        speed = speed + PERIOD * (command.torque - friction) / ROTORS
        return (memory, speed), (speed, command.torque)

    start = (loops.start(PERIOD), jnp.asarray(START))
    found = jax.jit(lambda: jax.lax.scan(step, start, length=COUNT)[1])()
    return [np.array(part) for part in found]


def test_speed_follows_as_a_lag_of_the_first_order():
    speed, torque = flown(np.inf, 0.0)
    time = PERIOD * (1 + np.arange(COUNT))[:, None]
    expected = SPEEDS + (START - SPEEDS) * np.exp(-FREQUENCY * time)
    # the step of the sampled loop is late by half a period and more
    allowed = 2.0 * FREQUENCY * PERIOD * np.max(np.abs(SPEEDS - START))
    np.testing.assert_allclose(speed, expected, atol=allowed)
    np.testing.assert_allclose(torque[0], ROTORS * FREQUENCY * (SPEEDS - START), rtol=1e-2)


def test_friction_is_found_by_the_integral():
    speed, torque = flown(np.inf, np.array([0.02, -0.01]))
    np.testing.assert_allclose(speed[-1], SPEEDS, rtol=1e-2)
    np.testing.assert_allclose(torque[-1], [0.02, -0.01], rtol=0.05)


def test_a_limit_keeps_the_torque_and_winds_nothing_up():
    speed, torque = flown(0.2, 0.0)
    assert np.max(np.abs(torque)) == pytest.approx(0.2)
    assert np.max(speed[:, 0]) < 20.0 * 1.02
    np.testing.assert_allclose(speed[-1], SPEEDS, rtol=1e-2)


def test_what_cannot_work_is_refused():
    loops = WheelSpeedLoops(Wanted(), ROTORS, np.ones(2), FREQUENCY)
    loops.check_period(8.0)
    with pytest.raises(InputError, match=r"control period: found 8\.1 s, expected 8 s or less"):
        loops.check_period(8.1)
    with pytest.raises(InputError, match="natural frequency: found 0"):
        dataclasses.replace(loops, natural_frequency=0.0).check()
