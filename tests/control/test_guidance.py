"""References: kinematics against an integrator, slews against their closed form, modes by hand."""

from functools import partial
from typing import ClassVar

import equinox as eqx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gyrostat.control.guidance import (
    Condition,
    Fixed,
    Nadir,
    Reference,
    SlewLimits,
    SlewProfile,
    Slews,
    Table,
    WheelEnvelope,
    reference_at,
)
from gyrostat.control.guidance.pointing import frame_of_axes
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector
from gyrostat.spacecraft import CircularOrbit, Spacecraft, SpacecraftMeasurement
from gyrostat.wheel import WheelArray, pyramid_axes

REST = np.array([1.0, 0.0, 0.0, 0.0])
ORBIT = CircularOrbit.at_altitude(500e3, inclination=1.7, ascending_node=0.4, latitude=-0.3)
NADIR = Nadir.pointing(ORBIT, [0.0, 0.0, 1.0], [1.0, 0.2, 0.1])
CRAFT = Spacecraft(
    np.array([[0.12, 0.004, 0], [0.004, 0.10, -0.003], [0, -0.003, 0.06]]),
    WheelArray(pyramid_axes(4), np.full(4, 2e-5), np.full(4, 3e-3), np.full(4, 1.5e-2)),
)
LIMITS = SlewLimits(np.radians(2.0), np.radians(0.4), np.radians(0.3))
MODES = Reference.sequence(
    (Fixed(REST), Condition(after=5.0, rate_below=0.01)),
    (NADIR, Condition(error_below=0.02, momentum_above=1e-3)),
    (lambda t: from_rotation_vector(0.01 * t * jnp.array([0.0, 1.0, 0.0])), Condition()),
    limits=LIMITS,
    spacecraft=CRAFT,
)


def smooth(time):
    return from_rotation_vector(
        jnp.array([0.5 * jnp.sin(0.3 * time), 0.1 * time, 0.4 * jnp.cos(0.2 * time)])
    )


def wobbling(time):
    """Smooth motion whose quaternion changes length and sign."""
    sign = jnp.where(jnp.sin(0.7 * time) > 0.0, 1.0, -1.0)
    return sign * (2.0 + jnp.sin(time)) * smooth(time)


@eqx.filter_jit
def at(reference, mode, time):
    """Motion of a reference, as one program for each reference."""
    return reference.at(mode, time)


@eqx.filter_jit
def entered(reference, number, start):
    """Mode of a reference that comes from the mode before it, whose own slew is over."""
    before = reference.start()._replace(number=jnp.asarray(max(number - 1, 0)))
    return reference.entered(before, jnp.asarray(number), start)


@eqx.filter_jit
def sampled(profile, times):
    """Motion of a profile at many times."""
    return jax.vmap(partial(reference_at, profile))(times)


def rotation(quaternions):
    return Rotation.from_quat(np.array(quaternions), scalar_first=True)


def angle_between(one, other):
    return (rotation(one).inv() * rotation(other)).magnitude()


SLEWS = jax.jit(Slews.to)(
    REST,
    np.array([1.0, 9.0, 30.0]),
    np.array([[0.6, 0.8, 0.0, 0.0], [0.0, 0.0, 0.6, -0.8], [0.0, 0.0, 0.6, -0.8]]),
    LIMITS,
)
"""The second slew begins before the first has ended; the third turns by nothing."""
MOTIONS = {
    "nadir": Reference.of(NADIR),
    "wobbling": Reference.of(wobbling),
    "slews": Reference.of(SLEWS),
    "table": Reference.of(
        Table.of(
            np.linspace(0.0, 40.0, 201),
            sampled(wobbling, np.linspace(0.0, 40.0, 201)).attitude,
        )
    ),
    "mode": MODES,
}


