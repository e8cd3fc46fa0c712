"""Two wheels, next to no momentum: the drift, the aim of a sweep, and the closed loop."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.control import TwoWheelSweeps, ZeroMomentumRecovery
from gyrostat.control.underactuated.recovery.rest_to_rest import progress, rate_axis, turned
from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation.loop import run
from gyrostat.spacecraft import Gyrostat, Spacecraft, SpacecraftSensor, WheelFailures
from gyrostat.wheel import WheelArray

PERIOD = 0.1
WHEELS = WheelArray(np.eye(3), np.full(3, 0.01), np.full(3, 0.1), np.full(3, 3.0))
TILT = Rotation.from_rotvec([0.4, -0.7, 0.3]).as_matrix()
TILTED = TILT @ np.diag([8.0, 12.0, 16.0]) @ TILT.T
TILTED = 0.5 * (TILTED + TILTED.T)
WORKING = np.array([True, True, False])
NORMAL = np.array([0.0, 0.0, 1.0])


def quaternion(rotation):
    return np.roll(rotation.as_quat(), 1)


@pytest.fixture(scope="module")
def made():
    """A spacecraft, its sweeps, and one planned with 0.02 N·m·s."""
    sweeps = TwoWheelSweeps.of(Spacecraft(TILTED, WHEELS), WORKING)
    inertia = TILTED + 0.01 * np.outer(NORMAL, NORMAL)
    start, target = Rotation.random(2, rng=4)
    momentum = jnp.array([0.012, -0.016, 0.0])
    attitude, goal = jnp.asarray(quaternion(start)), jnp.asarray(quaternion(target))
    last = ZeroMomentumRecovery.plan(Spacecraft(TILTED, WHEELS), WORKING, target=goal).start(0.1)
    plan = jax.jit(lambda begin: sweeps.planned(last.sweep, begin, attitude, goal, momentum, 0.9))
    return SimpleNamespace(**locals())


def test_the_rate_along_z_is_the_drift_whatever_the_wheels_do(made):
    random = np.random.default_rng(0)
    for _ in range(5):
        body, wheels = random.normal(size=3), random.normal(size=3) * WORKING
        rate = np.linalg.solve(made.inertia, body - wheels)
        relative = wheels - 0.01 * rate * WORKING
        measured = made.sweeps.momentum(jnp.asarray(rate), jnp.asarray(relative) / 0.01)
        np.testing.assert_allclose(measured, body, rtol=1e-12)
        along = np.asarray(made.sweeps.frame)[:, 2] @ rate
        assert along == pytest.approx(float(made.sweeps.drift @ measured), rel=1e-10)


def test_the_lever_is_the_slope_of_the_drift(made):
    momentum = jnp.array([0.3, -0.5, 0.2])

    def drift(turn):
        there = rotations.from_rotation_vector(made.sweeps.frame @ turn)
        there = rotations.product(made.attitude, there)
        return made.sweeps.drift @ rotations.to_body(there, momentum)

    step = 1e-6
    slopes = [(drift(step * e) - drift(-step * e)) / (2 * step) for e in jnp.eye(3)]
    np.testing.assert_allclose(made.sweeps.lever(made.attitude, momentum), slopes, atol=1e-9)


def test_torques_give_the_acceleration(made):
    """J w' = b x w - W u of the body with its working rotors, solved for w'."""
    rate, momentum = np.array([0.01, -0.02, 0.003]), np.array([0.05, 0.02, -0.03])
    wanted = np.array([1e-3, -2e-3, 7.0])
    torque = made.sweeps.torque(*map(jnp.asarray, (wanted, rate, momentum)))
    assert np.max(np.abs(torque)) < 0.1
    found = np.linalg.solve(made.inertia, np.cross(momentum, rate) - np.asarray(torque))
    np.testing.assert_allclose((np.asarray(made.sweeps.frame).T @ found)[:2], wanted[:2], rtol=1e-9)


def test_torques_beyond_the_limit_keep_their_direction(made):
    def torque(size):
        return made.sweeps.torque(size * jnp.array([1.0, -0.3, 0.0]), jnp.zeros(3), jnp.zeros(3))

    assert np.max(np.abs(torque(1.0))) == pytest.approx(0.1)
    np.testing.assert_allclose(torque(1.0) / 0.1, torque(1e-3) / np.max(np.abs(torque(1e-3))))


def test_a_planned_sweep_ends_on_target_with_the_drift_on_its_way(made):
    """Integrated by scipy with the drift as part of the rate; without it, degrees are missed."""
    sweep, sweeps = made.plan(True), made.sweeps
    turn = jax.jit(rotations.rate_of_quaternion)

    @jax.jit
    def slope(time, attitude):
        angle, speed = progress(sweep, time)
        drift = sweeps.drift @ rotations.to_body(attitude, made.momentum)
        across = speed * rate_axis(sweep, angle)
        return turn(attitude, sweeps.frame @ (across + jnp.array([0.0, 0.0, 1.0]) * drift))

    duration = float(sweep.duration)
    found = solve_ivp(slope, (0.0, duration), made.attitude, rtol=1e-8, atol=1e-10).y[:, -1]
    end = rotations.product(made.attitude, sweeps.in_body(turned(sweep, sweep.length)))
    assert rotations.error_angle(jnp.asarray(found), made.goal) < np.radians(0.002)
    assert rotations.error_angle(end, made.goal) > np.radians(0.5)


def test_a_planned_sweep_keeps_to_the_limits_of_the_wheels(made):
    sweep, sweeps = made.plan(True), made.sweeps

    def momentum(time):
        angle, speed = progress(sweep, time)
        rate = sweeps.frame @ (speed * rate_axis(sweep, angle))
        return -sweeps.allocation @ (sweeps.inertia @ rate)

    @jax.jit
    @jax.vmap
    def momentum_and_torque(time):
        return momentum(time), jax.jacfwd(momentum)(time)

    times = np.linspace(0.0, 1.0, 501) * float(sweep.duration)
    found, torque = (np.abs(part).max() for part in momentum_and_torque(times))
    # the bound is for any axis of the plane; no wheel is idle on this one
    assert 0.06 < torque < 0.09 * 1.002
    assert found < 2.7


def test_no_sweep_is_planned_where_none_begins(made):
    assert made.plan(False) == made.last.sweep


@pytest.mark.parametrize(
    ("wheels", "working", "words"),
    [
        (WHEELS, [True, True, True], "rank 3, expected 2"),
        (WHEELS, [True, False, False], "rank 1, expected 2"),
        (WHEELS, [True, True], r"shape \(2,\), expected \(3,\)"),
        (WheelArray(np.eye(3), np.full(3, 0.01)), WORKING, "no limit of torque"),
    ],
)
def test_wheels_that_make_no_sweeps_are_refused(wheels, working, words):
    with pytest.raises(InputError, match=words):
        TwoWheelSweeps.of(Spacecraft(TILTED, wheels), working)


def test_a_tuning_without_meaning_is_refused():
    spacecraft = Spacecraft(TILTED, WHEELS)
    control = ZeroMomentumRecovery.plan(spacecraft, WORKING, target=np.eye(4)[0], share=0.0)
    with pytest.raises(InputError, match="recovery share: found 0, expected a finite value above"):
        control.check()


# Momentum, N·m·s; error of the known inertia; rate at the start, rad/s; allowed time, s
CASES = {
    "twist by half a turn": (0.0, 0.0, 0.0, 105.0),
    "at rest": (0.0, 0.0, 0.0, 105.0),
    "inertia 1 % wrong": (0.0, 0.01, 0.0, 150.0),
    "tumbling": (0.0, 0.0, 0.03, 150.0),
    "0.01": (0.01, 0.0, 0.0, 200.0),
    "0.01 and 1 % wrong": (0.01, 0.01, 0.0, 200.0),
    "0.1": (0.1, 0.0, 0.0, 200.0),
    "0.03 and 1 % wrong": (0.03, 0.01, 0.0, 200.0),
}


def case(number):
    """Plant, controller and start; the target is one where the momentum has no normal part."""
    random = np.random.default_rng(number)
    size, error, across, _ = list(CASES.values())[number]
    wrong = random.normal(size=(3, 3))
    wrong = (wrong + wrong.T) / np.linalg.norm(wrong + wrong.T, 2)
    start, target = Rotation.random(2, rng=random)
    if number == 0:
        target = start * Rotation.from_rotvec(np.pi * TILTED[2] / np.linalg.norm(TILTED[2]))
    momentum = size * start.apply([0.48, 0.6, 0.64])
    flat = target.inv().apply(momentum) * WORKING
    if size > 0.0:
        turn = Rotation.align_vectors(target.inv().apply(momentum)[None], flat[None])[0]
        target = target * turn
    plant = Gyrostat(Spacecraft(TILTED, WHEELS), WheelFailures.none(3).seizes(2, 0.0))
    locked, body = TILTED + 0.01 * np.eye(3), start.inv().apply(momentum)
    drift = locked @ NORMAL
    rate = drift * body[2] / (drift @ drift) + across * np.cross(drift, [1.0, 0, 0]) / 16.0
    speed = (body - locked @ rate) * WORKING / 0.01
    known = Spacecraft(TILTED + error * 16.0 * wrong, WHEELS)
    control = ZeroMomentumRecovery.plan(known, WORKING, target=quaternion(target))
    return plant, control, plant.start(attitude=quaternion(start), rate=rate, wheel_speed=speed)


@pytest.fixture(scope="module")
def recovered():
    """All cases, carried by one compiled loop through 400 s, twice the longest time allowed.

    One after the other: a batch would compile for twice as long.
    """
    plant = case(0)[0]

    @jax.jit
    def single(control, start):
        sensor = SpacecraftSensor(plant)
        found = run(plant, control, sensor, start, jax.random.key(0), PERIOD, count=4000)
        errors = jax.vmap(rotations.error_angle, in_axes=(0, None))
        return found, errors(found.state.attitude, control.target)

    drawn = [case(number)[1:] for number in range(len(CASES))]
    flown = [single(*jax.tree.map(lambda leaf: np.asarray(leaf, float), item)) for item in drawn]
    found, errors = jax.tree.map(lambda *leaves: np.stack(leaves), *flown)
    return found, np.degrees(errors)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_it_gets_there_in_time_and_stays(recovered, name):
    found, errors = recovered
    number, allowed = list(CASES).index(name), CASES[name][3]
    rates = np.linalg.norm(found.record.rate[number], axis=1)
    later = np.arange(4001) * PERIOD >= allowed
    assert errors[number].max() > 30.0
    assert errors[number][later].max() < 0.05
    assert rates[later].max() < 1e-4
    assert found.status[number].max() == 0


@pytest.mark.slow
def test_no_momentum_is_made_on_the_way(recovered):
    momentum = recovered[0].state.momentum
    assert np.abs(momentum - momentum[:, :1]).max() == 0.0


@pytest.mark.slow
def test_commands_keep_to_the_limits(recovered):
    found = recovered[0]
    assert np.abs(found.command.torque).max() <= 0.1 * (1.0 + 1e-12)
    assert np.abs(found.record.wheel_momentum).max() < 3.0


@pytest.mark.slow
def test_one_sweep_is_enough_where_the_inertia_is_known(recovered):
    started = recovered[0].command.started.sum(axis=1)
    known = np.array([error == 0.0 for _, error, _, _ in CASES.values()])
    assert np.all(started[known] == 1)
    assert np.all(started[~known] <= 3)
