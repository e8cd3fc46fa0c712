"""Slews around keep-out cones against dense sampling, differentiation and the eigenaxis slew."""

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.control.guidance import (
    KeepOutCones,
    SlewLimits,
    WheelEnvelope,
    plan_slew,
    reference_at,
    shortest_time,
)
from gyrostat.control.guidance.bowed_path import BowedPath
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import pyramid_axes, read_wheel_sheet

START = np.array([1.0, 0.0, 0.0, 0.0])
END = np.array([np.cos(0.7), 0.0, np.sin(0.7), 0.0])  # 80 deg about y: the camera +z passes the Sun
SUN = np.array([np.sin(0.7), 0.1, np.cos(0.7)])
CAMERA = [0.0, 0.0, 1.0]
TOTAL = np.array([1e-3, -2e-3, 1.5e-3])
BIAS = 4e-3 * np.array([1.0, -1.0, 1.0, -1.0])


def limits_of(**others):
    wheels = read_wheel_sheet("bct-rwp015").array(pyramid_axes(4))
    craft = gs.Spacecraft(inertia=np.diag([0.12, 0.10, 0.06]), wheels=wheels)
    envelope = WheelEnvelope.of(craft, total_momentum=TOTAL, wheel_momentum=BIAS)
    return SlewLimits(envelope=envelope, **others)


LIMITS = limits_of()


def cones(angle=30.0):
    return KeepOutCones.of((CAMERA, SUN, np.radians(angle)), ([1, 0, 0], [-1, 0, 0], 0.3))


@pytest.fixture(scope="module")
def planned():
    return plan_slew(START, END, cones(), LIMITS)


@pytest.fixture(scope="module")
def motion(planned):
    times = np.linspace(0.0, float(planned.duration), 4001)
    return jax.jit(jax.vmap(lambda time: reference_at(planned, time)))(times)


def body_axes(attitude, vector):
    return jax.vmap(lambda q: rotations.to_body(q, jnp.asarray(vector)))(attitude)


def test_rate_and_slope_of_a_path_are_its_derivatives():
    path = BowedPath(
        jnp.asarray(END), *(jnp.asarray(v) for v in ([1.2, -0.4, 2], [0.3, 0.9, 0], [0, 0.2, 0.1]))
    )
    progress = np.linspace(0.0, 1.0, 21)
    expected = jax.vmap(lambda s: reference_at(path, s))(progress)
    samples = path.sampled(21)
    assert samples.rate == pytest.approx(np.asarray(expected.rate), abs=1e-12)
    assert samples.slope == pytest.approx(np.asarray(expected.acceleration), abs=1e-11)
    assert samples.to_body(rotations.to_body(path.middle, SUN)) == pytest.approx(
        np.asarray(body_axes(expected.attitude, SUN)), abs=1e-14
    )


def test_rate_and_slope_at_small_angles_are_derivatives():
    path = BowedPath(
        jnp.asarray(START), jnp.array([0.1, 0, 0]), jnp.array([0, 0.06, 0]), jnp.zeros(3)
    )
    expected = jax.vmap(lambda s: reference_at(path, s))(np.linspace(0.0, 1.0, 9))
    assert path.sampled(9).rate == pytest.approx(np.asarray(expected.rate), abs=1e-13)
    assert path.sampled(9).slope == pytest.approx(np.asarray(expected.acceleration), abs=1e-11)


def test_bound_between_samples_covers_a_dense_path():
    path = BowedPath(
        jnp.asarray(START), *(jnp.asarray(v) for v in ([0, 2.4, 0], [0.8, 0, 0.1], [0, 0, 0.3]))
    )
    attitudes = jax.vmap(path)(np.linspace(0.0, 1.0, 5001))
    largest = -np.min(jax.vmap(cones().clearance)(attitudes), axis=0)
    excess = np.max(np.cos(np.asarray(cones().angles) - largest) - np.cos(cones().angles))
    coarse, fine = (float(cones().excess(path, path.sampled(n))) for n in (17, 257))
    assert excess <= fine <= coarse
    assert fine == pytest.approx(excess, abs=1e-3)


def test_slew_leads_the_camera_around_the_sun(planned, motion):
    assert planned.is_clear
    assert np.min(jax.vmap(cones().clearance)(motion.attitude)) >= 0.0
    for attitude, wanted in ((motion.attitude[0], START), (motion.attitude[-1], END)):
        assert rotations.error_angle(attitude, jnp.asarray(wanted)) < 1e-7
    assert np.max(np.abs(motion.rate[np.array([0, -1])])) < 1e-9
    # the eigenaxis slew passes within 6 deg of the Sun
    straight = plan_slew(START, END, cones(1.0), LIMITS)
    assert not np.any(straight.path.bow)
    assert straight.duration < planned.duration < 2.0 * straight.duration


