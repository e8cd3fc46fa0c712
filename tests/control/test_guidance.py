"""References: kinematics against an integrator, slews against their closed form, modes by hand."""

from typing import ClassVar

import equinox as eqx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gyrostat.control.guidance import (
    Condition,
    Fixed,
    Mode,
    Nadir,
    Reference,
    SlewLimits,
    SlewProfile,
    Slews,
    Table,
    WheelEnvelope,
    reference_at,
)
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import (
    error_angle,
    from_rotation_vector,
    product,
    rotation_vector,
    to_body,
    to_inertial,
)
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


def wobbling(time):
    """Smooth motion whose quaternion changes length and sign."""
    turn = jnp.array([0.5 * jnp.sin(0.3 * time), 0.1 * time, 0.4 * jnp.cos(0.2 * time)])
    sign = jnp.where(jnp.sin(0.7 * time) > 0.0, 1.0, -1.0)
    return sign * (2.0 + jnp.sin(time)) * from_rotation_vector(turn)


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
            jax.vmap(wobbling)(np.linspace(0.0, 40.0, 201))
            / (2.0 + np.sin(np.linspace(0.0, 40.0, 201)))[:, None],
        )
    ),
    "mode": MODES,
}


@pytest.mark.parametrize("name", MOTIONS)
def test_the_reported_rate_integrates_to_the_attitude(name):
    """Quaternion kinematics by DOP853 from the rate, and the rate from the acceleration."""
    start, end = 3.0, 34.0
    mode = Mode(jnp.array(2 if name == "mode" else 0), jnp.array(start))

    @jax.jit
    def both(time, state):
        motion = MOTIONS[name].at(mode, time)
        turned = product(state[:4], jnp.append(0.0, motion.rate))
        return motion, jnp.append(0.5 * turned, motion.acceleration)

    def slope(time, state):
        return both(np.float64(time), state)[1]  # one type of number, so that it is compiled once

    first, last = (both(np.float64(time), np.zeros(7))[0] for time in (start, end))
    begin, options = np.append(first.attitude, first.rate), {"rtol": 1e-11, "atol": 1e-12}
    solved = solve_ivp(slope, (start, end), begin, "DOP853", max_step=0.25, **options).y[:, -1]
    assert error_angle(jnp.asarray(solved[:4]), last.attitude) < 2e-8
    np.testing.assert_allclose(solved[4:], last.rate, atol=2e-8)


def test_nadir_points_to_the_earth_of_the_environment():
    for time in (0.0, 777.0, 5000.0):
        motion = reference_at(NADIR, time)
        np.testing.assert_allclose(
            to_body(motion.attitude, ORBIT.zenith(time)), [0.0, 0.0, -1.0], atol=1e-12
        )
        flown = (ORBIT.zenith(time + 1e-3) - ORBIT.zenith(time - 1e-3)) / 2e-3
        along = to_body(motion.attitude, flown / ORBIT.rate)
        np.testing.assert_allclose(along, np.array([1.0, 0.2, 0.0]) / np.hypot(1.0, 0.2), atol=1e-8)
        assert np.linalg.norm(motion.rate) == pytest.approx(ORBIT.rate, rel=1e-12)
        np.testing.assert_allclose(motion.acceleration, 0.0, atol=1e-15)


def test_parallel_axes_are_refused():
    with pytest.raises(InputError, match="parallel"):
        Nadir.pointing(ORBIT, [0.0, 0.0, 1.0], [0.0, 0.0, -2.0]).check()


@pytest.mark.parametrize(("what", "order"), [("attitude", 4), ("rate", 3), ("acceleration", 2)])
def test_a_table_converges_with_its_order(what, order):
    def smooth(time):
        return from_rotation_vector(
            jnp.array([0.5 * jnp.sin(0.3 * time), 0.1 * time, 0.4 * jnp.cos(0.2 * time)])
        )

    probes = np.linspace(10.0, 30.0, 1000)
    exact = jax.vmap(lambda t: reference_at(smooth, t))(probes)
    errors = []
    for rows in (81, 161):
        times = np.linspace(0.0, 40.0, rows)
        table = Table.of(times, jax.vmap(smooth)(times))
        found = jax.vmap(lambda t: reference_at(table, t))(probes)  # noqa: B023
        errors.append(np.max(np.abs(getattr(found, what) - getattr(exact, what))))
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
    attitude = reference_at(SLEWS, 300.0).attitude
    assert error_angle(attitude, jnp.array([0.0, 0.0, 0.6, -0.8])) < 1e-12
    assert ends[0] > 9.0, "the second begins during the first"
    turned = np.array([rotation_vector(reference_at(SLEWS, t).attitude) for t in (2.0, 5.0, 8.0)])
    np.testing.assert_allclose(turned[:, 1:], 0.0, atol=1e-15)


