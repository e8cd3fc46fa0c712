"""The gyrostat against an event-located reference, conservation laws and closed solutions."""

import dataclasses
import importlib.util
from pathlib import Path
from types import SimpleNamespace

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import (
    Gyrostat,
    Spacecraft,
    SpacecraftSensor,
    WheelFailures,
    WheelTorqueCommand,
)
from gyrostat.wheel import PulseTachometer, Tachometer, WheelArray
from gyrostat.wheel.friction import Stribeck

INERTIA = np.array([[10.0, 0.5, 0.2], [0.5, 12.0, -0.3], [0.2, -0.3, 15.0]])
PYRAMID = np.array([[1.0, 1, 1], [1, -1, 1], [-1, 1, 1], [-1, -1, 1]]).T / np.sqrt(3.0)
ROTORS = np.array([0.010, 0.012, 0.009, 0.011])
CURVE = (np.full(4, 2e-5), np.full(4, 1e-3), np.full(4, 1.3e-3), np.full(4, 0.4))
NONE = WheelFailures.none(4)


def built(*, inertia=INERTIA, rotors=ROTORS, curve=CURVE, failures=NONE, external=(0.0, 0.0, 0.0)):
    """Always four wheels, Stribeck friction and one structure, so that it is compiled once."""
    unlimited = np.full(4, np.inf)
    wheels = WheelArray(PYRAMID, rotors, unlimited, unlimited, Stribeck(*curve))
    return Gyrostat(Spacecraft(np.asarray(inertia), wheels), failures, np.asarray(external))


CRAFT = built()
SMOOTH = built(curve=(np.zeros(4), np.zeros(4), np.zeros(4), np.ones(4)))
ALONE = built(curve=(np.zeros(4), np.zeros(4), np.zeros(4), np.full(4, np.inf)))
"""Without any friction curve to resolve."""


@eqx.filter_jit
def _steps(plant, state, torque, time, duration, count):
    def step(_, carried):
        state, fine = carried
        state, resolved = plant(state, WheelTorqueCommand(torque), time, duration)
        return state, fine & resolved

    return jax.lax.fori_loop(0, count, step, (state, jnp.array(True)))


def step_of(plant, state, torque, time, duration, count=1):
    """Equal steps of the plant from a time; numbers as arrays, so that it is compiled once."""
    numbers = (np.asarray(x, dtype=float) for x in (torque, time, duration))
    return _steps(plant, state, *numbers, np.asarray(count))


rate_of = eqx.filter_jit(Gyrostat.rate)
energy_of = eqx.filter_jit(Gyrostat.kinetic_energy)


def stepped(plant, state, torques, duration, substeps=1):
    """Attitude, rate and wheel speeds at the start and after each interval of given torques."""
    states = [state]
    for torque in torques:
        state, resolved = step_of(plant, state, torque, 0.0, duration / substeps, substeps)
        assert resolved
        states.append(state)
    return SimpleNamespace(
        attitude=np.array([state.attitude for state in states]),
        rate=np.array([rate_of(plant, state) for state in states]),
        wheel_speed=np.array([state.wheel_speed for state in states]),
    )


@pytest.fixture(scope="module")
def reference():
    path = Path(__file__).with_name("gyrostat_reference.py")
    spec = importlib.util.spec_from_file_location("gyrostat_reference", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Reference


class Torques(eqx.Module):
    """Sines of different phase, N·m."""

    amplitude: float = 5e-3
    frequency: float = 0.2

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, memory, measurement):
        count = measurement.wheel_speed.shape[0]
        phase = self.frequency * memory + 1.3 * jnp.arange(count)
        return memory + 1.0, WheelTorqueCommand(self.amplitude * jnp.sin(phase))


SAMPLES = 80


def fly(plant, state, control, sensor, **options):
    """80 control periods of 0.5 s."""
    times = {"duration": 0.5 * SAMPLES, "control_period": 0.5}
    return simulate(plant, control, sensor, start=state, **times, **options)


def locked_inertia(craft):
    """Of body and rotors held in it."""
    wheels = craft.spacecraft.wheels
    axes = np.asarray(wheels.axes)
    return craft.spacecraft.inertia + axes @ np.diag(wheels.inertia) @ axes.T


