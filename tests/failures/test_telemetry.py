"""Momentum from telemetry, the momentum to unload, and attitudes in words, against formulas."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.failures import Telemetry, attitude_text, euler_angles, holdable, state_of

HALF = np.sqrt(0.5)


@pytest.fixture(scope="module")
def brute(module_at):
    from pathlib import Path

    return module_at(Path(__file__).with_name("brute.py"))


def random_state(random, wheels):
    attitude = Rotation.random(random_state=random)
    return attitude, random.normal(0.0, 0.02, 3), random.normal(0.0, 50.0, wheels)


def test_the_total_momentum_is_that_of_body_and_rotors_in_inertial_axes(brute):
    """Each rotor turns about its axis with the body rate and its own speed."""
    random = np.random.default_rng(3)
    for _ in range(20):
        body = brute.spacecraft(brute.unit(random, 4), np.inf)
        attitude, rate, speed = random_state(random, 4)
        given = Telemetry.of(body, attitude.as_quat(scalar_first=True), rate, speed)
        rotor = np.asarray(body.wheels.inertia) * np.ones(4)
        expected = np.asarray(body.inertia) @ rate
        for axis, inertia, own in zip(np.asarray(body.wheels.axes).T, rotor, speed, strict=True):
            expected = expected + inertia * (own + axis @ rate) * axis
        found = given.total_momentum(body)
        np.testing.assert_allclose(found, attitude.apply(expected), rtol=1e-13, atol=1e-14)


def test_the_simulation_starts_with_the_same_momentum(brute):
    random = np.random.default_rng(4)
    body = brute.spacecraft(brute.unit(random, 3), np.inf)
    attitude, rate, speed = random_state(random, 3)
    quaternion = attitude.as_quat(scalar_first=True)
    start = state_of(body, quaternion, rate, speed)
    found = Telemetry.of(body, quaternion, rate, speed).total_momentum(body)
    np.testing.assert_allclose(found, np.asarray(start.momentum), rtol=1e-12)


@pytest.mark.parametrize(
    ("attitude", "rate", "speed", "message"),
    [
        ([2.0, 0.0, 0.0, 0.0], [0.0] * 3, [0.0] * 3, "quaternion of length 2"),
        ([1.0, 0.0, 0.0, 0.0], [0.0, np.nan, 0.0], [0.0] * 3, "rate: found"),
        ([1.0, 0.0, 0.0, 0.0], [0.0] * 3, [0.0, 0.0, np.inf], "wheel speeds: found"),
        ([1.0, 0.0, 0.0, 0.0], [0.0] * 3, [0.0, 1e9, 0.0], "speed of wheel 1"),
    ],
)
def test_an_impossible_motion_is_refused(brute, attitude, rate, speed, message):
    body = brute.spacecraft(np.eye(3), 3.0)
    with pytest.raises(InputError, match=message):
        Telemetry.of(body, np.array(attitude), np.array(rate), np.array(speed))


def test_the_target_is_feasible_without_the_momentum_to_unload_and_not_with_more(brute):
    random = np.random.default_rng(6)
    unloaded = 0
    for limit in (np.inf, 0.4):
        for _ in range(12):
            body = brute.spacecraft(brute.unit(random, 3), limit)
            momentum, failed = random.normal(0.0, 0.6, 3), {2: 0.3}
            target = Rotation.random(random_state=random).as_quat(scalar_first=True)
            answer = holdable(body, momentum, failed=failed, target=target)
            if answer.unload is None:
                assert answer.holdable
                continue
            unloaded += 1
            left = momentum - answer.unload
            assert holdable(body, left, failed=failed, target=target).holdable
            less = momentum - 0.99 * answer.unload
            assert not holdable(body, less, failed=failed, target=target).holdable
    assert unloaded > 12


def test_two_wheels_leave_the_momentum_along_their_normal(brute):
    """The working wheels y and z hold no momentum along x beside that of the failed wheel."""
    body = brute.spacecraft(np.eye(3), 3.0)
    answer = holdable(body, [0.46, -0.04, 0.82], failed={0: 0.28}, target=[HALF, 0.0, 0.0, HALF])
    # body x along inertial y
    np.testing.assert_allclose(answer.unload, [0.0, -0.04 - 0.28, 0.0], atol=1e-12)


def test_a_boresight_needs_least_unloading_at_the_best_roll(brute):
    body = brute.spacecraft(np.eye(3), 3.0)
    case = {"failed": {0: 0.2, 1: 0.0}, "boresight": ([0.0, 0.6, 0.8], [1.0, 0.2, 0.1])}
    momentum = np.array([0.4, -0.3, 0.6])
    answer = holdable(body, momentum, **case)
    assert not answer.holdable
    assert holdable(body, momentum - answer.unload, **case).holdable
    # every roll angle, with the wheel z and 0.2 N·m·s along x
    aim = np.array([1.0, 0.2, 0.1]) / np.linalg.norm([1.0, 0.2, 0.1])
    first, _ = Rotation.align_vectors([aim], [[0.0, 0.6, 0.8]])
    sizes = []
    for roll in np.linspace(0.0, 2.0 * np.pi, 2001):
        in_body = (Rotation.from_rotvec(roll * aim) * first).inv().apply(momentum)
        sizes.append(np.hypot(in_body[0] - 0.2, in_body[1]))
    assert np.linalg.norm(answer.unload) == pytest.approx(min(sizes), rel=1e-5)


def test_euler_angles_give_the_attitude_back():
    random = np.random.default_rng(8)
    special = [[0, 0, 0, 1], [1, 0, 0, 0], [0, 1, 0, 0], [HALF, 0, 0, HALF], [0, HALF, HALF, 0]]
    every = [*map(np.array, special), *Rotation.random(20, random_state=random).as_quat()]
    for quaternion in every:
        angles = euler_angles(np.asarray(quaternion, dtype=float))
        back = Rotation.from_euler("ZXZ", angles).as_quat(scalar_first=True)
        assert abs(back @ quaternion) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("quaternion", "words"),
    [
        ([1.0, 0.0, 0.0, 0.0], "not turned"),
        ([-1.0, 0.0, 0.0, 0.0], "not turned"),
        ([0.0, 0.0, 0.0, 1.0], "turned by 180 deg about z; 3-1-3 angles 180, 0, 0 deg"),
        ([0.0, 0.0, 0.0, -1.0], "turned by 180 deg about z;"),
        ([HALF, 0.0, -HALF, 0.0], "turned by 90 deg about -y;"),
        ([HALF, HALF, 0.0, 0.0], "turned by 90 deg about x; 3-1-3 angles 0, 90, 0 deg"),
        ([0.5, 0.5, 0.5, 0.5], "turned by 120 deg about (0.57735, 0.57735, 0.57735)"),
    ],
)
def test_an_attitude_is_told_as_a_turn_about_a_named_axis(quaternion, words):
    assert attitude_text(np.array(quaternion)).startswith(words)
