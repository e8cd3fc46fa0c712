"""Scales of measured speeds from the exchange of momentum, of a motion that conserves it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.monitoring.blocks import Samples, blocks_of
from gyrostat.monitoring.exchange import (
    LARGEST_SIGMA,
    LEARNT,
    Exchange,
    _body,
    _wheels,
    speed_scales,
)
from gyrostat.monitoring.fleet.vehicle import pyramid
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels

INERTIA = np.diag([0.09, 0.1, 0.07])
ROTOR = 1e-4
MOMENTUM = np.array([1e-3, -5e-4, 2e-3])
COUNT = 150
"""Blocks of a minute."""
FLOWN = Exchange(LEARNT)
"""Exchange that learns no more: the inertia is the stated one."""


def known(axes, step=0.0):
    wheel = KnownWheel("a", inertia=ROTOR, motor_constant=0.02, coulomb=1e-3, viscous=1e-6)
    return KnownWheels((wheel,) * axes.shape[1], axes, INERTIA, speed_resolution=step)


def flown(axes, angle=0.3, torque=(0.0, 0.0, 0.0), own=20.0):
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

    slews = angle * random.standard_normal((COUNT, 3))
    before, here, after = (path(time + step) for step in (-1e-2, 0.0, 1e-2))
    rate = (before.inv() * after).as_rotvec() / 2e-2
    total = here.inv().apply(np.outer(time, torque) + MOMENTUM)
    locked = INERTIA + ROTOR * axes @ axes.T
    held = (total - rate @ locked) @ np.linalg.pinv(axes).T / ROTOR
    inner = np.eye(axes.shape[1]) - np.linalg.pinv(axes) @ axes
    waves = np.sin(np.outer(time, 2.0 * np.pi / np.linspace(900.0, 1300.0, axes.shape[1])))
    speed = held + (200.0 + own * waves) @ inner.T
    return Samples(time, speed, np.zeros_like(speed), rate)


def columns(samples, axes, step=0.0):
    blocks, _ = blocks_of(samples, 60.0, step)
    assert len(blocks) == COUNT
    return FLOWN.window(blocks, known(axes, step))[0]


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
    np.testing.assert_allclose([row["speed_scale"] for row in rows], scale, atol=3e-5)
    assert rows[1]["exchange_residual"] > 100.0 * columns(motion, pyramid())[1]["exchange_residual"]


def worst(rows):
    return max(abs(row["speed_scale"] - 1.0) for row in rows)


def test_a_wrong_inertia_is_learnt(motion):
    wheels = known(pyramid()).wheels
    off = np.array([[0.0, 0.004, -0.002], [0.004, 0.0, 0.0], [-0.002, 0.0, 0.0]])
    wrong = KnownWheels(wheels, pyramid(), INERTIA @ np.diag([1.05, 1.0, 0.93]) + off)
    blocks, _ = blocks_of(motion, 60.0, 0.0)
    assert worst(FLOWN.window(blocks, wrong)[0]) > 5e-3
    rows, learnt = Exchange().window(blocks, wrong)
    assert worst(rows) < 2e-4
    rotors = ROTOR * pyramid() @ pyramid().T
    # the stated inertia has a weight of a thousandth
    np.testing.assert_allclose(learnt.inertia(wrong.inertia + rotors), INERTIA + rotors, atol=4e-5)
    # after some windows it is kept
    for _ in range(LEARNT + 2):
        _, learnt = learnt.window(blocks, wrong)
    assert learnt.windows == LEARNT


def test_gyro_noise_does_not_make_the_learnt_inertia_too_small():
    # small slews: a regression on the noisy rates themselves gives 5 % too little
    small = flown(pyramid(), angle=0.03, own=20.0)
    random = np.random.default_rng(7)
    learnt = Exchange()
    for _ in range(LEARNT):
        blocks, _ = blocks_of(scaled(small, 1.0, 3e-6, random), 60.0, 0.0)
        _, learnt = learnt.window(blocks, known(pyramid()))
    locked = INERTIA + ROTOR * pyramid() @ pyramid().T
    x = np.diff(_body(blocks), axis=0).reshape(-1, 9)
    y = np.diff(_wheels(blocks, pyramid() * ROTOR).sum(axis=2), axis=0).reshape(-1)
    attenuated = -np.linalg.lstsq(x, y)[0].reshape(3, 3)
    assert np.all(np.diagonal(attenuated / locked) < 0.96)
    assert learnt.inertia(locked) == pytest.approx(locked, abs=1e-3)


def test_external_torques_are_left_out():
    # as large as that of slews; what turns with the body during a slew is left
    pushed = flown(pyramid(), torque=(1e-7, -2e-7, 1e-7))
    for row in columns(pushed, pyramid()):
        assert row["speed_scale"] == pytest.approx(1.0, abs=2e-3)


def test_errors_are_as_large_as_stated(motion):
    random = np.random.default_rng(4)
    scores = []
    for _ in range(60):
        rows = columns(scaled(motion, 1.0, 2e-5, random), pyramid())
        scores.append([(row["speed_scale"] - 1.0) / row["speed_scale_sigma"] for row in rows])
    # 60 draws of four errors, alike within a draw: known to 10 %; Bartlett's weights state too much
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.1


def test_the_bias_by_rounded_speeds_is_in_sigma():
    # small slews, and a tachometer of 0.1 rad/s: the scale is too large, and not used
    small = flown(pyramid(), angle=0.1, own=0.0)
    rounded = scaled(small, 1.0, step=0.1)
    blocks, _ = blocks_of(rounded, 60.0, 0.1)
    momentum = pyramid() * ROTOR
    received = -_body(blocks) @ (INERTIA + momentum @ pyramid().T).ravel()
    found = {
        step: speed_scales(
            received, _wheels(blocks, momentum), np.full(4, (step * ROTOR / 60.0) ** 2 / 12.0)
        )
        for step in (0.0, 0.1)
    }
    scale, sigma = found[0.1]
    assert np.all(scale - 1.0 > 4.0 * found[0.0][1])
    assert np.all(np.abs(scale - 1.0) < 1.5 * sigma)
    assert np.all(np.abs(scale - 1.0) > 0.3 * sigma)
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
    for row in columns(noisy, axes):
        assert row.get("speed_scale_sigma", 0.0) <= LARGEST_SIGMA


def test_a_wheel_without_telemetry_leaves_the_scales_open(motion):
    speed = motion.speed.copy()
    speed[:, 2] = np.nan
    rows = columns(Samples(motion.time, speed, motion.drive, motion.rate), pyramid())
    assert rows == [{}, {}, {}, {}]