@pytest.mark.parametrize("name", MOTIONS)
def test_the_reported_rate_integrates_to_the_attitude(name):
    """Quaternion kinematics from the rate, and the rate from the acceleration, to fourth order.

    In each step the two nodes of Gauss; rotation vector of the step by the expansion of Magnus.
    """
    start, end, steps = 3.0, 34.0, 15500
    reference = MOTIONS[name]
    mode = entered(reference, 2, start) if name == "mode" else reference.start()
    step, root = (end - start) / steps, np.sqrt(3.0)
    places = start + step * (np.arange(steps)[:, None] + [0.5 - root / 6.0, 0.5 + root / 6.0])
    times = np.concatenate([[start, end], places.ravel()])
    motion = jax.jit(jax.vmap(lambda time: reference.at(mode, time)))(times)
    attitude, rate, acceleration = map(np.asarray, motion)
    earlier, later = rate[2::2], rate[3::2]
    turns = 0.5 * step * (earlier + later) + root / 12.0 * step**2 * np.cross(earlier, later)
    turned = Rotation.from_rotvec(turns)
    while len(turned) > 1:
        if len(turned) % 2:
            turned = Rotation.concatenate([turned, Rotation.identity(1)])
        turned = turned[::2] * turned[1::2]
    solved = (rotation(attitude[0]) * turned[0]).as_quat(scalar_first=True)
    assert angle_between(solved, attitude[1]) < 2e-8
    gained = 0.5 * step * np.sum(acceleration[2:], axis=0)
    np.testing.assert_allclose(rate[0] + gained, rate[1], atol=2e-8)


def test_nadir_points_to_the_earth_of_the_environment():
    times = np.array([0.0, 777.0, 5000.0])
    motion = sampled(NADIR, times)
    near = np.array([0.0, -1e-3, 1e-3])[:, None]
    zenith, before, after = np.array(jax.jit(jax.vmap(jax.vmap(ORBIT.zenith)))(times + near))
    to_body = rotation(motion.attitude).inv()
    np.testing.assert_allclose(to_body.apply(zenith), [[0.0, 0.0, -1.0]] * 3, atol=1e-12)
    along = to_body.apply((after - before) / 2e-3 / ORBIT.rate)
    ahead = np.array([1.0, 0.2, 0.0]) / np.hypot(1.0, 0.2)
    np.testing.assert_allclose(along, [ahead] * 3, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(motion.rate, axis=1), ORBIT.rate, rtol=1e-12)
    np.testing.assert_allclose(motion.acceleration, 0.0, atol=1e-15)


def test_parallel_axes_are_refused():
    with pytest.raises(InputError, match="parallel"):
        Nadir.pointing(ORBIT, [0.0, 0.0, 1.0], [0.0, 0.0, -2.0]).check()


@pytest.mark.parametrize(("what", "order"), [("attitude", 4), ("rate", 3), ("acceleration", 2)])
def test_a_table_converges_with_its_order(what, order):
    probes = np.linspace(10.0, 30.0, 1000)
    exact = getattr(sampled(smooth, probes), what)
    errors = []
    for rows in (81, 161):
        times = np.linspace(0.0, 40.0, rows)
        table = Table.of(times, sampled(smooth, times).attitude)
        errors.append(np.max(np.abs(getattr(sampled(table, probes), what) - exact)))
    assert errors[0] / errors[1] == pytest.approx(2.0**order, rel=0.35)


@pytest.mark.parametrize(
    ("times", "attitudes", "message"),
    [
        ([0.0, 1.0, 1.0, 2.0], [REST] * 4, "row 2: found the time 1 s"),
        ([0.0, 1.0, np.nan, 2.0], [REST] * 4, "row 2: found the time nan s"),
        ([0.0, 1.0, 2.0], [REST] * 3, "four rows"),
        ([0.0, 1.0, 2.0, 3.0], [REST, REST, [0, 1, 0, 0], REST], "row 2: found a rotation of 180"),
        ([0.0, 1.0, 2.0, 3.0], [REST, 2 * REST, REST, REST], "length 2"),
    ],
)
def test_a_table_that_is_no_motion_is_refused(times, attitudes, message):
    with pytest.raises(InputError, match=message):
        Table.of(times, np.array(attitudes, dtype=float))


_fastest = jax.jit(SlewProfile.fastest)