def total_momentum(data, craft):
    """In inertial axes, from rate and wheel speeds alone."""
    rotation = Rotation.from_quat(np.asarray(data.attitude), scalar_first=True)
    wheels = craft.spacecraft.wheels
    rotors = np.asarray(wheels.inertia) * np.asarray(data.wheel_speed)
    body = np.asarray(data.rate) @ locked_inertia(craft)
    return rotation.apply(body + rotors @ np.asarray(wheels.axes).T)


def limited():
    """The craft with limits of torque and momentum."""
    limits = {"torque_limit": np.full(4, 2e-2), "momentum_limit": np.full(4, 0.15)}
    wheels = dataclasses.replace(CRAFT.spacecraft.wheels, **limits)
    return dataclasses.replace(CRAFT, spacecraft=Spacecraft(INERTIA, wheels))


STICKY = built(curve=(np.zeros(4), np.ones(4), np.ones(4), np.ones(4)))
SEIZED = built(failures=NONE.seizes(2, 1.0))
BLIND = built(failures=NONE.with_failure(3, 2.0, sensor_lost=True))
FLIGHTS = {
    "first": (CRAFT, {"wheel_speed": [0.0, -0.2, 0.0, 0.4]}, Torques()),
    "second": (CRAFT, {"wheel_speed": [0.1, -0.2, 0.0, 0.4]}, Torques()),
    "third": (CRAFT, {"wheel_speed": [0.2, -0.2, 0.0, 0.4]}, Torques()),
    "sticky": (STICKY, {"rate": [0.1, -0.2, 0.05]}, Torques(1e-3)),
    "seized": (SEIZED, {"wheel_speed": 100.0}, Torques(0.0)),
    "blind": (BLIND, {"wheel_speed": 50.0}, Torques()),
    "limited": (limited(), {}, Torques(1.0, 0.0)),
}
"""Name -> plant, arguments of its start, and control."""


@pytest.fixture(scope="module")
def flights():
    """Histories of all `FLIGHTS`, flown as one batch."""
    plants, starts, controls = zip(*FLIGHTS.values(), strict=True)
    starts = [plant.start(**start) for plant, start in zip(plants, starts, strict=True)]
    sensors = [SpacecraftSensor(plant) for plant in plants]
    parts = (stack(part) for part in (plants, starts, controls, sensors))
    found = fly(*parts, runs=len(FLIGHTS), engine="auto")
    return {name: found.isel(run=k) for k, name in enumerate(FLIGHTS)}


def test_wheels_that_stick_and_cross_follow_the_event_located_reference(reference):
    """40 s with crossings, rests and breakaways of all four wheels, of fourth order through all."""
    rate, speed = np.array([0.02, -0.03, 0.01]), np.array([0.3, -0.5, 0.0, 2.0])
    start = CRAFT.start(rate=rate, wheel_speed=speed)
    torques = 3e-3 * np.sin(0.3 * np.arange(SAMPLES)[:, None] + 1.3 * np.arange(4))

    coarse, fine = (stepped(CRAFT, start, torques, 0.5, substeps) for substeps in (5, 25))
    plain = reference(INERTIA, PYRAMID, ROTORS, CURVE)
    states = [np.concatenate([[1.0, 0.0, 0.0, 0.0], rate, speed])]
    for torque in torques:
        states.append(plain.carry(states[-1], torque, 0.5))
    states = np.array(states)
    wanted = {"attitude": states[:, :4], "rate": states[:, 4:7], "wheel_speed": states[:, 7:]}
    largest = {"attitude": 1e-13, "rate": 1e-13, "wheel_speed": 1e-10}
    for name, values in wanted.items():
        errors = [np.max(np.abs(getattr(data, name) - values)) for data in (coarse, fine)]
        assert errors[1] < largest[name]
        assert errors[1] < errors[0] / 300.0
    for data in (coarse, fine):
        resting = data.wheel_speed == 0.0
        np.testing.assert_array_equal(resting, wanted["wheel_speed"] == 0.0)
        assert np.sum(resting) >= 5
    assert np.sum(np.diff(np.sign(wanted["wheel_speed"]), axis=0) != 0.0) >= 10