def test_wheels_have_the_torque_and_momentum(planned, motion):
    envelope = LIMITS.envelope
    craft, share = envelope.spacecraft, np.asarray(envelope.share[0])
    total = np.asarray(body_axes(motion.attitude, TOTAL))
    rate, change = np.asarray(motion.rate), np.asarray(motion.acceleration)
    torque = share @ (-np.cross(rate, total) - change @ np.asarray(craft.inertia)).T
    momentum = share @ (total - rate @ np.asarray(craft.inertia_locked())).T + BIAS[:, None]
    largest = np.max(np.abs(torque)), np.max(np.abs(momentum))
    assert largest[0] <= 0.8 * 0.004 * (1.0 + 1e-3)
    assert largest[1] <= 0.9 * 0.015 * (1.0 + 1e-3)
    assert max(largest[0] / 0.8 / 0.004, largest[1] / 0.9 / 0.015) > 0.9
    assert planned.crossings == np.sum(np.any(momentum * momentum[:, :1] < 0.0, axis=1))


def test_eigenaxis_takes_the_time_of_the_envelope():
    slew = plan_slew(START, END, cones(1.0), limits_of(rate=0.05))
    turn = jnp.array([0.0, 1.4, 0.0])
    expected = limits_of(rate=0.05).profile(turn, jnp.asarray(START), 0.0).duration
    assert slew.duration == pytest.approx(float(expected), rel=0.01)


def test_start_and_end_inside_a_cone_are_told():
    slew = plan_slew(START, END, KeepOutCones.of((CAMERA, [0, 0.1, 1], 0.2)), LIMITS)
    assert not slew.is_clear
    assert slew.ends_blocked.tolist() == [True, False]
    slew = plan_slew(END, START, KeepOutCones.of((CAMERA, [0, 0.1, 1], 0.2)), LIMITS)
    assert slew.ends_blocked.tolist() == [False, True]


def test_a_slew_to_the_same_attitude_stays_there():
    slew = plan_slew(START, -START, cones(), LIMITS)
    assert slew.is_clear
    assert slew.duration < 1e-4
    assert not np.any(slew.path.bow)


def test_crossings_are_avoided_where_they_cost_more():
    slow = plan_slew(START, END, cones(1.0), LIMITS, crossing_time=100.0)
    fast = plan_slew(START, END, cones(1.0), LIMITS)
    assert slow.crossings == 0 < fast.crossings
    assert fast.duration < slow.duration < fast.duration + 100.0 * fast.crossings


def test_bound_is_exact_about_the_best_axis_and_below_every_slew(planned):
    turn = jnp.array([0.0, 1.4, 0.0])
    assert shortest_time(turn, LIMITS, LIMITS.room(0.0)) < planned.duration
    free = SlewLimits(rate=0.05, acceleration=0.01)
    assert shortest_time(turn, free, None) == pytest.approx(1.4 / 0.05 + 0.05 / 0.01, rel=1e-12)
    still = limits_of().envelope
    still = SlewLimits(envelope=WheelEnvelope.of(still.spacecraft, torque_share=0.8))
    about_z = jnp.array([0.0, 0.0, 0.1])
    expected = still.profile(about_z, jnp.asarray(START), 0.0).duration
    bound = shortest_time(about_z, still, still.room(0.0))
    assert 0.95 * expected < bound <= expected * (1.0 + 1e-12)


def test_limits_below_the_slowest_rate_of_the_envelope_hold():
    slow = plan_slew(START, END, cones(1.0), limits_of(rate=5e-5))
    assert slow.duration >= 1.4 / 5e-5
    assert slow.has_room
    short = np.array([1.0, 0.0, 1e-7, 0.0])  # 2e-7 rad about y
    slew = plan_slew(START, short, cones(1.0), limits_of(acceleration=0.01))
    assert slew.has_room
    assert slew.duration == pytest.approx(2.0 * np.sqrt(2e-7 / 0.01), rel=0.02)


@pytest.mark.parametrize(("total", "has_room"), [(0.06, False), (0.01, True)])
def test_momentum_that_wheels_cannot_hold_is_told(total, has_room):
    still = LIMITS.envelope.spacecraft
    limits = SlewLimits(envelope=WheelEnvelope.of(still, total_momentum=np.array([0, 0, total])))
    about_z = np.array([1.0, 0.0, 0.0, 1.0]) / np.sqrt(2.0)
    assert plan_slew(START, about_z, cones(1.0), limits).has_room == has_room


@pytest.mark.parametrize(
    ("end", "message"),
    [([2.0, 0, 0, 0], "length 2"), ([np.nan, 0, 0, 0], "length nan"), ([0.6, 0, 0.8], "shape")],
)
def test_ends_that_are_no_attitudes_are_refused(end, message):
    with pytest.raises(gs.InputError, match=message):
        plan_slew(START, end, cones(), LIMITS)


@pytest.mark.parametrize(
    ("cone", "message"),
    [(([0, 0, 0], SUN, 0.1), "vectors with a direction"), ((CAMERA, SUN, 4.0), "0 to pi")],
)
def test_cones_without_sense_are_refused(cone, message):
    with pytest.raises(gs.InputError, match=message):
        KeepOutCones.of(cone)
