"""The estimating compensator on the paper's table: noise, wrong models, rest."""

from typing import Any

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import DynamicModelCompensator, EstimatingCompensator
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import AirBearingTable, Gyro, TableMeasurement, TableSensors
from gyrostat.wheel import PulseTachometer, Tachometer, Wheel
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

PERIOD, DURATION, RUNS = 0.1, 140.0, 8
SIGMA = 5.0 * RPM
GYRO = np.deg2rad(0.002)


class FirstSampleOff(eqx.Module):
    """Sensors whose first sample of the wheel's speed is wrong."""

    sensor: Any
    error: Any = 0.0

    def start(self, state, period):
        return self.sensor.start(state, period), jnp.asarray(self.error)

    def __call__(self, memory, state, key):
        own, error = memory
        own, measured = self.sensor(own, state, key)
        return (own, jnp.zeros_like(error)), measured._replace(speed=measured.speed + error)


def sensors(tachometer=None, gyro=GYRO, error=0.0):
    tachometer = Tachometer(SIGMA) if tachometer is None else tachometer
    return FirstSampleOff(TableSensors(Gyro(gyro), tachometer), error)


@pytest.fixture(scope="module")
def compensator(g2):
    """Tuned on a wheel and a table that are wrong by these factors."""

    def make(viscous=1.0, coulomb=1.0, static=1.0, motor=1.0, table=1.0):
        b, c, level, scale = g2.friction
        believed = Stribeck(b * viscous, c * coulomb, level * static, scale)
        wheel = Wheel(g2.wheel.inertia, g2.wheel.motor_constant * motor, believed)
        inertia = g2.inertia * table
        return EstimatingCompensator.tune(g2.law, wheel, inertia, SIGMA, PERIOD, delay=1)

    return make


@pytest.fixture(scope="module")
def loop(g2):
    """Runs on the table, one for each control, with one period of delay."""

    def call(controls, starts, sensor=None, fan=g2.fan, seed=0):
        plant = AirBearingTable(g2.inertia, g2.wheel, external_torque=fan)
        sensor = [sensors()] * RUNS if sensor is None else sensor
        return simulate(
            stack([plant] * RUNS),
            stack(controls),
            stack(sensor),
            start=stack([plant.start(**start) for start in starts]),
            duration=DURATION,
            control_period=PERIOD,
            command_delay=1,
            runs=RUNS,
            seed=seed,
        )

    return call


@pytest.fixture(scope="module")
def crossings(g2, compensator, loop):
    """Peaks, deg, about the crossing, every run at a corner of its own."""
    random = np.random.default_rng(11)
    spreads = {"viscous": 0.1, "coulomb": 0.1, "static": 0.2, "motor": 0.02, "table": 0.03}
    corners = [{k: 1.0 + s * random.choice([-1, 1]) for k, s in spreads.items()} for _ in range(8)]
    starts = [{"speed": -20.0 + x} for x in random.uniform(-4.0, 4.0, RUNS)]

    def peaks(controls, sensor=None):
        data = loop(controls, starts, sensor)
        assert not np.any(data.status)
        found = []
        for k in range(RUNS):
            crossing = np.flatnonzero(data.speed.values[k] >= 0.0)[0]
            assert 400 < crossing < 800
            seen = data.attitude.values[k, crossing - 50 : crossing + 600]
            found.append(np.rad2deg(np.max(np.abs(seen))))
        return np.array(found)

    return peaks, corners


@pytest.fixture(scope="module")
def command_at(g2, compensator):
    """Command of one sample, with an external torque and an undisturbed rate, and the demand."""
    control = compensator()
    call = eqx.filter_jit(control)

    def command(external, undisturbed):
        memory = control.start(PERIOD)
        momentum = memory.momentum._replace(
            momentum=control.momentum.wheel_inertia * 100.0, torque=external, started=1.0
        )
        memory = memory._replace(momentum=momentum, undisturbed=jnp.asarray(undisturbed))
        measurement = TableMeasurement(jnp.asarray(0.0), jnp.asarray(0.0), jnp.asarray(100.0))
        return control, call(memory, measurement)[1]

    return command


def test_the_estimated_speed_is_that_in_the_middle_of_the_acting_period(g2, command_at):
    """One period of delay and half a period, at the acceleration of the external torque."""
    external = 2e-4
    _, command = command_at(external, 0.0)
    expected = 100.0 + 1.5 * PERIOD * external / g2.wheel.inertia
    assert float(command.estimated_speed) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("undisturbed", "sign"), [(1e-4, -1.0), (0.5, -1.0), (-0.5, 1.0)])
def test_the_rate_loop_demands_at_most_the_jump_of_friction(g2, command_at, undisturbed, sign):
    """At rest without attitude error the rate loop alone demands torque, up to 2 F_s."""
    _, command = command_at(0.0, undisturbed)
    breakaway = float(g2.wheel.friction.breakaway_torque(1.0))
    gain = g2.inertia * 6.0 / 3.0
    torque = float(command.attitude_current) * g2.wheel.motor_constant
    assert torque == pytest.approx(sign * min(gain * abs(undisturbed), 2.0 * breakaway), rel=1e-9)