def test_total_momentum_is_conserved_to_rounding():
    start = CRAFT.start(rate=[0.02, -0.03, 0.01], wheel_speed=[30.0, -50.0, 0.0, 20.0])
    torques = 5e-3 * np.sin(0.2 * np.arange(SAMPLES)[:, None] + 1.3 * np.arange(4))
    data = stepped(CRAFT, start, torques, 12.5)
    momentum = total_momentum(data, CRAFT)
    drift = np.linalg.norm(momentum - momentum[0], axis=1)
    assert np.max(drift) < 1e-12 * np.linalg.norm(momentum[0])
    assert np.any(data.wheel_speed == 0.0)


def test_energy_is_conserved_without_friction_and_torque():
    start = SMOOTH.start(rate=[0.1, -0.2, 0.05], wheel_speed=[30.0, -50.0, 10.0, 20.0])
    after, resolved = step_of(SMOOTH, start, np.zeros(4), 0.0, 12.5, SAMPLES)
    assert resolved
    np.testing.assert_allclose(energy_of(SMOOTH, after), energy_of(SMOOTH, start), rtol=1e-9)


def test_energy_falls_by_the_work_of_motors_and_bearings(reference):
    """dE/dt = sum (m_i - F_i) W_i, integrated beside the motion."""
    start = CRAFT.start(rate=[0.01, 0.02, -0.01], wheel_speed=[8.0, -9.0, 7.0, 6.0])
    torque = np.array([1e-3, -2e-3, 1e-3, 5e-4])
    plain = reference(INERTIA, PYRAMID, ROTORS, CURVE)
    sense = np.array([1.0, -1.0, 1.0, 1.0])

    def rate(t, y):
        given = torque - plain.sliding(y[7:11], sense)
        return np.append(plain.rate(t, y[:11], sense, torque), given @ y[7:11])

    y = np.concatenate([start.attitude, rate_of(CRAFT, start), start.wheel_speed, [0.0]])
    work = solve_ivp(rate, (0.0, 5.0), y, method="DOP853", rtol=1e-12, atol=1e-13).y[-1, -1]
    after, resolved = step_of(CRAFT, start, torque, 0.0, 5.0)
    assert resolved
    gained = energy_of(CRAFT, after) - energy_of(CRAFT, start)
    np.testing.assert_allclose(gained, work, rtol=1e-8)


def test_a_symmetric_body_turns_as_the_closed_solution_says():
    """Torque-free precession: the transverse rate turns at (1 - I_3/I_1) w_3."""
    craft = built(
        inertia=np.diag([4.0, 4.0, 6.0]),
        rotors=np.full(4, 1e-9),
        curve=(np.zeros(4), np.zeros(4), np.zeros(4), np.ones(4)),
    )
    start = craft.start(rate=[0.1, 0.0, 0.3])
    data = stepped(craft, start, np.zeros((SAMPLES, 4)), 12.5)
    turned = (6.0 / 4.0 - 1.0) * 0.3 * 12.5 * np.arange(SAMPLES + 1)
    wanted = np.stack([0.1 * np.cos(turned), 0.1 * np.sin(turned), np.full_like(turned, 0.3)], 1)
    # 150 rad of precession in steps of 0.02 rad, each radian within 1e-9 of itself
    np.testing.assert_allclose(data.rate, wanted, atol=5e-8)


