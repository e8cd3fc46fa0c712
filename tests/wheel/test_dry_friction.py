"""Sticking, breakaway, crossings and stops, against closed forms and an independent integrator."""

import dataclasses
import importlib.util
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from gyrostat._jax import jax, jnp
from gyrostat.friction import DirectionalStribeck, Stribeck, ViscousCoulomb
from gyrostat.wheel import Wheel, speed_response

_spec = importlib.util.spec_from_file_location(
    "reference", Path(__file__).with_name("reference.py")
)
reference = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(reference)

INERTIA, MOTOR = 1.5e-3, 0.0228
STRIBECK = (4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)


def one_wheel(friction):
    return Wheel(inertia=INERTIA, motor_constant=MOTOR, friction=friction)


ASYMMETRIC = DirectionalStribeck(4e-6, 6e-6, 0.8e-3, 0.95e-3, 1.1e-3, 1.2e-3, 1.0)


@pytest.mark.parametrize("friction", [Stribeck(*STRIBECK), ViscousCoulomb(4e-6, 9e-4), ASYMMETRIC])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_at_rest_it_stays_exactly_at_rest_up_to_the_breakaway_torque(response, friction, sense):
    # a motor constant that is a power of two makes k_m I = T_s exact
    wheel = Wheel(inertia=INERTIA, motor_constant=2.0**-5, friction=friction)
    level = float(friction.breakaway_torque(sense)) / 2.0**-5
    time = np.arange(101) * 0.1
    for share, moves in ((0.5, False), (1.0, False), (1.0 + 1e-12, True), (1.5, True)):
        speeds = response(wheel, time, np.full(101, sense * level * share))
        assert np.all(sense * speeds[1:] > 0.0) if moves else np.all(speeds == 0.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_ramp_breaks_away_when_its_torque_reaches_the_static_torque(response, wheel, sense):
    """With T_s = c and no viscous friction the speed is a parabola from the breakaway on."""
    level = 9e-4
    wheel = one_wheel(ViscousCoulomb(0.0, level))
    slope = sense * 0.004
    breakaway = level / (MOTOR * abs(slope))
    for step in (0.01, 0.3, 7.0):
        time = np.arange(0.0, 21.0, step)
        speeds = response(wheel, time, slope * time, hold="linear")
        expected = 0.5 * MOTOR * slope / INERTIA * np.maximum(time - breakaway, 0.0) ** 2
        np.testing.assert_allclose(speeds, expected, atol=1e-12)


def test_profile_2_agrees_with_an_event_located_solution(response, wheel, profile2):
    time, current = profile2(0.01)
    exact = reference.held_current_response(STRIBECK, INERTIA, MOTOR, time, current, 0.0)
    moving = exact[exact != 0.0]
    assert np.sum(np.sign(moving[1:]) != np.sign(moving[:-1])) == 9
    assert np.max(np.abs(response(wheel, time, current) - exact)) < 1e-6
    assert np.max(np.abs(response(wheel, time, current) - exact)) < 1e-9
    for stride, bound in ((10, 1e-6), (50, 1e-5)):
        coarse = response(wheel, time[::stride], current[::stride])
        assert np.max(np.abs(coarse - exact[::stride])) < bound


def test_error_falls_with_the_fourth_power_of_the_step_through_crossings(response):
    """A fast sine through several crossings; the curve is smooth, so no segment is shortened."""
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=ViscousCoulomb(0.2, 0.1))

    def solve(step):
        time = np.arange(round(12.0 / step) + 1) * step
        knots = np.arange(25) * 0.5
        drive = np.interp(time, knots, np.cos(1.3 * knots))
        speeds = response(wheel, time, drive, 0.1, hold="linear")
        return speeds[:: round(0.5 / step)]

    exact = solve(1.0 / 1024)
    assert np.sum(exact[1:] * exact[:-1] < 0.0) >= 3
    steps = np.array([1.0 / 2, 1.0 / 4, 1.0 / 8, 1.0 / 16])
    errors = np.array([np.max(np.abs(solve(h) - exact)) for h in steps])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(errors > 1e-13)
    assert np.median(orders) == pytest.approx(4.0, abs=0.4)


