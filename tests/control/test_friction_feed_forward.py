"""Friction added to commanded wheel torques, against the friction law by hand."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from gyrostat.control import FrictionFeedForward
from gyrostat.core.errors import InputError
from gyrostat.spacecraft import WheelTorqueCommand
from gyrostat.wheel.friction import Stribeck

VISCOUS, COULOMB, STATIC, SPEED = 1e-7, 2e-5, 3e-5, 2.0
INERTIA = np.full(4, 2e-5)


class Speeds(NamedTuple):
    """Measurement."""

    wheel_speed: Any


class Demands:
    """A controller that always demands the same."""

    def __init__(self, torque):
        self.torque = np.array(torque)

    def start(self, period):
        return period

    def __call__(self, memory, measurement):
        return memory, WheelTorqueCommand(self.torque)


def told(demanded, speed, **options):
    values = {"band": 1.0, **options}
    part = FrictionFeedForward(
        Demands(demanded), Stribeck(VISCOUS, COULOMB, STATIC, SPEED), 1e-3, **values
    )
    part.check()
    measured = Speeds(np.array(speed))
    memory, command = part(part.start(0.25), measured)
    assert memory == 0.25
    return np.asarray(command.torque)


def friction(speed):
    excess = (STATIC - COULOMB) * np.exp(-((speed / SPEED) ** 2))
    return VISCOUS * speed + np.sign(speed) * (COULOMB + excess)


def test_a_turning_wheel_gets_what_its_friction_takes():
    speed, demanded = np.array([3.0, -3.0, 50.0, -50.0]), np.array([1e-5, 1e-5, -4e-4, -1e-9])
    np.testing.assert_allclose(told(demanded, speed) - demanded, friction(speed), rtol=1e-12)
    half = told(demanded, speed, share=0.5) - demanded
    np.testing.assert_allclose(half, 0.5 * friction(speed), rtol=1e-12)


def test_near_rest_it_gets_its_breakaway_torque_in_the_sense_that_is_demanded():
    # fully from a fifth of it on, and in proportion below
    demanded = np.array([1e-5, -1e-5, 3e-6, -3e-6])
    expected = np.array([STATIC, -STATIC, 0.5 * STATIC, -0.5 * STATIC])
    np.testing.assert_allclose(told(demanded, [0.9, 0.9, -0.9, 0.0]) - demanded, expected)


def test_a_wheel_left_alone_stays_so_and_no_limit_is_passed():
    found = told([0.0, 0.0, 0.99e-3, -0.999e-3], [80.0, 0.0, 80.0, -80.0])
    np.testing.assert_array_equal(found, [0.0, 0.0, 1e-3, -1e-3])


def test_sizes_that_are_none_are_refused():
    with pytest.raises(InputError, match="speed band of the compensator: found 0"):
        told([0.0] * 4, [0.0] * 4, band=0.0)
    with pytest.raises(InputError, match="share of the compensator: found -1"):
        told([0.0] * 4, [0.0] * 4, share=-1.0)