def test_resting_wheels_turn_with_the_body_as_one(flights):
    """With every wheel stuck the body is rigid, of the locked inertia."""
    data = flights["sticky"]
    assert np.all(data.wheel_speed.values == 0.0)
    locked = locked_inertia(STICKY)

    def euler(t, w):
        return np.linalg.solve(locked, -np.cross(w, locked @ w))

    wanted = solve_ivp(euler, (0, 40), [0.1, -0.2, 0.05], method="DOP853", rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(data.rate.values[-1], wanted.y[:, -1], atol=1e-9)


def test_a_body_that_speeds_up_breaks_a_resting_wheel_away():
    """An external torque: the rotor stays behind once the bearing cannot drag it along."""
    inertia, rotor, static = 2.0, 0.5, 0.01
    free = np.array([0.0, 0.0, 1.0, 1.0])
    # wheels 0 and 1 rest on axes at right angles to each other's; the others are next to nothing
    rotors = np.array([rotor, 1e-9, 1e-9, 1e-9])
    curve = (np.zeros(4), *(np.where(free, 0.0, static),) * 2, np.ones(4))
    for share, moves in ((0.99, False), (1.01, True)):
        # held, the rotor needs rotor / (inertia + rotor) of the torque about its axis
        torque = share * static * (inertia + rotor) / rotor * PYRAMID[:, 0]
        craft = built(inertia=inertia * np.eye(3), rotors=rotors, curve=curve, external=torque)
        after, _ = step_of(craft, craft.start(), np.zeros(4), 0.0, 10.0)
        assert (float(after.wheel_speed[0]) != 0.0) == moves
        assert float(after.wheel_speed[0]) <= 0.0


@pytest.mark.parametrize("duration", [0.05, 1.0, 20.0])
def test_all_wheels_at_zero_at_once(duration):
    """Four equal wheels on a symmetric body come to zero together and stick."""
    curve = tuple(np.full(4, v) for v in (0.0, 1e-3, 1.3e-3, 0.4))
    craft = built(inertia=12.0 * np.eye(3), rotors=np.full(4, 0.01), curve=curve)
    start = craft.start(wheel_speed=[1.0, -1.0, -1.0, 1.0])
    state, resolved = step_of(craft, start, np.zeros(4), 0.0, duration, round(20.0 / duration))
    assert resolved
    assert np.all(np.asarray(state.wheel_speed) == 0.0)
    np.testing.assert_allclose(rate_of(craft, state), np.zeros(3), atol=1e-12)


def test_a_batch_is_its_runs_alone(flights):
    torques = 5e-3 * np.sin(0.2 * np.arange(SAMPLES)[:, None] + 1.3 * np.arange(4))
    for name in ("first", "second", "third"):
        plant, start, _ = FLIGHTS[name]
        alone = stepped(plant, plant.start(**start), torques, 0.5)
        for part, values in vars(alone).items():
            np.testing.assert_allclose(flights[name][part], values, rtol=0, atol=1e-12)


def test_sensitivities_pass_through_crossings_and_rests():
    """Forward derivatives against fourth-order central differences, over stick and breakaway."""
    torques = jnp.asarray(4e-3 * np.sin(0.4 * np.arange(24)[:, None] + 1.3 * np.arange(4)))

    def end(values):
        level, speed = values
        friction = Stribeck(CURVE[0], level * CURVE[1], level * CURVE[2], CURVE[3])
        craft = eqx.tree_at(lambda g: g.spacecraft.wheels.friction, CRAFT, friction)
        start = craft.start(rate=[0.02, -0.03, 0.01], wheel_speed=[speed, -0.5, 0.0, 2.0])

        def step(state, torque):
            return craft(state, WheelTorqueCommand(torque), 0.0, 0.5)

        state, _ = jax.lax.scan(step, start, torques)
        return jnp.concatenate([state.attitude, state.wheel_speed])

    at, size = np.array([1.0, 0.3]), 2e-3
    # compiled once for value and derivative
    both = jax.jit(lambda values, along: jax.jvp(end, (values,), (along,)))
    for along in np.eye(2):
        derivative = np.asarray(both(at, along)[1])
        ends = [np.asarray(both(at + n * size * along, along)[0]) for n in (1, -1, 2, -2)]
        wanted = (8 * (ends[0] - ends[1]) - ends[2] + ends[3]) / (12 * size)
        np.testing.assert_allclose(derivative, wanted, rtol=1e-4, atol=1e-6)
        assert np.all(np.isfinite(derivative))


def test_a_long_interval_from_rest_is_cut_where_the_body_comes_to_turn():
    """Nothing turns at its start, so that only the acceleration tells how soon it will."""
    torque = np.array([1e-1, -5e-2, 2e-2, 8e-2])
    whole, resolved = step_of(ALONE, ALONE.start(), torque, 0.0, 20.0)
    assert resolved
    state, _ = step_of(ALONE, ALONE.start(), torque, 0.0, 0.1, 200)
    assert np.linalg.norm(rate_of(ALONE, state)) > 0.1
    np.testing.assert_allclose(whole.attitude, state.attitude, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"attitude": np.array([2.0, 0.0, 0.0, 0.0])}, "quaternion of length 2, expected unit"),
        ({"attitude": np.ones((3, 4))}, "quaternion of length 2"),
        ({"momentum": np.zeros(4)}, r"momentum: found shape \(4,\), expected \(3,\)"),
        ({"wheel_speed": np.zeros(3)}, r"wheel_speed: found shape \(3,\), expected \(4,\)"),
    ],
)
def test_starts_that_are_none(change, found):
    with pytest.raises(InputError, match=found):
        fly(CRAFT, CRAFT.start()._replace(**change), Torques(), SpacecraftSensor(CRAFT))