@jax.jit
def motion_of(profile, times):
    """Angle, rate and acceleration of a profile."""

    def rate(time):
        return jax.jvp(profile, (time,), (1.0,))[1]

    return jax.vmap(lambda t: (profile(t), rate(t), jax.jvp(rate, (t,), (1.0,))[1]))(times)


positive = st.floats(-4.0, 1.0).map(lambda x: 10.0**x)
limited = st.one_of(positive, st.just(np.inf))


@given(
    angle=st.one_of(st.just(0.0), st.floats(1e-9, np.pi)),
    rate=limited,
    free=st.booleans(),
    acceleration=positive,
    jerk=limited,
)
@settings(max_examples=80)
def test_a_slew_keeps_its_limits_and_takes_the_shortest_time(angle, rate, free, acceleration, jerk):
    if free and np.isfinite(jerk):
        acceleration = np.inf
    profile = _fastest(angle, rate, acceleration, jerk)
    duration = float(profile.duration)
    times = duration * np.linspace(-0.1, 1.1, 1201)
    turned, speed, pushed = (np.asarray(x) for x in motion_of(profile, times))
    slack = 1.0 + 1e-9
    assert np.all(np.diff(turned) >= -1e-12 * angle)
    assert turned[0] == 0.0
    assert turned[-1] == pytest.approx(angle, rel=1e-12)
    assert np.max(np.abs(speed)) <= rate * slack
    assert np.max(np.abs(pushed)) <= acceleration * slack
    if duration > 0.0:
        steepest = np.max(np.abs(np.diff(pushed))) / (times[1] - times[0])
        assert steepest <= jerk * (1.0 + 1e-6)
    assert duration == pytest.approx(shortest(angle, rate, acceleration, jerk), rel=1e-9, abs=1e-12)


def shortest(angle, rate, acceleration, jerk):
    """Time of the fastest slew: the largest rate by bisection, from the distance that it needs."""

    def rise(top):
        if top * jerk < acceleration**2:
            return 2.0 * np.sqrt(top / jerk)
        return top / acceleration + acceleration / jerk

    low, high = 0.0, min(rate, 1e6)
    if angle == 0.0:
        return 0.0
    if high * rise(high) <= angle:
        return angle / high + rise(high)
    for _ in range(300):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if middle * rise(middle) < angle else (low, middle)
    return 2.0 * rise(0.5 * (low + high))


def test_slews_turn_about_one_axis_and_end_at_their_targets():
    ends = np.asarray(SLEWS.ends())
    attitudes = sampled(SLEWS, np.array([300.0, 2.0, 5.0, 8.0])).attitude
    assert angle_between(attitudes[0], [0.0, 0.0, 0.6, -0.8]) < 1e-12
    assert ends[0] > 9.0, "the second begins during the first"
    turned = rotation(attitudes[1:]).as_rotvec()
    np.testing.assert_allclose(turned[:, 1:], 0.0, atol=1e-15)


limits_of = eqx.filter_jit(lambda envelope, *slew: envelope.limits(*slew))
HELD = np.array([6e-3, -2e-3, 1e-3, 4e-3])


