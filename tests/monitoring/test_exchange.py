"""Scales of measured speeds from the exchange of momentum, of a motion that conserves it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.monitoring.blocks import Samples, blocks_of
from gyrostat.monitoring.exchange import Exchange, Regression, _body, _wheels
from gyrostat.monitoring.fleet.vehicle import pyramid
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels

INERTIA = np.diag([0.09, 0.1, 0.07])
ROTOR = 1e-4
MOMENTUM = np.array([1e-3, -5e-4, 2e-3])
COUNT = 150
"""Blocks of a minute."""
AXES = {"z": (0.0, 0.0, 1.0), "all": (1.0, 1.0, 1.0)}


def known(axes, step=0.0):
    wheel = KnownWheel("a", inertia=ROTOR, motor_constant=0.02, coulomb=1e-3, viscous=1e-6)
    return KnownWheels((wheel,) * axes.shape[1], axes, INERTIA, speed_resolution=step)


def flown(axes, angle=0.3, torque=(0.0, 0.0, 0.0), own=20.0, axes_of=(1.0, 1.0, 1.0)):
    """Samples of a second: slews by about `angle`, rad; wheels hold the momentum.

    Wheels also exchange momentum with each other, `own` rad/s, where there are more than three.
    """
    random = np.random.default_rng(2)
    time = np.arange(0.0, 60.0 * COUNT + 2.0)

    def path(at):
        vector = np.zeros((at.size, 3))
        for begin in np.arange(200.0, time[-1], 500.0):
            phase = np.clip((at - begin) / 400.0, 0.0, 1.0)[:, None]
            share = phase - np.sin(2.0 * np.pi * phase) / (2.0 * np.pi)
            vector += share * slews[int(begin // 500.0)]
        return Rotation.from_rotvec(vector)

    slews = angle * random.standard_normal((COUNT, 3)) * axes_of
    before, here, after = (path(time + step) for step in (-1e-2, 0.0, 1e-2))
    rate = (before.inv() * after).as_rotvec() / 2e-2
    total = here.inv().apply(np.outer(time, torque) + MOMENTUM)
    locked = INERTIA + ROTOR * axes @ axes.T
    held = (total - rate @ locked) @ np.linalg.pinv(axes).T / ROTOR
    inner = np.eye(axes.shape[1]) - np.linalg.pinv(axes) @ axes
    waves = np.sin(np.outer(time, 2.0 * np.pi / np.linspace(900.0, 1300.0, axes.shape[1])))
    speed = held + (200.0 + own * waves) @ inner.T
    return Samples(time, speed, np.zeros_like(speed), rate)


def locked(axes, inertia=INERTIA):
    return inertia + ROTOR * axes @ axes.T


def exact(axes, inertia=INERTIA):
    """Exchange that has learnt an inertia for good."""
    return Exchange(np.eye(9), -locked(axes, inertia).ravel())


def columns(samples, axes, step=0.0):
    blocks, _ = blocks_of(samples, 60.0, step)
    assert len(blocks) == COUNT
    return exact(axes).window(blocks, known(axes, step))[0]


@pytest.fixture(scope="module")
def motion():
    return flown(pyramid())


def scaled(samples, scale, noise=0.0, random=None, step=0.0):
    """Telemetry: scaled and rounded speeds, noisy rates."""
    speed = samples.speed * np.asarray(scale)
    if step:
        speed = np.round(speed / step) * step
    rate = samples.rate
    if noise:
        rate = rate + noise * random.standard_normal(rate.shape)
    return Samples(samples.time, speed, samples.drive, rate)


def test_scale_of_each_wheel_is_found(motion):
    scale = np.array([1.0, 0.97, 1.0, 1.02])
    rows = columns(scaled(motion, scale), pyramid())
    # speeds and rates that curve within a minute leave 1e-5
    np.testing.assert_allclose([row["speed_scale"] for row in rows], 1.0 / scale, atol=3e-5)
    assert rows[1]["exchange_residual"] > 100.0 * columns(motion, pyramid())[1]["exchange_residual"]


def worst(rows):
    return max(abs(row["speed_scale"] - 1.0) for row in rows)


def test_a_wrong_inertia_is_learnt(motion):
    wheels = known(pyramid()).wheels
    off = np.array([[0.0, 0.004, -0.002], [0.004, 0.0, 0.0], [-0.002, 0.0, 0.0]])
    stated = INERTIA @ np.diag([1.05, 1.0, 0.93]) + off
    wrong = KnownWheels(wheels, pyramid(), stated)
    blocks, _ = blocks_of(motion, 60.0, 0.0)
    assert worst(exact(pyramid(), stated).window(blocks, wrong)[0]) > 5e-3
    rows, learnt = Exchange().window(blocks, wrong)
    assert worst(rows) < 2e-4
    inertia, _ = learnt.inertia(locked(pyramid(), stated), 0.0)
    np.testing.assert_allclose(inertia, locked(pyramid()), atol=2e-5)
    assert not learnt.contradicted


def test_it_is_learnt_for_the_axes_that_slews_show():
    # windows with slews about z alone, then about all: the other elements were not known before
    random = np.random.default_rng(3)
    wheels = known(pyramid()).wheels
    wrong = KnownWheels(wheels, pyramid(), INERTIA @ np.diag([1.05, 1.0, 0.95]))
    about = {name: flown(pyramid(), own=0.0, axes_of=each) for name, each in AXES.items()}
    learnt, seen = Exchange(), []
    for name in ["z"] * 12 + ["all"] * 12:
        blocks, _ = blocks_of(scaled(about[name], 1.0, 3e-6, random), 60.0, 0.0)
        rows, after = learnt.window(blocks, wrong)
        seen.append(not np.array_equal(after.product, learnt.product))
        learnt = after
        for row in rows:
            if "speed_scale" in row:
                assert abs(row["speed_scale"] - 1.0) < 4.0 * row["speed_scale_sigma"]
    # it learns until the inertia is known well enough, and again when other axes show
    assert seen[0]
    assert not seen[11]
    assert seen[12]
    assert not seen[23]


def test_rates_in_the_wrong_unit_contradict_the_inertia():
    # rad/s that are read as deg/s
    motion = flown(pyramid(), own=0.0)
    seen = Samples(motion.time, motion.speed, motion.drive, np.radians(motion.rate))
    blocks, _ = blocks_of(seen, 60.0, 0.0)
    rows, learnt = Exchange().window(blocks, known(pyramid()))
    assert learnt.contradicted
    assert all("speed_scale" not in row for row in rows)
    # one tachometer that counts half the pulses is a fault of a wheel
    half = scaled(motion, [1.0, 0.5, 1.0, 1.0])
    rows, learnt = exact(pyramid()).window(blocks_of(half, 60.0, 0.0)[0], known(pyramid()))
    assert not learnt.contradicted
    assert rows[1]["speed_scale"] == pytest.approx(2.0, rel=0.01)


def test_gyro_noise_does_not_make_the_learnt_inertia_too_small():
    # small slews: a regression on the noisy rates themselves gives 5 % too little
    small = flown(pyramid(), angle=0.03, own=20.0)
    random = np.random.default_rng(7)
    learnt = Exchange()
    for _ in range(8):
        blocks, _ = blocks_of(scaled(small, 1.0, 3e-6, random), 60.0, 0.0)
        _, learnt = learnt.window(blocks, known(pyramid()))
    x = np.diff(_body(blocks), axis=0).reshape(-1, 9)
    y = np.diff(_wheels(blocks, pyramid() * ROTOR).sum(axis=2), axis=0).reshape(-1)
    attenuated = -np.linalg.lstsq(x, y)[0].reshape(3, 3)
    assert np.all(np.diagonal(attenuated / locked(pyramid())) < 0.97)
    inertia, covariance = learnt.inertia(locked(pyramid()), 6.0 * (0.1 * 3e-6 / 60.0) ** 2)
    away = (inertia - locked(pyramid())).ravel()
    assert np.all(np.abs(away) < 4.0 * np.sqrt(np.diagonal(covariance)))
    assert np.max(np.abs(away)) < 1e-3


def test_what_is_not_measured_is_left_out(motion):
    rate = motion.rate.copy()
    rate[1000:1100:7] = np.nan  # within blocks and at their ends
    blocks, _ = blocks_of(Samples(motion.time, motion.speed, motion.drive, rate), 60.0, 0.0)
    rows, _ = exact(pyramid()).window(blocks, known(pyramid()))
    for row in rows:
        assert row["speed_scale"] == pytest.approx(1.0, abs=1e-4)


def test_thrusters_in_a_mode_that_is_left_out_are_no_exchange(motion):
    firing = (motion.time > 2000.0) & (motion.time <= 2400.0)
    push = np.where(firing, np.sign(2200.5 - motion.time), 0.0)  # to and fro
    rate = motion.rate + np.cumsum(push)[:, None] * [1e-4, 0.0, 0.0]
    mode = np.where(firing, 2.0, 0.0)
    scales = []
    for left_out in ((2.0,), ()):
        wheels = replace(known(pyramid()), modes_left_out=left_out)
        monitor = WheelMonitor(wheels, window=60.0 * COUNT, drive="none")
        monitor.exchange = exact(pyramid())
        monitor.add(Samples(motion.time, motion.speed, motion.drive, rate, mode=mode))
        scales.append(monitor.windows()["speed_scale"])
    np.testing.assert_allclose(scales[0], 1.0, atol=1e-3)
    assert not np.all(np.abs(scales[1] - 1.0) < 3e-3)


def test_external_torques_are_left_out():
    # as large as that of slews; what turns with the body during a slew is left
    pushed = flown(pyramid(), torque=(1e-7, -2e-7, 1e-7))
    for row in columns(pushed, pyramid()):
        assert row["speed_scale"] == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize(("rates", "speeds"), [(np.degrees(1.0), 1.0), (1.0, np.pi / 30.0)])
def test_rates_or_speeds_in_another_unit_are_told(motion, rates, speeds):
    other = Samples(motion.time, motion.speed * speeds, motion.drive, motion.rate * rates)
    blocks, _ = blocks_of(other, 60.0, 0.0)
    rows, learnt = Exchange().window(blocks, known(pyramid()))
    assert learnt.contradicted
    assert all("speed_scale" not in row for row in rows)


def test_rounding_alone_is_no_wrong_inertia():
    random = np.random.default_rng(6)
    time = np.arange(0.0, 60.0 * COUNT + 2.0)
    speed = np.round(200.0 + 0.1 * random.standard_normal((time.size, 4)) / 0.04) * 0.04
    rate = 1e-6 * random.standard_normal((time.size, 3))
    blocks, _ = blocks_of(Samples(time, speed, np.zeros_like(speed), rate), 60.0, 0.4)
    rows, learnt = Exchange().window(blocks, known(pyramid(), 0.4))
    assert not learnt.contradicted
    assert all("speed_scale" not in row for row in rows)


def test_errors_are_as_large_as_stated(motion):
    random = np.random.default_rng(4)
    scores = []
    for _ in range(60):
        rows = columns(scaled(motion, 1.0, 2e-5, random), pyramid())
        scores.append([(row["speed_scale"] - 1.0) / row["speed_scale_sigma"] for row in rows])
    # 60 draws of four errors, alike within a draw: known to 10 %; Bartlett's weights state too much
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.1


def test_the_bias_by_rounded_speeds_is_in_sigma():
    # small slews, and a tachometer of 0.1 rad/s: the scale is too small, and not used
    small = flown(pyramid(), angle=0.1, own=0.0)
    rounded = scaled(small, 1.0, step=0.1)
    blocks, _ = blocks_of(rounded, 60.0, 0.1)
    momentum = pyramid() * ROTOR
    found = {
        step: Regression.of(
            _wheels(blocks, momentum), np.full(4, (step * ROTOR / 60.0) ** 2 / 12.0)
        ).scales(_body(blocks), locked(pyramid()), np.zeros((9, 9)))[:2]
        for step in (0.0, 0.1)
    }
    scale, sigma = found[0.1]
    assert np.all(1.0 - scale > 4.0 * found[0.0][1])
    np.testing.assert_array_less(0.3 * sigma, 1.0 - scale)
    np.testing.assert_array_less(1.0 - scale, 1.5 * sigma)
    assert all("speed_scale" not in row for row in columns(rounded, pyramid(), 0.1))


def test_what_does_not_show_is_left_out(motion):
    axes = pyramid()
    blocks, _ = blocks_of(motion, 60.0, 0.0)
    assert Exchange().window(blocks, KnownWheels(known(axes).wheels))[0] == [{}] * 4
    resting = Samples(motion.time, motion.speed * [1.0, 1.0, 1.0, 0.0], motion.drive, motion.rate)
    assert "speed_scale" not in columns(resting, axes)[3]
    quiet = Samples(motion.time, np.full_like(motion.speed, 200.0), motion.drive, motion.rate)
    assert all("speed_scale" not in row for row in columns(quiet, axes))
    # two wheels about one axis that always move alike: only their sum shows
    double = np.column_stack([axes[:, 0], axes[:, 0], axes[:, 1], axes[:, 2]])
    alike = flown(axes)
    speed = np.column_stack([alike.speed[:, :1] / 2, alike.speed[:, :1] / 2, alike.speed[:, 1:3]])
    rows = columns(Samples(alike.time, speed, np.zeros_like(speed), alike.rate), double)
    assert [("speed_scale" in row) for row in rows[:2]] == [False, False]
    noisy = scaled(motion, 1.0, 5e-3, np.random.default_rng(1))
    assert all("speed_scale" not in row for row in columns(noisy, axes))


def test_a_wheel_without_telemetry_leaves_the_scales_open(motion):
    speed = motion.speed.copy()
    speed[:, 2] = np.nan
    rows = columns(Samples(motion.time, speed, motion.drive, motion.rate), pyramid())
    assert rows == [{}, {}, {}, {}]