def test_beats_pid_and_plain_compensation_with_noise_and_wrong_models(g2, crossings, compensator):
    peaks, corners = crossings
    own = peaks([compensator(**corner) for corner in corners])
    assert np.max(own) < 0.04
    nothing = Stribeck(0.0, 0.0, 0.0, g2.wheel.friction.stribeck_speed)
    pid, plain = (
        peaks([DynamicModelCompensator(g2.law, friction, g2.wheel.motor_constant)] * RUNS)
        for friction in (nothing, g2.wheel.friction)
    )
    assert np.all((pid > 1.2) & (pid < 1.7))
    # plain compensation, even with the right model, is about six times better than PID
    assert 3.0 < np.median(pid / plain) < 12.0
    assert np.all(pid / own > 30.0)
    assert np.median(plain) / np.median(own) > 5.0


def test_does_as_well_with_counted_pulses(crossings, compensator):
    peaks, corners = crossings
    own = peaks(
        [compensator(**corner) for corner in corners], [sensors(PulseTachometer(24.0))] * RUNS
    )
    assert np.max(own) < 0.04


def test_learns_the_friction_level_and_the_external_torque(g2, loop, compensator):
    """Half a minute before the crossing, from perfect sensors and 10 % wrong either way."""
    wrong = [0.7, 0.8, 0.9, 0.95, 1.0, 1.1, 1.2, 1.4]
    controls = [compensator(viscous=x, coulomb=x, static=x) for x in wrong]
    perfect = [sensors(Tachometer(0.0), 0.0)] * RUNS
    flown = loop(controls, [{"speed": -30.0}] * RUNS, perfect)
    data = flown.sel(time=70.0, method="nearest")
    acting = flown.commanded_current.sel(time=70.0 + PERIOD, method="nearest")
    assert np.all(data.speed < -5.0)
    np.testing.assert_allclose(data.friction_scale * wrong, 1.0, atol=0.01)
    np.testing.assert_allclose(data.estimated_torque, g2.fan, rtol=0.01)
    np.testing.assert_allclose(data.estimated_speed, data.speed, atol=0.2)
    # its parts are the demand of the attitude loop and the friction of the wheel itself
    b, c = g2.friction[:2]
    friction = (b * data.speed - c) / g2.wheel.motor_constant
    np.testing.assert_allclose(data.friction_current, friction, rtol=0.02)
    # their sum acts a period of delay later
    np.testing.assert_allclose(acting, data.friction_current + data.attitude_current, rtol=1e-12)


def test_a_resting_wheel_is_released_whatever_the_first_sample_says(loop, compensator):
    """The fan turns the table until the wheel moves; compensation in the wrong sense would not."""
    wrong = np.array([-100.0, -8.0, -4.0, -1.0, 0.5, 3.0, 6.0, 40.0])
    controls = [compensator(coulomb=1.1, static=1.2)] * RUNS
    data = loop(controls, [{}] * RUNS, [sensors(error=SIGMA * x) for x in wrong], seed=3)
    attitude, resting = np.rad2deg(np.abs(data.attitude.values)), data.speed.values == 0.0
    assert np.all(resting[:, 1])
    released = PERIOD * (data.sizes["time"] - 1 - np.argmax(resting[:, ::-1], axis=1))
    assert np.all(released < 3.0), released
    assert np.all(np.max(attitude, axis=1) < 0.25)
    usual = np.abs(wrong) <= 8.0
    assert np.all(np.max(attitude, axis=1)[usual] < 0.06)
    # from then on the wheel takes up what the fan gives
    assert np.all(data.speed.values[:, -1] > 30.0)


def test_without_external_torque_nothing_hunts_about_rest(loop, compensator):
    controls = [compensator(coulomb=1.1, static=1.1)] * RUNS
    data = loop(controls, [{"attitude": np.deg2rad(0.5)}] * RUNS, fan=0.0)
    late = np.rad2deg(data.attitude.values[:, 1000:])
    assert np.max(np.abs(late - late.mean(axis=1, keepdims=True))) < 0.02
    assert np.max(np.abs(late)) < 0.1


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_knows_which_of_its_commands_acts_now(g2, delay):
    """Busy commands and a model without error: the observer finds nothing once it has settled."""
    coulomb, motor, inertia, rotor = 9e-4, 0.0228, g2.inertia, g2.wheel.inertia
    wheel = Wheel(rotor, motor, ViscousCoulomb(0.0, coulomb))
    control = EstimatingCompensator.tune(g2.law, wheel, inertia, 0.1, PERIOD, delay=delay)
    # the friction that acts before the first command would be learned, and forgotten slowly
    control = eqx.tree_at(lambda own: own.learning_rate, control, 0.0)

    def tick(carry, k):
        memory, rate, speed, under_way = carry
        # what the attitude does is the law's affair alone
        seen = TableMeasurement(0.02 * jnp.sin(0.31 * k), rate, speed)
        memory, command = control(memory, seen)
        queue = jnp.append(under_way, command.current)
        net = motor * queue[0] - coulomb
        after = rate - PERIOD * net / inertia
        speed = speed + PERIOD * net / rotor - (after - rate)
        return (memory, after, speed, queue[1:]), (memory.rate.torque, command.current, speed)

    start = (control.start(PERIOD), 0.0, 30.0, jnp.zeros(delay))
    found, current, speed = jax.lax.scan(tick, start, jnp.arange(400.0))[1]
    assert np.min(speed) > 15.0
    assert np.ptp(current[200:]) > 0.02
    assert np.max(np.abs(found[200:])) < 1e-9