@pytest.mark.parametrize("momentum", [np.zeros(3), np.array([4e-3, -3e-3, 5e-3])])
@pytest.mark.parametrize("turn", [[0.0, 0.0, 2.0], [0.3, -0.2, 0.1], [2.0, 2.0, 1.0]])
def test_the_fastest_slew_saturates_a_limit_and_none_is_exceeded(turn, momentum):
    """Torque and momentum of every wheel along the slew, by the equations of motion."""
    turn = np.array(turn)
    angle = np.linalg.norm(turn)
    axis, before = turn / angle, Rotation.from_rotvec([0.2, -0.5, 0.3])
    start, total = before.as_quat(scalar_first=True), before.apply(momentum)
    envelope = WheelEnvelope.of(CRAFT, total_momentum=total, wheel_momentum=HELD)
    rate, acceleration = map(float, limits_of(envelope, turn, start, 0.0))
    profile = _fastest(angle, rate, acceleration, np.inf)
    times = np.linspace(1e-9, 1.0 - 1e-9, 4001) * float(profile.duration)
    turned, speed, pushed = (np.asarray(x)[:, None] for x in motion_of(profile, times))
    body = Rotation.from_rotvec(turned * axis).inv().apply(momentum)
    share = np.linalg.pinv(CRAFT.wheels.axes)
    spun = share @ CRAFT.inertia @ axis
    torque = -speed * np.cross(axis, body) @ share.T - pushed * spun
    null = HELD - share @ (CRAFT.wheels.axes @ HELD)
    held = null + (body - speed * (CRAFT.inertia_locked() @ axis)) @ share.T
    loads = np.max(np.abs(torque)) / (0.8 * 3e-3), np.max(np.abs(held)) / (0.9 * 1.5e-2)
    assert max(loads) <= 1.0 + 1e-9
    if not momentum.any():
        assert max(loads) == pytest.approx(1.0, rel=1e-9)
    # no other rate is faster, by search
    best = float(profile.duration)
    for other in rate * np.linspace(0.5, 1.5, 41):
        left = np.min(
            (0.8 * 3e-3 - np.max(np.abs(np.cross(axis, body) @ share.T), 0) * other) / np.abs(spun)
        )
        if (
            left > 0.0
            and np.max(
                np.abs(null + body @ share.T)
                + other * np.abs(share @ CRAFT.inertia_locked() @ axis)
            )
            <= 0.0135
        ):
            fastest = _fastest(angle, other, left, np.inf)
            assert float(fastest.duration) >= best * (1.0 - 1e-3)


def test_failed_wheels_give_nothing_to_a_slew():
    three = np.array([True, True, True, False])
    every, left = WheelEnvelope.of(CRAFT), WheelEnvelope.of(CRAFT, three)
    turn = np.array([0.0, 0.0, 1.0])
    slower = limits_of(left, turn, REST, 0.0)
    assert slower[1] < 0.8 * limits_of(every, turn, REST, 0.0)[1]
    later = WheelEnvelope.of(CRAFT, np.array([[True] * 4, three]), starts=np.array([0.0, 50.0]))
    np.testing.assert_allclose(limits_of(later, turn, REST, 50.0), slower, rtol=1e-12)
    with pytest.raises(InputError, match="do not span space"):
        WheelEnvelope.of(CRAFT, [True, True, False, False])


def measured(rate=0.0, attitude=REST, speed=0.0):
    return SpacecraftMeasurement(
        np.asarray(attitude), np.array([rate, 0.0, 0.0]), np.full(4, speed), np.ones(4, bool)
    )


def test_modes_follow_each_other_by_their_conditions():
    step = jax.jit(lambda *sample: MODES.step(*sample))
    # no weak types, so that it is compiled once
    mode = jax.tree.map(lambda leaf: np.asarray(leaf), MODES.start())
    assert step(mode, measured(rate=0.005), 4.75).number == 0, "too early"
    assert step(mode, measured(rate=0.02), 6.0).number == 0, "too fast"
    mode = step(mode, measured(rate=0.005), 6.0)
    assert (int(mode.number), float(mode.start)) == (1, 6.0)
    end = 6.0 + np.float64(mode.transition.duration)
    there = at(MODES, mode, end + 5.0).attitude
    on_its_way = at(MODES, mode, np.float64(8.0)).attitude
    assert step(mode, measured(attitude=on_its_way, speed=90.0), 8.0).number == 1
    assert step(mode, measured(attitude=there), end + 5.0).number == 1, "no momentum"
    assert step(mode, measured(speed=90.0), end + 5.0).number == 1, "off target"
    mode = step(mode, measured(attitude=there, speed=90.0), end + 5.0)
    assert mode.number == 2
    assert step(mode, measured(), 1e9).number == 2, "the last mode never ends"