def test_a_command_of_another_number_of_wheels():
    with pytest.raises(InputError, match=r"wheel torque: found shape \(3,\), expected \(4,\)"):
        CRAFT(CRAFT.start(), WheelTorqueCommand(np.zeros(3)), 0.0, 0.5)


# --- failures


def failing(failures, **start):
    craft = dataclasses.replace(CRAFT, failures=failures)
    return craft, craft.start(**start)


def test_a_failure_acts_from_its_own_time_inside_a_period():
    """As if the period had been cut there."""
    failures = NONE.torque_lost(1, 0.7)
    craft, start = failing(failures, wheel_speed=[10.0, 20.0, -5.0, 3.0])
    torque = np.array([1e-2, 2e-2, -1e-2, 1e-2])
    after, _ = step_of(craft, start, torque, 0.0, 2.0)
    healthy, _ = step_of(CRAFT, start, torque, 0.0, 0.7)
    wanted, _ = step_of(CRAFT, healthy, torque * np.array([1.0, 0.0, 1.0, 1.0]), 0.7, 1.3)
    np.testing.assert_allclose(after.wheel_speed, wanted.wheel_speed, rtol=1e-10)
    np.testing.assert_allclose(after.attitude, wanted.attitude, rtol=0, atol=1e-12)


def test_a_seized_wheel_stops_at_once_and_the_body_takes_its_momentum(flights):
    data = flights["seized"]
    seized = data.time.values >= 1.0
    assert np.all(data.wheel_speed.values[seized, 2] == 0.0)
    assert np.all(data.wheel_speed.values[~seized, 2] > 90.0)
    momentum = total_momentum(data, SEIZED)
    np.testing.assert_allclose(momentum, momentum[:1].repeat(len(momentum), 0), rtol=1e-13)
    # an inelastic impact about the wheel's axis: body and rotor share what the rotor had
    before, after = data.rate.values[1], data.rate.values[2]
    axis, rotor = PYRAMID[:, 2], ROTORS[2]
    response = np.linalg.solve(INERTIA, axis)
    impulse = data.wheel_speed.values[1, 2] / (1.0 / rotor + axis @ response)
    np.testing.assert_allclose(after - before, impulse * response, atol=2e-3 * impulse)


def test_what_each_failure_does():
    torque = np.full(4, 1e-2)
    failed = np.array([True, True, True, False])
    failures = (
        NONE.torque_lost(0, 0.0)
        .with_failure(1, 0.0, torque_share=0.4)
        .with_failure(2, 0.0, stuck_torque=-3e-3)
    )
    given = failures.motor_torque(torque, failed)
    np.testing.assert_allclose(given, [0.0, 4e-3, -3e-3, 1e-2])
    np.testing.assert_array_equal(failures.failed(0.0), failed)


