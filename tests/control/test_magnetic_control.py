"""Detumbling and unloading by torque rods: energy, decay laws and the exact momentum equation."""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.codegen.simd import compiler
from gyrostat.control import AttitudeRegulator
from gyrostat.control.magnetic.b_cross import BCross
from gyrostat.control.magnetic.rod_unloading import RodUnloading
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_tuples import with_fields
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import (
    AddedSensors,
    Gyrostat,
    Spacecraft,
    SpacecraftSensor,
)
from gyrostat.spacecraft.actuators.torque_rods import TorqueRods
from gyrostat.spacecraft.sensors.magnetometer import Magnetometer
from gyrostat.spacecraft.sensors.sampled import Sampled
from gyrostat.wheel import WheelArray, orthogonal_axes
from tests.spacecraft import orbit_samples

DEGREE = np.pi / 180.0
ROTOR = 1e-4
WHEELS = WheelArray(orthogonal_axes(), np.full(3, ROTOR), np.full(3, 5e-3), np.full(3, 0.2))
TWELVE_UNITS = Spacecraft(np.diag([0.24, 0.22, 0.12]), WHEELS)
INCLINATION = 1.3
REST = np.zeros(3)
HELD = np.array([100.0, -50.0, 20.0])
NATIVE = pytest.mark.skipif(compiler() is None, reason="needs a C compiler")


@pytest.fixture(scope="module")
def orbit():
    return orbit_samples.environment(5700.0, inclination=INCLINATION)


@pytest.fixture(scope="module")
def fly(frictionless):
    """Closed loops with rods of 0.5 A·m² and an ideal magnetometer, one for each law; histories."""

    def flown(orbit, laws, wheel_speeds, *, count, period, rate=REST, engine="jax"):
        plant = Gyrostat(TWELVE_UNITS, actuators={"torque_rods": TorqueRods(orbit, 0.5)})
        return simulate(
            frictionless(plant),
            stack(laws),
            AddedSensors(SpacecraftSensor(plant), {"magnetometer": Sampled(Magnetometer(orbit))}),
            start=stack([plant.start(rate=rate, wheel_speed=speed) for speed in wheel_speeds]),
            duration=count * period,
            control_period=period,
            engine=engine,
            runs=len(laws),
        )

    return flown


@pytest.fixture(scope="module")
def detumbled(fly, orbit):
    """12U in 500 km, from 5 deg/s, for one orbit: wheels at rest, and wheels that hold a speed."""
    law = BCross.design(TWELVE_UNITS, orbit_samples.RATE, INCLINATION)
    laws = [law, replace(law, speed_gain=jnp.array(0.2))]
    rate = np.array([3.0, -3.0, 2.64]) * DEGREE
    return law, fly(orbit, laws, (np.zeros(3), HELD), count=2838, period=2.0, rate=rate)


def test_a_tumbling_body_comes_to_rest_within_one_orbit(detumbled):
    law, found = detumbled
    rate, found = orbit_samples.RATE, found.isel(run=0)
    assert law.gain == pytest.approx(2.0 * rate * (1.0 + np.sin(INCLINATION)) * (0.12 + ROTOR))
    speed = np.linalg.norm(found.rate.values, axis=1) / DEGREE
    assert speed[0] > 4.99
    assert found.time[np.argmax(speed < 0.1)] < 0.6 * 2.0 * np.pi / rate
    assert speed[-1] < 0.01
    assert np.abs(found.torque_rods.values).max() > 1.0  # beyond the limit of the rods


def test_the_kinetic_energy_never_increases(detumbled):
    found = detumbled[1].isel(run=0)
    rate, speed = found.rate.values, found.wheel_speed.values
    body = np.einsum("ti,ij,tj->t", rate, TWELVE_UNITS.inertia, rate)
    energy = 0.5 * (body + np.sum(ROTOR * (speed + rate) ** 2, axis=1))
    assert np.max(np.diff(energy)) <= 1e-12 * energy[0]