def test_a_missing_sample_ends_only_modes_that_need_no_measurement():
    timed = Reference.sequence(
        (Fixed(REST), Condition(after=5.0)),
        (NADIR, Condition(after=1.0, rate_below=1.0)),
        (Fixed(REST), Condition()),
        limits=LIMITS,
    )
    step = jax.jit(lambda mode, time: timed.step(mode, None, time))
    mode = step(jax.tree.map(np.asarray, timed.start()), np.float64(5.0))
    assert (int(mode.number), float(mode.start)) == (1, 5.0)
    assert step(mode, np.float64(1e6)).number == 1


def test_a_change_of_mode_has_no_step_in_attitude_rate_and_acceleration():
    """From nadir to a turning target and on, through slews with limited jerk."""
    for number, time in ((1, 6.0), (2, 71.0)):
        now = np.float64(time)
        before = at(MODES, MODES.start()._replace(number=jnp.asarray(number - 1)), now)
        after = at(MODES, entered(MODES, number, now), now)
        assert angle_between(before.attitude, after.attitude) < 1e-12
        np.testing.assert_allclose(before.rate, after.rate, atol=1e-12)
        np.testing.assert_allclose(before.acceleration, after.acceleration, atol=1e-12)


def test_references_that_cannot_work_are_refused():
    with pytest.raises(InputError, match="no slew limits"):
        Reference.sequence((Fixed(REST), Condition()), (NADIR, Condition()))
    with pytest.raises(InputError, match="no spacecraft"):
        Reference.sequence(
            (Fixed(REST), Condition(momentum_above=1.0)), (NADIR, Condition()), limits=LIMITS
        )
    with pytest.raises(InputError, match="neither acceleration nor jerk"):
        SlewLimits(0.01).check()


class Turning:
    """Rotation about the first axis at a rate that may be changed."""

    def __init__(self, rate):
        self.rate = rate
        self.calls = 0

    def __eq__(self, other):  # so that the object cannot be hashed
        return self is other

    def __call__(self, time):
        self.calls += 1
        return from_rotation_vector(self.rate * time * jnp.array([1.0, 0.0, 0.0]))


def test_a_profile_that_changes_is_noticed():
    profile = Turning(0.1)
    reference = Reference.of(profile)
    for profile.rate in (0.1, 0.3):
        assert reference.bound(reference.start())(2.0).rate[0] == pytest.approx(profile.rate)


class Counted(eqx.Module):
    """Profile of numbers only that counts how often it is traced."""

    rate: jax.Array
    calls: ClassVar[list] = []

    def __call__(self, time):
        self.calls.append(time)
        return from_rotation_vector(self.rate * time * jnp.array([1.0, 0.0, 0.0]))


def test_a_profile_of_numbers_is_traced_once_in_a_program():
    def rates(rate):
        reference = Reference.of(Counted(rate))
        bound = reference.bound(reference.start())
        return jnp.stack([bound(time).rate[0] for time in jnp.arange(4.0)])

    jax.make_jaxpr(rates)(0.1)
    assert len(Counted.calls) == 1
    np.testing.assert_allclose(rates(0.2), 0.2, rtol=1e-12)


class Powers(eqx.Module):
    terms: int
    is_negative: bool

    def __call__(self, time):
        angle = sum(1e-3 * time**k for k in range(self.terms))
        return from_rotation_vector(jnp.array([-angle if self.is_negative else angle, 0.0, 0.0]))


def test_python_may_use_the_numbers_of_a_profile():
    reference = Reference.of(Powers(3, True))
    rate = reference.at(reference.start(), 5.0).rate
    np.testing.assert_allclose(rate, [-1e-3 * (1.0 + 2.0 * 5.0), 0.0, 0.0], rtol=1e-12)


@pytest.mark.parametrize(("sine", "parallel"), [(0.8e-6, True), (1.25e-6, False)])
def test_axes_are_parallel_below_a_millionth(sine, parallel):
    second = jnp.array([np.sqrt(1.0 - sine**2), sine, 0.0])
    body = frame_of_axes(jnp.array([3.0, 0.0, 0.0]), 5.0 * second)
    assert np.all(np.isnan(body)) == parallel