def test_a_wheel_runs_down_with_its_added_drag():
    """Friction aside, on a heavy body: exp(-t / tau) with tau = rotor inertia over drag."""
    failures = NONE.torque_lost(0, 0.0, added_viscous=ROTORS[0] / 1000.0)
    smooth = (np.zeros(4), np.zeros(4), np.zeros(4), np.ones(4))
    craft = built(inertia=1e7 * np.eye(3), curve=smooth, failures=failures)
    start = craft.start(wheel_speed=100.0)
    after, resolved = step_of(craft, start, np.zeros(4), 0.0, 12.5, SAMPLES)
    assert resolved
    wanted = [100.0 / np.e, 100.0, 100.0, 100.0]
    np.testing.assert_allclose(after.wheel_speed, wanted, rtol=1e-7)


def test_a_tachometer_is_lost_at_the_very_sample():
    """Ten tenths of a second are the first second."""
    craft, start = failing(NONE.with_failure(3, 1.0, sensor_lost=True))
    sensor = SpacecraftSensor(craft)
    memory, sensor = sensor.start(start, 0.1), eqx.filter_jit(sensor)
    for sample in range(11):
        memory, measurement = sensor(memory, start, jax.random.key(0))
        assert bool(measurement.wheel_measured[3]) == (sample < 10)


def test_a_lost_tachometer_says_so_and_keeps_its_last_value(flights):
    data = flights["blind"]
    lost = data.time.values >= 2.0
    np.testing.assert_array_equal(data.wheel_measured.values[:, 3], ~lost)
    assert np.all(data.wheel_measured.values[:, :3])
    kept = data.measured_wheel_speed.values[lost, 3]
    assert np.all(kept == data.measured_wheel_speed.values[~lost, 3][-1])
    assert np.ptp(data.wheel_momentum.values[lost, 3]) > 0.0


def test_tachometers_see_speeds_whatever_the_rotor_inertia():
    """Pulses of wheels that speed up evenly, whose angles the plant does not carry."""
    start, change, period = np.array([40.0, -7.0, 0.0, 3.0]), np.array([0.5, 0.3, 0.0, -2.0]), 0.5
    pulses = PulseTachometer(24)
    sensor = SpacecraftSensor(built(rotors=2.0 * ROTORS), tachometer=pulses)
    sensor.check()
    memory, sensor = sensor.start(CRAFT.start(wheel_speed=start), period), eqx.filter_jit(sensor)
    counts = np.floor(-period * start * 24 / (2.0 * np.pi))
    for k in range(6):
        time = k * period
        state = CRAFT.start(wheel_speed=start + change * time)
        memory, seen = sensor(memory, state, jax.random.key(k))
        now = np.floor((start * time + 0.5 * change * time**2) * 24 / (2.0 * np.pi))
        quantum = 2.0 * np.pi / (24 * period)
        np.testing.assert_allclose(seen.wheel_speed, quantum * (now - counts), atol=1e-12)
        counts = now


def test_the_older_noise_of_a_momentum_is_one_of_a_speed():
    sensor = SpacecraftSensor(CRAFT, wheel_sigma=1e-3)
    state = CRAFT.start(wheel_speed=10.0)
    _, seen = sensor(sensor.start(state, 0.5), state, jax.random.key(3))
    plain = SpacecraftSensor(CRAFT, tachometer=Tachometer(1e-3 / ROTORS))
    _, same = plain(plain.start(state, 0.5), state, jax.random.key(3))
    np.testing.assert_array_equal(seen.wheel_speed, same.wheel_speed)
    assert np.all(seen.wheel_speed != 10.0)
    with pytest.raises(InputError, match="found wheel_sigma and a tachometer"):
        SpacecraftSensor(CRAFT, wheel_sigma=1e-3, tachometer=Tachometer()).check()


def test_limits_of_torque_and_momentum_hold(flights):
    data = flights["limited"]
    momentum = np.abs(data.wheel_momentum.values)
    assert np.max(momentum) <= 0.15 + 1e-12
    assert np.max(momentum[-1]) > 0.149
    assert np.max(np.abs(np.diff(data.wheel_momentum.values, axis=0))) <= 0.5 * 2.01e-2
    assert np.all(data.saturated.values[0, [1, 2, 3]])