@pytest.mark.parametrize("step", [0.01, 0.1, 0.37, 0.5])
@pytest.mark.parametrize("initial", [100.0 * np.pi / 30.0, -100.0 * np.pi / 30.0])
def test_a_coasting_wheel_stops_at_its_analytic_time(response, step, initial):
    viscous, coulomb = 0.00322, 0.5863
    wheel = one_wheel(ViscousCoulomb(viscous * INERTIA, coulomb * INERTIA))
    stop = np.log1p(viscous * abs(initial) / coulomb) / viscous
    _stops_between(response, wheel, initial, stop, step)


@pytest.mark.parametrize("step", [0.01, 0.1, 0.37, 0.5])
@pytest.mark.parametrize("static", [0.8795e-3, 1.4e-3, 0.5e-3])
def test_a_coasting_wheel_with_stribeck_friction_stops_at_its_quadrature_time(
    response, step, static
):
    parameters = (4.83e-6, 0.8795e-3, static, 0.418879)
    initial = 5.0

    def slowness(speed):
        return INERTIA / reference.friction(parameters, speed, 1.0)

    stop = sum(quad(slowness, a, b, epsabs=1e-13)[0] for a, b in ((0.0, 0.8), (0.8, 5.0)))
    _stops_between(response, one_wheel(Stribeck(*parameters)), initial, stop, step)


def _stops_between(response, wheel, initial, stop, step):
    """Sample just before and just after the stop, with steps of the given size up to there."""
    before, after = stop - 1e-5, stop + 1e-5
    time = np.concatenate([np.arange(0.0, before, step), [before, after], after + np.arange(1, 9)])
    speeds = response(wheel, time, np.zeros(len(time)), initial)
    at = np.searchsorted(time, before)
    assert speeds[at] * np.sign(initial) > 0.0
    assert np.all(speeds[at + 1 :] == 0.0)


def test_a_dip_through_zero_inside_one_interval_is_seen(response):
    """The torque turns round within the interval: down through zero, at rest, and up again."""
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=ViscousCoulomb(0.0, 0.1))
    # from -1 to +1 in 2 s: w = w0 - 1.1 t + t²/2 while it turns forward
    stop = 1.1 - np.sqrt(1.1**2 - 2.0 * 0.3)
    # backwards: -0.9 at most; the speed then follows -0.9 t' + t'²/2 with its own crossing
    coarse = response(wheel, [0.0, 2.0], [-1.0, 1.0], 0.3, hold="linear")
    fine_time = np.linspace(0.0, 2.0, 2001)
    fine = response(wheel, fine_time, fine_time - 1.0, 0.3, hold="linear")
    assert fine_time[np.argmax(fine <= 0.0)] == pytest.approx(stop, abs=2e-3)
    assert coarse[-1] == pytest.approx(fine[-1], abs=1e-9)


@pytest.mark.parametrize("friction", ["stribeck", "directional"])
def test_sensitivities_agree_with_central_differences_through_crossings(friction, profile2, wheel):
    time, current = (jnp.asarray(v) for v in profile2(0.02, 120.0))
    model = {"stribeck": Stribeck(*STRIBECK), "directional": ASYMMETRIC}[friction]
    values = jnp.array([INERTIA, MOTOR, *model.parameters().values(), 0.5])

    @jax.jit
    def speeds(x):
        wheel = Wheel(inertia=x[0], motor_constant=x[1], friction=type(model)(*x[2:-1]))
        return speed_response(wheel, time, current, x[-1])[0]

    slopes = np.asarray(jax.jit(jax.jacfwd(speeds))(values))
    assert np.sum(np.diff(np.sign(np.asarray(speeds(values))[1:])) != 0) >= 3
    for k in range(len(values)):
        agreement = []
        for relative in (3e-3, 1e-3, 3e-4, 1e-4):
            step = relative * float(values[k])
            shift = [np.asarray(speeds(values.at[k].add(n * step))) for n in (-2, -1, 1, 2)]
            difference = (shift[0] - 8.0 * shift[1] + 8.0 * shift[2] - shift[3]) / (12.0 * step)
            # a sample that a crossing passes while it is moved has no derivative to compare
            smooth = np.abs(np.asarray(speeds(values))) > 0.05
            error = np.abs(difference - slopes[:, k])[smooth]
            agreement.append(np.max(error) / np.max(np.abs(slopes[:, k])))
        assert min(agreement) < 1e-6, (k, agreement)


