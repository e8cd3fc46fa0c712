"""Wear of wheels: the estimate against the response of a first-order lag, by hand."""

from typing import NamedTuple

import numpy as np
import pytest

from gyrostat.control import (
    EstimatingFeedForward,
    FrictionFeedForward,
    FrictionFilterFeedForward,
    WheelWear,
)
from gyrostat.control.measured import with_wheel_friction
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionTorqueFilter
from gyrostat.spacecraft import Spacecraft, SpacecraftMeasurement, WheelTorqueCommand
from gyrostat.wheel import WheelArray, pyramid_axes
from gyrostat.wheel.friction import ViscousCoulomb

MODEL = ViscousCoulomb(viscous=1e-7, coulomb=2e-5)
SPEED = np.array([100.0, -100.0, 100.0, 100.0, 0.0])
OWN = 3e-5
"""Friction of the model at 100 rad/s."""


def test_the_estimate_goes_to_the_ratio_of_the_frictions_like_a_lag():
    """Wheels with 3 and 2 times the friction, half of it, one that is not measured, one at rest."""
    wear = WheelWear(np.array([1.0, 1.0, 2.0, 5.0, 1.0]), time=20.0)
    friction = np.array([3 * OWN, -2 * OWN, 0.5 * OWN, 3 * OWN, 4e-5])
    used = np.array([True, True, True, False, True])
    found, period = np.asarray(wear.start(5)), 0.5
    step = jax.jit(lambda found: wear(found, friction, SPEED, MODEL, used, period))
    for _ in range(60):
        found = step(found)
    left = (20.0 / 20.5) ** 60
    expected = [3.0 - 2.0 * left, 2.0 - left, 1.0 + left, 5.0, 2.0 - left]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_without_time_constant_or_model_the_given_wear_remains():
    none = ViscousCoulomb(0.0, 0.0)
    friction, used = np.full(5, 1e-3), np.ones(5, bool)
    given, lagging = WheelWear(3.0), WheelWear(3.0, time=20.0)

    @jax.jit
    def found():
        return (
            given(given.start(5), friction, SPEED, MODEL, used, 0.5),
            lagging(lagging.start(5), friction, SPEED, none, used, 0.5),
        )

    assert np.all(np.array(found()) == 3.0)


def test_wear_of_no_size_is_refused():
    with pytest.raises(InputError, match="wear of a wheel: found 0"):
        WheelWear(np.array([1.0, 0.0])).check()
    with pytest.raises(InputError, match="wear time"):
        WheelWear(time=0.0).check()


def test_the_friction_of_compensators_in_each_other_adds_up():
    sensed = SpacecraftMeasurement(
        jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.zeros(3), jnp.asarray(SPEED), jnp.ones(5, bool)
    )
    once = with_wheel_friction(sensed, jnp.full(5, 1e-5))
    twice = with_wheel_friction(once, jnp.full(5, 2e-5))
    assert once[:4] == sensed
    np.testing.assert_allclose(twice.wheel_friction, 3e-5)


class Heard(NamedTuple):
    """Controller that demands a constant torque and keeps the friction that it is told."""

    def start(self, period):
        return jnp.zeros(4)

    def __call__(self, memory, measurement):
        return measurement.wheel_friction, WheelTorqueCommand(jnp.full(4, 1e-7))


WHEELS = WheelArray(pyramid_axes(4), np.full(4, 2e-5), np.full(4, 1e-3), friction=MODEL)
CRAFT = Spacecraft(0.1 * np.eye(3), WHEELS)
COMPENSATORS = {
    "model": lambda: FrictionFeedForward(Heard(), MODEL, np.full(4, 1e-3), 1.0, 0.8),
    "filter": lambda: FrictionFilterFeedForward(
        Heard(), FrictionTorqueFilter(1e-6, 3e-6, 1e-4), WHEELS.axes, *2 * (np.full(4, 2e-5),)
    ),
    "estimating": lambda: EstimatingFeedForward.tune(
        Heard(), CRAFT, speed_sigma=0.1, rate_sigma=1e-5, period=0.25
    ),
}


@pytest.mark.parametrize("name", COMPENSATORS)
def test_a_compensator_tells_its_controller_the_friction(name):
    """Rotors with twice the friction of the model: an estimate finds it, a model does not."""
    compensator, period = COMPENSATORS[name](), 0.25
    step = jax.jit(lambda memory, sensed: compensator(memory, sensed))
    speed, memory = np.array([100.0, -100.0, 120.0, -120.0]), compensator.start(period)
    for _ in range(200):
        sensed = SpacecraftMeasurement(
            jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.zeros(3), jnp.asarray(speed), jnp.ones(4, bool)
        )
        memory, command = step(memory, sensed)
        model = np.sign(speed) * 2e-5 + 1e-7 * speed
        speed = speed + period / 2e-5 * (np.asarray(command.torque) - 2.0 * model)
    told = memory if name == "model" else memory.controller
    np.testing.assert_allclose(told, (0.8 if name == "model" else 2.0) * model, rtol=0.03)