def test_a_failure_within_a_step_leaves_the_momentum_limit_of_the_others_as_it_is():
    """The limit counts with the length of each piece of the step; one of length 0 gives no NaN."""
    wheels = dataclasses.replace(SMOOTH.spacecraft.wheels, momentum_limit=np.full(4, 0.15))
    torque, reached = np.array([0.02, 0.0, 0.02, 0.0]), []
    for time in (np.inf, 0.0, 0.2, 0.5):
        craft = dataclasses.replace(SMOOTH, failures=NONE.torque_lost(1, time))
        craft = dataclasses.replace(craft, spacecraft=Spacecraft(INERTIA, wheels))
        # wheel 0 comes to its limit within the step, wheel 2 stands exactly at it
        state = craft.start(wheel_speed=np.array([0.145, 0.0, 0.15, 0.0]) / ROTORS)
        state, resolved = step_of(craft, state, torque, 0.0, 0.5)
        assert resolved
        reached.append(ROTORS * np.asarray(state.wheel_speed))
    # but for the turning of the body, which the limit leaves out
    np.testing.assert_allclose(reached, np.broadcast_to(reached[0], (4, 4)), atol=3e-5)
    assert reached[0][0] > 0.149


@pytest.mark.parametrize("speed", [15.1, -15.1])
def test_a_start_beyond_the_momentum_limit_is_refused(speed):
    wheels = dataclasses.replace(CRAFT.spacecraft.wheels, momentum_limit=np.full(4, 0.15))
    craft = dataclasses.replace(CRAFT, spacecraft=Spacecraft(INERTIA, wheels))
    state = craft.start(wheel_speed=np.array([0.0, 0.0, 0.0, speed]))
    with pytest.raises(InputError, match=r"speed of wheel 3: found -?15\.1 rad/s.* limit, 0\.15"):
        craft.check_state(state)
    craft.check_state(state._replace(wheel_speed=state.wheel_speed / 1.2))
    several = jax.tree.map(lambda x: jnp.stack([0.5 * x, x]), state)._replace(
        attitude=jnp.stack([state.attitude] * 2)
    )
    with pytest.raises(InputError, match="speed of wheel 3"):
        craft.check_state(several)


def test_a_stuck_torque_stops_at_the_momentum_limit():
    wheels = dataclasses.replace(CRAFT.spacecraft.wheels, momentum_limit=np.full(4, 0.15))
    failures = NONE.with_failure(0, 0.0, stuck_torque=0.1)
    craft = built(failures=failures)
    craft = dataclasses.replace(craft, spacecraft=Spacecraft(INERTIA, wheels))
    state, _ = step_of(craft, craft.start(), np.zeros(4), 0.0, 0.5, 8)
    assert 0.149 < ROTORS[0] * float(state.wheel_speed[0]) <= 0.15


@pytest.mark.parametrize(
    ("failures", "found"),
    [
        (NONE.torque_lost(0, -1.0), "failure time: found -1 s"),
        (NONE.torque_lost(0, np.nan), "failure time: found nan s"),
        (NONE.with_failure(0, 1.0, torque_share=1.5), "found 1.5"),
        (NONE.with_failure(0, 1.0, stuck_torque=np.inf), "stuck torque"),
        (NONE.torque_lost(0, 1.0, added_viscous=-1.0), "drag added"),
        (WheelFailures.none(3), "found 3 wheels, expected 4"),
    ],
)
def test_failures_that_cannot_happen(failures, found):
    with pytest.raises(InputError, match=found):
        dataclasses.replace(CRAFT, failures=failures).check()


def test_other_refusals():
    with pytest.raises(InputError, match="failed wheel: found 4"):
        NONE.seizes(4, 1.0)
    with pytest.raises(InputError, match=r"failed wheel: found 1\.5"):
        NONE.seizes(1.5, 1.0)
    with pytest.raises(InputError, match="found 2, which fails already at 5 s"):
        NONE.torque_lost(2, 5.0).with_failure(2, 10.0, sensor_lost=True)
    with pytest.raises(InputError, match="external torque"):
        dataclasses.replace(CRAFT, external_torque=np.array([0.0, np.nan, 0.0])).check()