def test_a_sensitivity_jumps_by_the_ratio_of_the_accelerations(response):
    """Coulomb wheel, no viscous friction: everything is a straight line and known."""
    coulomb, torque, initial = 0.2, -0.5, 1.0

    def end(x):
        wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=ViscousCoulomb(0.0, x[0]))
        return speed_response(wheel, jnp.array([0.0, 5.0]), jnp.full(2, torque), x[1])[0][-1]

    before, after = torque - coulomb, torque + coulomb
    crossing = -initial / before
    slopes = jax.jacfwd(end)(jnp.array([coulomb, initial]))
    assert end(jnp.array([coulomb, initial])) == pytest.approx(after * (5.0 - crossing), abs=1e-13)
    assert slopes[1] == pytest.approx(after / before, abs=1e-13)
    expected = (5.0 - crossing) + after * initial / before**2
    assert slopes[0] == pytest.approx(expected, abs=1e-12)


def test_sticking_forgets_where_the_wheel_came_from(wheel):
    time, current = jnp.arange(0.0, 30.0, 0.1), jnp.zeros(300)

    def end(initial):
        return speed_response(wheel, time, current, initial)[0][-1]

    assert jax.jvp(end, (2.0,), (1.0,)) == (0.0, 0.0)


def test_thousands_under_vmap_equal_single_runs(wheel):
    random = np.random.default_rng(0)
    count = 2000
    factor = random.uniform(0.5, 2.0, (6, count))
    wheels = Wheel(
        inertia=INERTIA * factor[0],
        motor_constant=MOTOR * factor[1],
        friction=Stribeck(*(v * f for v, f in zip(STRIBECK, factor[2:], strict=True))),
    )
    time = jnp.arange(0.0, 12.0, 0.1)
    current = 0.08 * jnp.sign(jnp.sin(time))
    many = jax.jit(jax.vmap(lambda w: speed_response(w, time, current, 1.0)[0]))(wheels)
    single = jax.jit(lambda w: speed_response(w, time, current, 1.0)[0])
    for k in range(0, count, 100):
        lane = jax.tree.map(lambda v, k=k: v[k], wheels)
        np.testing.assert_allclose(many[k], single(lane), rtol=0.0, atol=1e-12)


positive = st.floats(-3.0, 3.0).map(lambda e: 10.0**e)


@settings(max_examples=150, deadline=None)
@given(positive, positive, st.floats(0.0, 3.0), st.floats(-0.2, 4.0), positive, st.data())
def test_any_wheel_gives_a_finite_answer_or_says_that_it_cannot(
    inertia, coulomb, viscous, static, scale, data
):
    numbers = st.floats(-5.0, 5.0)
    steps = data.draw(st.lists(st.sampled_from([0.0, 1e-3, 0.1, 1.0]), min_size=7, max_size=7))
    current = np.array(data.draw(st.lists(numbers, min_size=8, max_size=8)))
    initial = data.draw(st.sampled_from([0.0, 1e-9, -2.0, 3.0]))
    wheel = Wheel(inertia, 1.0, Stribeck(viscous, coulomb, static * coulomb, scale))
    time = np.concatenate([[0.0], np.cumsum(steps)])
    for hold in ("zero-order", "linear"):
        # hypothesis drives one compiled function for each hold
        speeds, resolved = FUZZED(wheel, time, current, initial, hold=hold)
        assert np.all(np.isfinite(speeds)) or not bool(resolved)