def test_wheels_hold_their_speed_while_the_body_is_detumbled(detumbled):
    found = detumbled[1].isel(run=1)
    np.testing.assert_allclose(found.wheel_speed[-1], HELD, atol=0.02)
    # the momentum of the wheels remains
    size = np.linalg.norm(found.momentum.values, axis=1)
    assert size[-1] == pytest.approx(ROTOR * np.linalg.norm(HELD), rel=0.02)


def test_the_rate_across_the_field_decays_geometrically():
    """A ball in a field that is constant in body axes: w_n = (1 - k T / J)^n w_0 across B."""
    inertia, gain, period, field = 0.2, 1e-3, 5.0, np.array([2e-5, -1e-5, 3e-5])
    law, along = BCross(TWELVE_UNITS, gain), field / np.linalg.norm(field)
    rate = first = np.array([0.01, 0.02, -0.005])
    for _ in range(50):
        _, command = law(law.start(period), WithField(field, rate))
        rate = rate + period / inertia * np.cross(command.torque_rods, field)
    across = first - along * (along @ first)
    expected = first - across + across * (1.0 - gain * period / inertia) ** 50
    np.testing.assert_allclose(rate, expected, rtol=1e-12)


GAIN, TARGET = 5e-4, np.array([0.005, 0.0, -0.002])


@pytest.fixture(scope="module")
def unloaded(fly, orbit):
    """With compensation, without, and with a limit; inertial pointing; and what flew them."""
    law = AttitudeRegulator(TWELVE_UNITS, np.array([1.0, 0.0, 0.0, 0.0]), torque_weight=1e4)
    laws = [
        RodUnloading(law.linear(), WHEELS, limit, GAIN, TARGET, compensation=share)
        for share, limit in ((1.0, 0.5), (0.0, 0.5), (1.0, 0.1))
    ]
    speed = np.array([100.0, -150.0, 75.0])
    flown = partial(fly, orbit, laws, period=2.0)
    return flown((speed,) * 3, count=2500), flown


def test_the_momentum_decays_by_the_law_of_the_field_on_the_orbit(unloaded, orbit):
    """dh/dt = -k (1 - b b') (h - h_t) with the field's direction b(t), integrated by SciPy."""
    found, at = unloaded[0].isel(run=0), jax.jit(lambda time: orbit.field(time))

    def slope(time, momentum):
        field = np.asarray(at(time))
        along, excess = field / np.linalg.norm(field), momentum - TARGET
        return -GAIN * (excess - along * (along @ excess))

    wheels = ROTOR * found.wheel_speed.values
    there = solve_ivp(slope, (0.0, 5000.0), wheels[0], t_eval=[2500.0, 5000.0], rtol=1e-8).y.T
    size = np.linalg.norm(wheels[0] - TARGET)
    assert np.abs(found.torque_rods.values).max() < 0.5
    np.testing.assert_allclose(wheels[[1250, 2500]], there, atol=3e-3 * size)
    assert np.linalg.norm(wheels[-1] - TARGET) < 0.3 * size


def test_compensation_removes_most_of_the_disturbance(unloaded):
    errors = np.abs(unloaded[0].attitude.values[:, :, 1:]).max((1, 2))
    assert errors[1] > 1e-4
    assert errors[0] < 0.05 * errors[1]


def test_a_limited_dipole_still_reduces_the_momentum(unloaded):
    found = unloaded[0].isel(run=2)
    size = np.linalg.norm(ROTOR * found.wheel_speed.values - TARGET, axis=1)
    assert np.abs(found.torque_rods).max() == pytest.approx(0.1)
    assert np.all(np.diff(size[::50]) < 0.0)


@NATIVE
def test_both_engines_agree(unloaded):
    """Over the first periods of turning bodies; for JAX by the program of the long flights."""
    speeds, rate = (HELD, -HELD, 0.5 * HELD), np.array([0.02, 0.01, -0.03])
    long, native = (
        unloaded[1](speeds, count=count, rate=rate, engine=engine)
        for engine, count in (("jax", 2500), ("native", 5))
    )
    for name in ("attitude", "momentum", "torque", "torque_rods", "magnetometer"):
        np.testing.assert_allclose(native[name], long[name][:, :6], rtol=1e-12, atol=1e-15)


