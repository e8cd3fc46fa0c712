"""Momentum control against the paper's closed forms, with gaps, and what it refuses."""

from typing import Any

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import (
    FrictionScaleControl,
    FrictionTorqueControl,
    ProportionalMomentumControl,
)
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import FrictionScaleFilter, FrictionTorqueFilter
from gyrostat.papers.moreira_lopes_kuga.bench_wheel import (
    BenchWheel,
    MomentumMeasurement,
    MomentumSensor,
    TorqueCommand,
)
from gyrostat.simulation import simulate
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

J, GAIN, PERIOD = 0.02, 0.05, 2.0
CURVE = Stribeck(viscous=1e-4, coulomb=5e-3, static=6e-3, stribeck_speed=1.0)
SENSOR = MomentumSensor(J, 1e-3)
FILTER = FrictionTorqueFilter(1e-3, 1e-3, 0.1)


def reference(time):
    return jnp.where(time < 100.0, 0.5, -0.3)


def scale_control(motor_constant=1.0, gain=GAIN):
    wheel = Wheel(J, motor_constant, CURVE)
    return FrictionScaleControl(FrictionScaleFilter(wheel, 1e-3 / J, 1e-4), gain, reference)


def flown(controller, sensor=SENSOR):
    plant = BenchWheel(Wheel(J, 1.0, CURVE))
    return simulate(
        plant, controller, sensor, start=plant.start(), duration=200.0, control_period=PERIOD
    )


def test_the_prediction_is_that_of_the_paper():
    """Eq. (11): the momentum error fades with gamma, whatever the friction is taken to be."""
    control = FrictionTorqueControl(FILTER, GAIN, reference)
    memory = control.start(PERIOD)
    memory = memory._replace(estimate=FILTER.start(0.2, 0.017))
    memory, command = control(memory, MomentumMeasurement(jnp.array(0.21)))
    momentum, friction = float(command.estimated_momentum), float(command.estimated_friction)
    expected = (momentum - 0.5) * np.exp(-GAIN * PERIOD) + 0.5
    assert float(memory.estimate.momentum) == pytest.approx(expected, rel=1e-12)
    assert float(memory.estimate.friction) == pytest.approx(friction, rel=1e-12)
    assert float(command.torque) == friction
    assert float(command.fading_torque) == pytest.approx(-GAIN * (momentum - 0.5), rel=1e-12)


def test_the_commanded_torque_does_what_the_prediction_says():
    """Eqs. (15), (16) on a wheel whose friction is the estimated one, and constant."""
    plant = BenchWheel(Wheel(J, 1.0, ViscousCoulomb(0.0, 0.017)))
    control = FrictionTorqueControl(FILTER, GAIN, reference)
    memory = control.start(PERIOD)._replace(estimate=FILTER.start(0.2, 0.017))
    memory, command = control(memory, MomentumMeasurement(jnp.array(0.2)))
    torque = TorqueCommand(command.torque, command.fading_torque, command.fading_rate)
    state, _ = plant(plant.start(speed=0.2 / J), torque, 0.0, PERIOD)
    assert J * float(state.speed) == pytest.approx(float(memory.estimate.momentum), rel=1e-7)


def test_a_motor_constant_changes_nothing():
    """The command is a torque."""
    every = Gappy(-1.0)
    found, expected = flown(scale_control(0.0228), every), flown(scale_control(), every)
    np.testing.assert_allclose(found.momentum, expected.momentum, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.torque, expected.torque, rtol=1e-9, atol=1e-12)
    assert float(abs(found.momentum[-1] + 0.3)) < 0.01


class Gappy(eqx.Module):
    """A sensor that misses every third sample; with a remainder of -1, none."""

    remainder: Any = 2.0

    def start(self, state, period):
        return jnp.array(0)

    def __call__(self, memory, state, key):
        _, measurement = SENSOR((), state, key)
        value = jnp.where(memory % 3 == self.remainder, jnp.nan, measurement.momentum)
        return memory + 1, MomentumMeasurement(value)


@pytest.mark.parametrize(
    "make", [lambda: FrictionTorqueControl(FILTER, GAIN, reference), scale_control]
)
def test_gaps_are_flown_through(make):
    found = flown(make(), Gappy())
    assert np.isnan(found.measured_momentum).any()
    assert np.all(np.isfinite(found.torque))
    assert int(found.status) == 0
    assert float(abs(found.momentum[49] - 0.5)) < 0.05
    np.testing.assert_array_equal(found.innovation_sigma[2::3], 0.0)


@pytest.mark.parametrize("gain", [-0.1, np.nan, np.inf])
@pytest.mark.parametrize("make", [lambda g: FrictionTorqueControl(FILTER, g, reference), None])
def test_a_gain_that_drives_away_is_refused(gain, make):
    control = make(gain) if make else scale_control(gain=gain)
    with pytest.raises(InputError, match="momentum gain: found"):
        control.check()


def test_without_an_estimate_a_missing_measurement_is_said():
    with pytest.raises(InputError, match="ProportionalMomentumControl: found a command that is"):
        flown(ProportionalMomentumControl(GAIN, reference), Gappy())