FUZZED = jax.jit(speed_response, static_argnames="hold")


@settings(max_examples=60, deadline=None)
@given(st.floats(-30.0, 30.0), st.floats(0.0, 1e-3), st.floats(1e-4, 2e-3), st.floats(0.1, 3.0))
def test_energy_never_grows_without_current_and_speed_never_overshoots(
    initial, viscous, coulomb, ratio
):
    wheel = one_wheel(Stribeck(viscous, coulomb, ratio * coulomb, 0.4))
    speeds, resolved = FUZZED(wheel, np.arange(40) * 0.5, np.zeros(40), initial, hold="zero-order")
    assert bool(resolved)
    size = np.abs(np.asarray(speeds))
    assert np.all(size[1:] <= size[:-1])
    assert np.all(np.asarray(speeds) * initial >= 0.0)


@settings(max_examples=30, deadline=None)
@given(st.floats(-9.0, 9.0), st.integers(0, 1000))
def test_mirror_and_scale_symmetries(initial, seed):
    random = np.random.default_rng(seed)
    time, current = np.arange(60) * 0.2, 0.15 * random.standard_normal(60)
    wheel = one_wheel(Stribeck(*STRIBECK))
    plain = np.asarray(FUZZED(wheel, time, current, initial, hold="zero-order")[0])
    mirrored = np.asarray(FUZZED(wheel, time, -current, -initial, hold="zero-order")[0])
    np.testing.assert_array_equal(mirrored, -plain)
    # all torques and the inertia times four, exactly
    friction = Stribeck(*(4.0 * v for v in STRIBECK[:3]), STRIBECK[3])
    heavy = dataclasses.replace(
        wheel, inertia=4.0 * INERTIA, motor_constant=4.0 * MOTOR, friction=friction
    )
    np.testing.assert_allclose(
        FUZZED(heavy, time, current, initial, hold="zero-order")[0], plain, rtol=1e-13, atol=1e-15
    )


def test_a_wheel_that_cannot_be_resolved_says_so():
    time = jnp.array([0.0, 10.0])
    stiff = Wheel(1e-9, 1.0, ViscousCoulomb(1.0, 0.1))
    assert not bool(speed_response(stiff, time, jnp.array([1.0, 1.0]), 0.0)[1])


def test_unknown_hold_is_refused(wheel):
    with pytest.raises(ValueError, match="zero-order"):
        speed_response(wheel, jnp.arange(2.0), jnp.zeros(2), 0.0, hold="cubic")


def test_linear_sine_with_sticking_agrees_with_an_event_located_solution(response, wheel):
    """One long sine: breakaway by ramp, turning, stop; each phase solved on its own by scipy."""
    level, amplitude, period = STRIBECK[2] / MOTOR, 0.09, 40.0
    time = np.arange(0.0, 24.0, 0.001)
    current = amplitude * np.sin(2.0 * np.pi * time / period)
    speeds = response(wheel, time, current, hold="linear")
    breakaway = np.arcsin(level / amplitude) * period / (2.0 * np.pi)

    def rate(t, speed):
        drive = MOTOR * amplitude * np.sin(2.0 * np.pi * t / period)
        return (drive - reference.friction(STRIBECK, speed, 1.0)) / INERTIA

    done = solve_ivp(
        rate,
        (breakaway, 24.0),
        [0.0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        max_step=0.01,
        dense_output=True,
    )
    resting = time < breakaway
    assert np.all(speeds[resting] == 0.0)
    # the sampled sine is a chord of the true one: its error is of the second order in 1 ms
    turning = (~resting) & (done.sol(time)[0] > 0.0)
    np.testing.assert_allclose(speeds[turning], done.sol(time[turning])[0], atol=2e-6)
