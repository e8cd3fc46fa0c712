"""Speed through zero crossings and stops, against closed forms and an independent integrator."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from gyrostat.core.jax64 import jax
from gyrostat.wheel import Wheel, speed_response, stepping
from gyrostat.wheel.friction import DirectionalStribeck, Stribeck, ViscousCoulomb

ASYMMETRIC = ((4e-6, 0.8e-3, 1.1e-3, 1.0), (6e-6, 0.95e-3, 1.2e-3, 1.0))


def held(time, knots, currents):
    """The current at the sample times, held from each knot on."""
    return currents[np.searchsorted(knots, time + 1e-9, side="right") - 1]


def test_profile_2_agrees_with_an_event_located_solution_and_converges_with_order_4(
    response, reference, paper, wheel, profile2
):
    knots, currents = profile2
    grid = np.arange(3001) * 0.1
    model = reference.symmetric(*paper)
    exact = model.speeds(grid, 0.0, knots, currents)
    assert len(model.zeros) == 9
    errors = {}
    for stride in (1, 2, 5, 10):
        time = np.arange(3000 * 10 // stride + 1) * 0.01 * stride
        speeds = response(wheel, time, held(time, knots, currents))
        errors[stride] = np.max(np.abs(speeds[:: 10 // stride] - exact))
    assert errors[1] < 2e-10
    assert errors[10] < 1e-6
    order = np.polyfit(np.log([*errors]), np.log([*errors.values()]), 1)[0]
    assert order == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize("symmetric", [True, False])
def test_linear_currents_with_crossings_and_sticking_agree_with_an_event_located_solution(
    response, reference, paper, wheel, symmetric
):
    """A sine with rests; each knot is a sample of every grid."""
    if symmetric:
        model, amplitude = reference.symmetric(*paper), 0.06
    else:
        model, amplitude = reference(paper[0], paper[1], *ASYMMETRIC), 0.085
        pairs = [v for pair in zip(*ASYMMETRIC, strict=True) for v in pair][:-1]
        wheel = Wheel(paper[0], paper[1], DirectionalStribeck(*pairs))
    knots = np.arange(0.0, 61.0)
    currents = amplitude * np.sin(2.0 * np.pi * knots / 17.0 + 0.2)
    grid = np.arange(6001) * 0.01
    exact = model.speeds(grid, -0.7, knots, currents, hold="linear")
    assert len(model.zeros) >= 6
    assert np.sum(exact == 0.0) > 100
    for stride, bound in ((1, 1e-9), (10, 1e-6), (50, 1e-4)):
        time = grid[::stride]
        speeds = response(wheel, time, np.interp(time, knots, currents), -0.7, hold="linear")
        assert np.max(np.abs(speeds - exact[::stride])) < bound


@pytest.mark.parametrize("limited", [True, False])
def test_error_falls_with_step_to_the_4th_through_crossings_without_the_segment_limit_too(
    monkeypatch, reference, limited
):
    """Strong viscous and Stribeck friction, a fast sine, the same straight lines for all steps.

    With the limit on the length of a segment switched off, only the location of the crossings
    and the Runge-Kutta steps between them are left.
    """
    parameters = (1.0, 1.0, 0.2, 0.3, 0.9, 2.5)
    knots = np.arange(0.0, 12.4, 0.4)
    currents = 2.0 * np.sin(1.7 * knots) + 0.1
    model = reference.symmetric(*parameters)
    exact = model.speeds(knots, 0.5, knots, currents, hold="linear")
    assert len(model.zeros) >= 5
    if not limited:
        monkeypatch.setattr(stepping, "_segment_limit", lambda *_: np.inf)
    wheel = Wheel(parameters[0], parameters[1], Stribeck(*parameters[2:]))
    splits = np.array([4, 8, 16, 32])
    time = np.linspace(0.0, 12.0, 30 * 32 + 1)
    solve = jax.jit(lambda t, i: speed_response(wheel, t, i, 0.5, hold="linear"))
    errors = []
    for split in splits:
        # every grid as long as the finest: what is not split further stands still at its end
        coarse = np.linspace(0.0, 12.0, 30 * split + 1)
        padded = np.pad(coarse, (0, len(time) - len(coarse)), mode="edge")
        speeds, resolved = solve(padded, np.interp(padded, knots, currents))
        assert bool(resolved)
        errors.append(np.max(np.abs(speeds[: len(coarse) : split] - exact)))
    errors = np.array(errors)
    assert np.all(errors > 1e-11)
    order = np.polyfit(np.log(1.0 / splits), np.log(errors), 1)[0]
    assert order == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"static": 0.5863},
        {"static": 0.06},
        {"static": 3.0},
        {"static": 1.2, "scale": 0.05},
        {"static": 1.2, "scale": 1e-3},
        {"viscous": 0.5},
        {"viscous": 20.0},
        {"viscous": 0.5, "initial": 420.0},
    ],
    ids=str,
)
@pytest.mark.parametrize("sense", [1, -1])
def test_a_coasting_wheel_stops_at_its_quadrature_time_and_then_rests(response, changes, sense):
    """Within 1e-5 s: the grid of full steps is laid so that a sample falls just before the stop,
    then just after it."""
    values = {"viscous": 0.00322, "coulomb": 0.5863, "static": 0.6037, "scale": 0.418879}
    values |= {"initial": 100.0 * np.pi / 30.0} | changes
    viscous, coulomb, static, scale, initial = values.values()
    wheel = Wheel(1.5e-3, 0.02, Stribeck(*(1.5e-3 * v for v in (viscous, coulomb, static)), scale))

    def slowness(speed):
        excess = (static - coulomb) * np.exp(-((speed / scale) ** 2))
        return 1.0 / (viscous * speed + coulomb + excess)

    edges = [0.0, *(share * scale for share in (0.3, 1.0, 2.0, 4.0, 6.5)), initial]
    stop = sum(quad(slowness, a, b, epsabs=1e-14)[0] for a, b in itertools.pairwise(edges))
    if static == coulomb:
        closed = np.log1p(viscous * initial / coulomb) / viscous
        assert stop == pytest.approx(closed, abs=1e-11)
    for step in (0.01, 0.1, 0.37, 0.5):
        for offset in (-1e-5, 1e-5):
            last = stop + offset
            full = np.arange(last, 0.0, -step)[::-1]
            time = np.concatenate([[0.0], full, last + np.arange(1, 5) * step])
            speeds = response(wheel, time, np.zeros(len(time)), sense * initial) * sense
            assert np.all(np.diff(speeds) <= 0.0)
            assert (speeds[len(full)] > 0.0) == (offset < 0.0)
            assert np.all(speeds[len(full) + 1 :] == 0.0)


def first_return(height, rate, bend):
    """Smallest t > 0 with height + rate t + bend t² / 2 = 0, or infinity."""
    if height == 0.0:
        return -2.0 * rate / bend if rate * bend < 0.0 else np.inf
    square = rate**2 - 2.0 * bend * height
    if square < 0.0:
        return np.inf
    both = -rate - np.copysign(np.sqrt(square), rate)
    roots = [both / bend if bend else np.inf, 2.0 * height / both if both else np.inf]
    return min([root for root in roots if root > 0.0], default=np.inf)


def coulomb_wheel(durations, torques, coulomb, initial):
    """Speeds, up to rounding, of unit inertia with Coulomb friction under straight lines of torque.

    Every phase is a parabola, so this is exact.
    """
    speeds = [initial]
    speed = initial
    for left, torque, after in zip(durations, torques[:-1], torques[1:], strict=True):
        slope = (after - torque) / left if left > 0.0 else 0.0
        while left > 0.0:
            sense = np.sign(speed) or np.sign(torque)
            rate = torque - sense * coulomb
            if speed == 0.0 and abs(torque) <= coulomb:
                wait = (np.sign(slope) * coulomb - torque) / slope if slope else np.inf
                if wait >= left:
                    break
                left, torque, sense, rate = left - wait, torque + slope * wait, np.sign(slope), 0.0
            back = first_return(sense * speed, sense * rate, sense * slope)
            if back >= left:
                speed += rate * left + 0.5 * slope * left**2
                break
            left, torque, speed = left - back, torque + slope * back, 0.0
        speeds.append(speed)
    return np.array(speeds)


# round numbers meet at the same instant what should: stops at samples, torques at the limit
ROUND = st.sampled_from([-3.0, -2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.25, 2.0])
ANY = st.floats(-3.0, 3.0).filter(lambda x: x == 0.0 or abs(x) > 1e-6)
INTERVALS = 16


@settings(max_examples=300)
@given(
    st.lists(st.one_of(ROUND, ANY), min_size=INTERVALS + 1, max_size=INTERVALS + 1),
    st.lists(
        st.sampled_from([0.0, 0.1, 0.25, 0.5, 1.0, 3.0]), min_size=INTERVALS, max_size=INTERVALS
    ),
    st.one_of(ROUND, ANY),
)
def test_coulomb_friction_under_straight_lines_of_torque_is_exact(
    response, torques, durations, initial
):
    """Dips through zero and back, two crossings in an interval, stops at its end: all exact."""
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=ViscousCoulomb(0.0, 1.0))
    time = np.concatenate([[0.0], np.cumsum(durations)])
    durations = np.diff(time)
    speeds = response(wheel, time, np.array(torques), initial, hold="linear")
    exact = coulomb_wheel(durations, np.array(torques), 1.0, initial)
    np.testing.assert_allclose(speeds, exact, rtol=0.0, atol=2e-12)


def test_two_crossings_inside_one_interval_are_exact(response):
    """Torque from -1 to 1 against friction 0.1: down through zero, and up through it again."""
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=ViscousCoulomb(0.0, 0.1))
    first = 1.1 - np.sqrt(1.1**2 - 2.0 * 0.3)
    second = 2.0 * 0.9 - first
    end = 0.5 * ((2.0 - 1.1) ** 2 - (second - 1.1) ** 2)
    speeds = response(wheel, [0.0, 2.0], [-1.0, 1.0], 0.3, hold="linear")
    assert speeds[-1] == pytest.approx(end, abs=1e-14)


def test_a_speed_that_nearly_touches_zero_inside_an_interval_is_exact(response):
    """Where Newton's method converges slowly, on either side of the tangent."""
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=ViscousCoulomb(0.0, 0.1))
    for share in np.concatenate([[0.0], *(np.array([-1, 1]) * 10.0**-k for k in range(1, 16))]):
        initial = 0.5 * 0.6**2 * (1.0 + share)
        for current in ([-0.5, 1.5], [-0.5, 0.5]):
            durations = [1.0 if current[1] == 0.5 else 2.0]
            exact = coulomb_wheel(durations, np.array(current), 0.1, initial)
            speeds = response(wheel, [0.0, *durations], current, initial, hold="linear")
            assert speeds[-1] == pytest.approx(exact[-1], abs=1e-10)


@pytest.mark.parametrize("margin", [1e-6, 1e-3, 0.1])
def test_a_wheel_that_leaves_slowly_on_a_steep_stribeck_curve_is_resolved(
    response, reference, margin
):
    """Just above T_s the wheel hardly moves, then runs away: the steps must foresee it."""
    parameters = (1.0, 1.0, 0.0, 0.6, 1.8, 0.2)
    time = np.arange(0.0, 7.0, 0.5)
    current = np.full(len(time), 1.8 * (1.0 + margin))
    model = reference.symmetric(*parameters)
    exact = model.speeds(time, 0.0, np.array([0.0, 6.5]), current[:2])
    wheel = Wheel(parameters[0], parameters[1], Stribeck(*parameters[2:]))
    assert np.max(np.abs(response(wheel, time, current) - exact)) < 2e-5
