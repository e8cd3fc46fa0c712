"""Friction that moves the wheel does not pass for a slew: bursts, slow attitude loops, glitches."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.instruments import AFTER, Motion, instruments, moving_average
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheels
from tests.monitoring.closed_loop import NOMINAL, fly
from tests.monitoring.test_estimate import known

PARAMETERS = ("motor_constant", "viscous", "coulomb")
NOISE = 1e-7


def scores(flight, sigma, window):
    """Standardised errors of each valid window."""
    samples, truth = flight
    wheels = known()
    if sigma is not None:
        wheels = replace(wheels, wheels=(replace(wheels.wheels[0], sigma=sigma),))
    monitor = WheelMonitor(wheels, window=window)
    monitor.add(samples)
    table = monitor.windows()
    assert table["valid"].all()
    right = (truth.motor_constant, truth.viscous, truth.mean)
    columns = zip(PARAMETERS, right, strict=True)
    return np.array([(table[n] - value) / table[f"{n}_sigma"] for n, value in columns])


@pytest.mark.parametrize("slews", [False, True])
@pytest.mark.parametrize("height", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("sigma", [None, {}, {"motor_constant": 0.05 * 0.027}])
def test_torque_bursts_bias_nothing(sigma, height, slews):
    # without slews, most of the acceleration is that of the bursts
    flight = fly(4, slews=slews, days=0.5, burst=height)
    assert np.max(np.abs(scores(flight, sigma, 43200.0))) < 3.0


@pytest.mark.parametrize("bandwidth", [0.02, 0.05, 0.3])
def test_friction_noise_in_a_slow_attitude_loop_biases_nothing(bandwidth):
    # speeds answer the noise for minutes; with speeds as instruments, scores were 5 to 11 at 0.02
    flights = [fly(seed, slews=False, days=0.5, bandwidth=bandwidth) for seed in range(100, 112)]
    values = np.array([scores(each, {}, 43200.0)[:, 0] for each in flights])
    assert np.sqrt(np.mean(values**2, axis=0)) == pytest.approx(0.0, abs=1.6)


@pytest.mark.parametrize("sigma", [None, {}])
@pytest.mark.parametrize("slews", [False, True])
@pytest.mark.parametrize(("size", "width"), [(3.0, 2), (10.0, 1), (50.0, 2), (150.0, 1)])
def test_glitches_of_the_speed_at_the_edge_of_a_block_bias_nothing(size, width, slews, sigma):
    samples, truth = fly(4, slews=slews, days=0.25)
    speed = samples.speed.copy()
    speed[6000 : 6000 + width] += size
    assert np.max(np.abs(scores((replace(samples, speed=speed), truth), sigma, 21600.0))) < 3.0


@pytest.fixture
def random():
    return np.random.default_rng(5)


def motion(random, friction, torque):
    """Motion of a wheel with a friction and an acceleration torque, (B,)."""
    noisy = torque + NOISE * random.standard_normal(torque.size)
    drive = (friction + noisy) / NOMINAL["motor_constant"]
    drive += 2e-5 * random.standard_normal(torque.size)
    speed = 100.0 + np.cumsum(torque) * 60.0 / NOMINAL["inertia"]
    gap = np.zeros(torque.size - 1, bool)
    return Motion(noisy, speed, np.ones(torque.size), noisy, drive, gap, NOISE)


@pytest.mark.parametrize("factor", [1.0, 0.3, 1.6, 9.55])
def test_slews_are_kept_as_they_are_with_a_wrong_motor_constant_too(random, factor):
    torque = np.zeros(300)
    torque[50:290:40], torque[51:290:40] = 3e-4, -2e-4
    wheel = motion(random, np.full(300, 1e-3), torque)
    felt, speed, jump = instruments(wheel, factor * NOMINAL["motor_constant"])
    slew = torque != 0.0
    assert felt[slew] == pytest.approx(wheel.felt[slew], rel=1e-12)
    assert not np.any(jump)
    # the moving average has no part in changes of the speed by slews
    assert np.diff(speed)[slew[1:]] == pytest.approx(np.diff(wheel.speed)[slew[1:]], abs=0.1)
    assert np.all(np.abs(felt[~slew]) < 4.0 * NOISE)


@pytest.mark.parametrize("factor", [1.0, 0.8, 1.25])
def test_accelerations_by_torque_bursts_are_taken_out(random, factor):
    friction, torque = np.full(300, 1e-3), np.zeros(300)
    for start in range(50, 290, 40):
        friction[start : start + 6] += 3e-4
        torque[start], torque[start + 6] = -1e-4, 1e-4  # until the attitude loop has answered
        torque[start + 1], torque[start + 7] = 1e-4, -1e-4
    wheel = motion(random, friction, torque)
    felt, speed, jump = instruments(wheel, factor * NOMINAL["motor_constant"])
    assert np.all(jump[torque != 0.0])
    assert np.sum(jump) <= 6 * 2 * (AFTER + 3)
    assert np.max(np.abs(felt)) < 4.0 * NOISE
    assert np.ptp(speed) < 0.1


def test_speeds_change_across_gaps(random):
    # blocks of slews are often missing, as the mode changes
    speed = np.where(np.arange(200) < 100, 100.0, 130.0)
    wheel = motion(random, np.full(200, 1e-3), np.zeros(200))
    gap = np.arange(199) == 99
    kept = instruments(replace(wheel, speed=speed, gaps=gap), NOMINAL["motor_constant"])[1]
    assert kept == pytest.approx(speed)
    assert moving_average(speed)[95] > 105.0


def two_wheels(seed):
    """Two wheels on one axis, six hours; bursts of the first, and a slow loop of their difference.

    The attitude loop does not oppose the difference of their speeds, which answers a burst for
    minutes.
    """
    random = np.random.default_rng(seed)
    count, body = 21600, 70.0
    motor = NOMINAL["motor_constant"] * (1.0 + 0.003 * random.standard_normal(2))
    viscous = NOMINAL["viscous"] * (1.0 + 0.03 * random.standard_normal(2))
    keep = np.exp(-1.0 / 1200.0)
    sigma = 0.02 * NOMINAL["coulomb"]
    shocks = sigma * np.sqrt(1.0 - keep**2) * random.standard_normal((count, 2))
    slow = sigma * random.standard_normal(2)
    angle, rate, gained = 0.0, 0.0, np.zeros(2)
    wheel = np.array([150.0, 140.0])
    speed, current, friction = np.zeros((3, count, 2))
    start = 1000.0 + 2000.0 * random.random()
    for k in range(count):
        slow = keep * slow + shocks[k]
        burst = np.array([0.3 * ((k - start) % 3600.0 < 300.0), 0.0])
        friction[k] = NOMINAL["coulomb"] * (1.0 + burst) + slow
        asked = 0.5 * body * 0.1 * (0.1 * angle + 1.4 * rate)
        null = -NOMINAL["inertia"] / 600.0 * 0.5 * (wheel[0] - wheel[1] - 10.0)
        nominal = asked + null * np.array([1.0, -1.0]) + NOMINAL["coulomb"]
        nominal = nominal + NOMINAL["viscous"] * wheel
        speed[k], current[k] = wheel, nominal / NOMINAL["motor_constant"]
        net = motor * current[k] - friction[k] - viscous * (wheel + 0.5 * gained)
        outside = 2e-6 * np.sin(2.0 * np.pi * k / 5700.0)
        rate += (outside - net.sum()) / body
        angle += rate
        gained = net / NOMINAL["inertia"]
        wheel = wheel + gained
    rounding = 0.4 * np.pi / 30.0
    speed = np.round(speed / rounding + 0.2 * random.standard_normal(speed.shape)) * rounding
    current = np.round(current / 1e-3 + 0.5 * random.standard_normal(speed.shape)) * 1e-3
    samples = Samples(np.arange(float(count)), speed, current)
    return samples, (motor, viscous, friction.mean(axis=0))


def test_what_bursts_do_to_wheels_without_axes_widens_the_interval():
    # the data move the motor constant by several of its sigma, and could know nothing of it
    sigma = {"motor_constant": 0.05 * NOMINAL["motor_constant"], "viscous": 0.3 * 5e-6}
    errors = []
    for seed in range(8):
        samples, right = two_wheels(seed)
        rotor = replace(known().wheels[0], sigma=sigma)
        wheels = (rotor, replace(rotor, name="b"))
        monitor = WheelMonitor(KnownWheels(wheels, speed_resolution=known().speed_resolution))
        monitor.add(samples)
        table = monitor.windows()
        assert table["valid"].all()
        columns = zip(PARAMETERS, right, strict=True)
        errors.append([(table[n] - value) / table[f"{n}_sigma"] for n, value in columns])
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) < 1.7)