class Measurement(NamedTuple):
    attitude: Any = np.array([1.0, 0.0, 0.0, 0.0])
    rate: Any = np.zeros(3)
    wheel_speed: Any = np.zeros(3)


class WithField(NamedTuple):
    magnetometer: Any = np.array([1e-5, 0.0, 3e-5])
    rate: Any = np.zeros(3)
    wheel_speed: Any = np.zeros(3)


def test_a_missing_magnetometer_and_two_laws_of_rods_are_refused():
    law = BCross(TWELVE_UNITS, 1e-4)
    wrapped = RodUnloading(law, WHEELS, 0.1)
    memory = law.start(1.0)
    for part, name in ((law, "detumbling"), (wrapped, "unloading")):
        with pytest.raises(InputError, match=f"{name}: found a measurement of attitude, rate, "):
            part(memory, Measurement())
    with pytest.raises(InputError, match="a controller that commands rods itself"):
        wrapped(memory, WithField())
    with pytest.raises(InputError, match="gain of the unloading: found 0"):
        RodUnloading(law, WHEELS, 0.1, gain=0.0).check()


class InMode:
    """B-cross law whose command has a mode."""

    def __init__(self, mode):
        self.mode = mode

    def __call__(self, memory, measurement):
        memory, command = BCross(TWELVE_UNITS, 1e-4)(memory, measurement)
        return memory, with_fields("Guided", command, {"mode": self.mode}, {"mode": "1"})


@pytest.mark.parametrize("mode", [0, 1])
def test_unloading_in_modes_adds_to_the_rods_of_a_law(mode):
    """The sum of both laws in a mode in which the unloading acts, the law alone in another."""
    measurement = WithField(rate=np.array([0.01, 0.0, 0.02]), wheel_speed=np.array([0.0, 9.0, 4.0]))
    memory = BCross(TWELVE_UNITS, 1e-4).start(1.0)
    alone = BCross(TWELVE_UNITS, 1e-4)(memory, measurement)[1].torque_rods
    excess = np.asarray(WHEELS.axes) @ (WHEELS.inertia * measurement.wheel_speed)
    field = measurement.magnetometer
    unloading = 1e-3 * np.cross(excess, field) / (field @ field)
    acts = np.array([0.0, 1.0])
    both = RodUnloading(InMode(mode), WHEELS, 0.1, in_modes=acts)(memory, measurement)[1]
    np.testing.assert_allclose(both.torque_rods, alone + acts[mode] * unloading, rtol=1e-12)
    assert np.any(unloading != 0.0)


@pytest.mark.parametrize("mode", [0, 1])
def test_the_sum_of_the_law_and_the_unloading_is_within_the_limit(mode):
    """One rod of the law is beyond it; the wheels compensate what the unloading changes in it."""
    limit = 0.1
    measurement = WithField(
        rate=np.array([0.0, -0.05, 0.04]), wheel_speed=np.array([9e2, -9e2, 4e2])
    )
    memory = BCross(TWELVE_UNITS, 1e-4).start(1.0)
    law = BCross(TWELVE_UNITS, 1e-4)(memory, measurement)[1]
    acts = np.array([0.0, 1.0])
    both = RodUnloading(InMode(mode), WHEELS, limit, in_modes=acts, compensation=1.0)
    command = both(memory, measurement)[1]
    alone, total = np.asarray(law.torque_rods), np.asarray(command.torque_rods)
    assert np.max(np.abs(alone)) > limit
    assert np.all(np.abs(total) <= limit) if mode else np.all(total == alone)
    # the rods give no more than the limit, with and without the unloading
    changed = np.clip(total, -limit, limit) - np.clip(alone, -limit, limit)
    assert np.any(changed != 0.0) == bool(mode)
    rods = np.cross(changed, measurement.magnetometer)
    wheels = np.asarray(WHEELS.axes) @ np.asarray(command.torque - law.torque)
    np.testing.assert_allclose(wheels, rods, atol=1e-18)
