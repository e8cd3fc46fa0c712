"""Thousands of wheels at once, and what must hold for any wheel under any current."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Wheel, advance, segment, speed_response
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

SAMPLES = 64


@pytest.mark.optimised  # thousands of runs take longer than one program takes to compile
@pytest.mark.parametrize("hold", ["zero-order", "linear"])
def test_thousands_of_wheels_under_vmap_equal_the_single_runs(hold):
    """2000 random wheels and currents; inertia 1, so speeds are of the order of 1 to 10."""
    random = np.random.default_rng(0)
    count = 2000
    lanes = {
        "motor_constant": random.uniform(0.5, 2.0, count),
        "viscous": random.choice([0.0, 0.01, 0.5], count),
        "coulomb": random.uniform(0.1, 1.0, count),
        "static": random.uniform(0.05, 1.5, count),
        "stribeck_speed": random.uniform(0.05, 2.0, count),
        "initial": random.choice([0.0, -1.0, 2.0], count),
    }
    values = np.stack([*lanes.values()], axis=1)
    time = np.cumsum(random.choice([0.0, 0.05, 0.2], (count, SAMPLES)), axis=1)
    current = np.repeat(random.uniform(-1.5, 1.5, (count, SAMPLES // 8)), 8, axis=1)

    def run(values, time, current):
        wheel = Wheel(1.0, values[0], Stribeck(*values[1:-1]))
        return speed_response(wheel, time, current, values[-1], hold=hold)

    @jax.jit
    def both(*lanes):
        return jax.vmap(run)(*lanes), jax.lax.map(lambda lane: run(*lane)[0], lanes)

    (together, resolved), alone = both(values, time, current)
    assert np.all(resolved)
    assert 0.05 < np.mean(np.asarray(together) == 0.0) < 0.5
    np.testing.assert_allclose(together, alone, rtol=0.0, atol=1e-12)


def test_one_step_is_the_same_compiled_and_not(wheel):
    start = (np.float64(0.3), np.float64(-0.1), np.float64(0.05), np.float64(0.5))
    plain, compiled = advance(wheel, *start), jax.jit(advance)(wheel, *start)
    assert float(plain.speed) == pytest.approx(float(compiled.speed), rel=1e-13)
    assert bool(plain.resolved)
    assert bool(compiled.resolved)


positive = st.floats(-1.0, 1.0).map(lambda exponent: 10.0**exponent)
level = st.one_of(st.sampled_from([-1.0, 0.0, 1.0]), st.floats(-3.0, 3.0))
currents = st.lists(level, min_size=SAMPLES, max_size=SAMPLES)
frictions = st.builds(
    lambda viscous, coulomb, share, scale: Stribeck(viscous, coulomb, share * coulomb, scale),
    st.one_of(st.just(0.0), st.floats(0.0, 2.0)),
    positive,
    st.one_of(st.just(1.0), st.floats(0.1, 3.0)),
    positive,
)
wheels = st.builds(Wheel, positive, positive, frictions)


@given(wheels, st.floats(-30.0, 30.0), st.sampled_from([0.01, 0.3, 2.0]))
def test_without_current_the_energy_never_grows_and_the_speed_never_passes_zero(
    response, wheel, initial, step
):
    time = np.arange(SAMPLES) * step
    speeds = response(wheel, time, np.zeros(SAMPLES), initial)
    assert np.all(np.diff(speeds**2) <= 0.0)
    assert np.all(speeds * np.sign(initial) >= 0.0)
    at_rest = speeds == 0.0
    assert np.all(at_rest[np.argmax(at_rest) :]) or not np.any(at_rest)


@given(wheels, st.floats(-9.0, 9.0), currents, st.sampled_from(["zero-order", "linear"]))
def test_the_mirror_image_and_another_unit_of_torque_change_nothing(
    response, wheel, initial, current, hold
):
    time, current = np.arange(SAMPLES) * 0.1, np.array(current)
    speeds = response(wheel, time, current, initial, hold)
    np.testing.assert_array_equal(response(wheel, time, -current, -initial, hold), -speeds)
    for factor, tolerance in ((2.0**-40, 0.0), (2.0**40, 0.0)):
        friction = wheel.friction
        torques = (factor * v for v in (friction.viscous, friction.coulomb, friction.static))
        scaled = Wheel(
            factor * wheel.inertia,
            factor * wheel.motor_constant,
            Stribeck(*torques, friction.stribeck_speed),
        )
        np.testing.assert_allclose(
            response(scaled, time, current, initial, hold), speeds, rtol=tolerance, atol=tolerance
        )


@given(st.floats(0.0, 2.0), st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), currents)
def test_without_stribeck_effect_two_wheels_under_one_current_never_diverge(
    response, viscous, first, second, current
):
    """Viscous and Coulomb friction are monotone in speed: the flow contracts, rest included."""
    wheel = Wheel(1.0, 1.0, ViscousCoulomb(viscous, 0.7))
    time, current = np.arange(SAMPLES) * 0.2, np.array(current)
    runs = [response(wheel, time, current, initial, "linear") for initial in (first, second)]
    distance = np.abs(runs[0] - runs[1])
    # the step error itself, where viscous friction is strong
    assert np.all(np.diff(distance) <= 1e-6 + 1e-9 * distance[:-1])


@given(wheels, st.floats(-9.0, 9.0), level, st.floats(0.0, 1.0), st.floats(0.01, 0.5))
def test_splitting_an_interval_changes_the_speed_only_by_the_error_of_a_step(
    response, wheel, initial, current, share, step
):
    whole = np.arange(5) * step
    split = np.sort(np.concatenate([whole, whole[:-1] + share * step]))
    one = response(wheel, whole, np.full(5, current), initial)
    two = response(wheel, split, np.full(9, current), initial)
    # in terms of the largest rate there was
    rate = (3.0 * wheel.motor_constant + 6.0 * wheel.friction.coulomb) / wheel.inertia
    assert abs(one[-1] - two[-1]) < 2e-4 * rate * step


magnitude = st.floats(-4.0, 4.0).map(lambda exponent: 10.0**exponent)


@given(
    magnitude,
    st.one_of(st.just(0.0), magnitude, magnitude.map(lambda x: -x)),
    st.one_of(st.just(0.0), magnitude),
    st.one_of(st.just(0.0), magnitude),
    st.sampled_from([0.0, -1e-3, -1.0, 0.1, 0.999, 1.0, 1.001, 10.0, 1e6]),
    st.sampled_from([1e-4, 1e-2, 1.0, 1e4]),
    st.sampled_from([0.0, 1e-300, 1e-12, -1e-3, 1.0, -1e3]),
    st.lists(level, min_size=8, max_size=8),
    st.lists(st.sampled_from([0.0, 1e-9, 1e-3, 0.1, 1.0]), min_size=8, max_size=8),
    st.sampled_from(["zero-order", "linear"]),
)
@example(1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, [1.0] * 8, [0.1] * 8, "linear")
@example(1e-4, 1e4, 1e4, 1e4, 1e6, 1e-4, 1e3, [3.0, -3.0] * 4, [1.0] * 8, "linear")
@example(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, [1.0] * 8, [1.0] * 8, "linear")
@example(1.0, 1.0, 0.0, 1.0, -1.0, 1.0, 0.0, [0.0, 1.0] * 4, [0.1] * 8, "linear")
def test_any_wheel_comes_to_an_end_with_finite_speeds(
    inertia, motor, viscous, coulomb, share, scale, initial, current, steps, hold
):
    """T_s below, at and above c, or negative; narrow bands; no friction; steps of no length.

    An interval that would need too many segments is called so: it is cut, not wrong unseen.
    """
    curve = {"viscous": viscous, "coulomb": coulomb, "static": share * coulomb}
    wheel = Wheel(inertia, motor, Stribeck.of(**curve, stribeck_speed=scale))
    wheel = jax.tree.map(np.float64, wheel)
    speeds, resolved = SPEEDS(wheel, np.cumsum(steps), np.array(current), initial, hold=hold)
    assert np.all(np.isfinite(speeds))
    assert resolved.dtype == bool


SPEEDS = jax.jit(speed_response, static_argnames="hold")


def test_a_wheel_too_stiff_for_its_sampling_is_called_unresolved():
    """A mechanical time constant of 1 ns and samples of 10 s."""
    wheel = Wheel(1e-9, 1.0, ViscousCoulomb(1.0, 0.1))
    speeds, resolved = SPEEDS(wheel, np.array([0.0, 10.0, 20.0]), np.ones(3), 0.0)
    assert not bool(resolved)
    assert np.all(np.isfinite(speeds))
    assert segment.MAX_SEGMENTS <= 1000


@pytest.mark.parametrize("place", ["speed", "current", "friction"])
@pytest.mark.parametrize("hold", ["zero-order", "linear"])
def test_what_is_not_a_number_comes_out_as_unresolved(place, hold):
    coulomb = np.nan if place == "friction" else 0.1
    wheel = Wheel(1.0, 1.0, ViscousCoulomb.of(viscous=0.0, coulomb=coulomb))
    wheel = jax.tree.map(np.float64, wheel)
    time, current = np.arange(4.0), np.full(4, np.nan if place == "current" else 1.0)
    initial = np.float64(np.nan if place == "speed" else 1.0)
    assert not bool(SPEEDS(wheel, time, current, initial, hold=hold)[1])


def test_intervals_of_no_length_and_uneven_times_change_nothing(response, wheel):
    random = np.random.default_rng(5)
    time = np.sort(random.uniform(0.0, 20.0, 60))
    time[0], time[-1] = 0.0, 20.0
    current = 0.1 * np.sign(np.sin(time))
    twice = response(wheel, np.repeat(time, 2), np.repeat(current, 2), 1.0)
    once = response(wheel, time, current, 1.0)
    np.testing.assert_array_equal(twice[::2], once)
    np.testing.assert_array_equal(twice[1::2], once)


def test_a_current_that_jumps_at_one_instant_takes_the_later_value(response):
    wheel = Wheel(1.0, 1.0, ViscousCoulomb(0.0, 0.0))
    for hold in ("zero-order", "linear"):
        speeds = response(wheel, [0.0, 1.0, 1.0, 2.0], [1.0, 1.0, -3.0, -3.0], 0.0, hold)
        np.testing.assert_allclose(speeds, [0.0, 1.0, 1.0, -2.0], atol=1e-15)


def test_a_single_sample_is_the_initial_speed(wheel):
    speeds, resolved = SPEEDS(wheel, np.zeros(1), np.ones(1), -3.0)
    assert speeds.tolist() == [-3.0]
    assert bool(resolved)


def test_an_unknown_hold_is_refused(wheel):
    with pytest.raises(ValueError, match="found 'cubic', expected 'zero-order' or 'linear'"):
        speed_response(wheel, jnp.arange(2.0), jnp.zeros(2), 0.0, hold="cubic")  # pyright: ignore