limits_of = eqx.filter_jit(lambda envelope, *slew: envelope.limits(*slew))
HELD = np.array([6e-3, -2e-3, 1e-3, 4e-3])


@pytest.mark.parametrize("momentum", [np.zeros(3), np.array([4e-3, -3e-3, 5e-3])])
@pytest.mark.parametrize("turn", [[0.0, 0.0, 2.0], [0.3, -0.2, 0.1], [2.0, 2.0, 1.0]])
def test_the_fastest_slew_saturates_a_limit_and_none_is_exceeded(turn, momentum):
    """Torque and momentum of every wheel along the slew, by the equations of motion."""
    turn = np.array(turn)
    angle = np.linalg.norm(turn)
    axis, start = turn / angle, from_rotation_vector(jnp.array([0.2, -0.5, 0.3]))
    total = np.asarray(to_inertial(start, jnp.asarray(momentum)))
    envelope = WheelEnvelope.of(CRAFT, total_momentum=total, wheel_momentum=HELD)
    rate, acceleration = map(float, limits_of(envelope, turn, start, 0.0))
    profile = _fastest(angle, rate, acceleration, np.inf)
    times = np.linspace(1e-9, 1.0 - 1e-9, 4001) * float(profile.duration)
    turned, speed, pushed = (np.asarray(x)[:, None] for x in motion_of(profile, times))
    body = np.asarray(
        jax.vmap(lambda x: to_body(from_rotation_vector(x * axis), jnp.asarray(momentum)))(
            turned[:, 0]
        )
    )
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
        jnp.asarray(attitude), jnp.array([rate, 0.0, 0.0]), speed * jnp.ones(4), jnp.ones(4, bool)
    )


def test_modes_follow_each_other_by_their_conditions():
    step = jax.jit(lambda *sample: MODES.step(*sample))
    mode = MODES.start()
    assert step(mode, measured(rate=0.005), 4.75).number == 0, "too early"
    assert step(mode, measured(rate=0.02), 6.0).number == 0, "too fast"
    mode = step(mode, measured(rate=0.005), 6.0)
    assert (int(mode.number), float(mode.start)) == (1, 6.0)
    end = 6.0 + float(mode.transition.duration)
    there = MODES.at(mode, end + 5.0).attitude
    assert step(mode, measured(attitude=MODES.at(mode, 8.0).attitude, speed=90.0), 8.0).number == 1
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
    mode = timed.step(timed.start(), None, 5.0)
    assert (int(mode.number), float(mode.start)) == (1, 5.0)
    assert timed.step(mode, None, 1e6).number == 1


def test_a_change_of_mode_has_no_step_in_attitude_rate_and_acceleration():
    """From nadir to a turning target and on, through slews with limited jerk."""
    for number, time in ((1, 6.0), (2, 71.0)):
        before = MODES.at(type(MODES.start())(jnp.array(number - 1), jnp.array(-1e3)), time)
        after = MODES.at(type(MODES.start())(jnp.array(number), jnp.array(time)), time)
        assert error_angle(before.attitude, after.attitude) < 1e-12
        np.testing.assert_allclose(before.rate, after.rate, atol=1e-12)
        np.testing.assert_allclose(before.acceleration, after.acceleration, atol=1e-12)


def test_references_that_cannot_work_are_refused():
    with pytest.raises(InputError, match="no slew limits"):
        Reference.sequence((Fixed(REST), Condition()), (NADIR, Condition()))
    with pytest.raises(InputError, match="no spacecraft"):
        Reference.sequence((Fixed(REST), Condition(momentum_above=1.0)))
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
