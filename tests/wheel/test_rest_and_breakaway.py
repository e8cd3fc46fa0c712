"""The wheel at rest: it holds up to the breakaway torque, to the last bit, and leaves above it."""

import numpy as np
import pytest

from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Wheel, advance
from gyrostat.wheel.friction import DirectionalStribeck, Stribeck, ViscousCoulomb

# With a motor constant that is a power of two, k_m I = T_s can be met exactly.
MOTOR_CONSTANT = 2.0**-5
FRICTIONS = [
    ViscousCoulomb(viscous=5e-6, coulomb=9e-4),
    Stribeck(viscous=5e-6, coulomb=9e-4, static=1.1e-3, stribeck_speed=0.4),
    Stribeck(viscous=5e-6, coulomb=9e-4, static=7e-4, stribeck_speed=0.4),
    DirectionalStribeck(
        viscous_positive=4e-6,
        viscous_negative=6e-6,
        coulomb_positive=8e-4,
        coulomb_negative=9.5e-4,
        static_positive=1.1e-3,
        static_negative=1.2e-3,
        stribeck_speed=1.0,
    ),
]
STATIC = [
    {1: 9e-4, -1: 9e-4},
    {1: 1.1e-3, -1: 1.1e-3},
    {1: 7e-4, -1: 7e-4},
    {1: 1.1e-3, -1: 1.2e-3},
]
each_friction = pytest.mark.parametrize(
    ("friction", "static"), [*zip(FRICTIONS, STATIC, strict=True)]
)
each_sense = pytest.mark.parametrize("sense", [1, -1])


@each_sense
@each_friction
def test_rests_up_to_the_static_torque_included_and_leaves_one_bit_above(
    response, friction, static, sense
):
    wheel = Wheel(inertia=1.5e-3, motor_constant=MOTOR_CONSTANT, friction=friction)
    level = sense * static[sense] / MOTOR_CONSTANT
    time = np.arange(64) * 0.1
    for current in (0.5 * level, np.nextafter(level, 0.0), level):
        assert np.all(response(wheel, time, np.full(64, current)) == 0.0)
    for current in (level + np.spacing(level), 1.01 * level, 3.0 * level):
        speeds = response(wheel, time, np.full(64, current))
        assert np.all(sense * np.diff(speeds) > 0.0)


def test_at_any_scale_the_rule_is_that_of_the_rounded_product():
    """Torques within three units in the last place of T_s: k_m I <= T_s rests, the others leave."""
    random = np.random.default_rng(3)
    count = 4000
    inertia, motor = 10 ** random.uniform(-6, 0, count), 10 ** random.uniform(-3, 1, count)
    coulomb, scale = 10 ** random.uniform(-5, 0, count), 10 ** random.uniform(-2, 1, count)
    static = coulomb * random.choice([0.5, 1.0, 1.0001, 1.3], count)
    current = static / motor
    current += np.spacing(current) * random.integers(-3, 4, count)

    def step(inertia, motor, coulomb, static, scale, current):
        return advance(
            Wheel(inertia, motor, Stribeck(0.0, coulomb, static, scale)), 0.0, current, 0.0, 0.3
        )

    done = jax.jit(jax.vmap(step))(inertia, motor, coulomb, static, scale, current)
    assert np.all(done.resolved)
    leaves = motor * current > static
    assert 0.3 < np.mean(leaves) < 0.7
    np.testing.assert_array_equal(np.asarray(done.speed) > 0.0, leaves)
    np.testing.assert_array_equal(np.asarray(done.speed) == 0.0, ~leaves)


@each_sense
def test_a_ramp_breaks_away_when_its_torque_reaches_the_static_torque(response, sense):
    """With T_s = c and no viscous friction the speed is a parabola from then on."""
    level, inertia, motor = 9e-4, 1.5e-3, 0.0228
    wheel = Wheel(inertia=inertia, motor_constant=motor, friction=ViscousCoulomb(0.0, level))
    slope = 0.004 * sense
    breakaway = level / (motor * abs(slope))
    uneven = np.cumsum(np.random.default_rng(0).uniform(0.0, 1.0, 64)) - 0.3
    for time in (np.arange(0.0, 20.0, 0.05), np.arange(0.0, 35.0, 7.0), uneven):
        speeds = response(wheel, time, slope * time, hold="linear")
        since = np.maximum(time - breakaway, 0.0)
        assert np.all(speeds[since == 0.0] == 0.0)
        np.testing.assert_allclose(speeds, 0.5 * motor * slope / inertia * since**2, atol=1e-12)


def test_a_falling_ramp_goes_from_one_breakaway_level_to_the_other(response):
    """At T_s exactly, then down: the wheel rests all the way to -T_s of the other sense."""
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=FRICTIONS[3])
    time = np.arange(0.0, 30.0, 0.5)
    current = 1.1e-3 - 1e-4 * time
    leaves = (1.1e-3 + 1.2e-3) / 1e-4
    speeds = response(wheel, time, current, hold="linear")
    assert np.all(speeds[time <= leaves] == 0.0)
    assert np.all(speeds[time > leaves] < 0.0)


@pytest.mark.parametrize("share", [0.999, 1.0, 1.001])
def test_a_sine_moves_the_wheel_only_if_its_peak_is_above_the_static_torque(response, share):
    wheel = Wheel(inertia=1e-4, motor_constant=MOTOR_CONSTANT, friction=FRICTIONS[1])
    time = np.arange(201) * 0.05
    current = share * 1.1e-3 / MOTOR_CONSTANT * np.sin(np.pi * time / 5.0)
    speeds = response(wheel, time, current, hold="linear")
    assert np.any(speeds != 0.0) == (share > 1.0)


def test_a_ramp_that_ends_at_the_static_torque_is_resolved_and_leaves_the_wheel_at_rest():
    """Breakaway within rounding of the end of the interval must not loop."""
    random = np.random.default_rng(4)
    count = 4000
    inertia, motor = 10 ** random.uniform(-4, 0, count), 10 ** random.uniform(-3, 1, count)
    coulomb, duration = 10 ** random.uniform(-5, -1, count), 10 ** random.uniform(-3, 0, count)
    static = coulomb * random.choice([0.5, 1.0, 1.3], count)
    end = static / motor
    start = end * random.uniform(-1, 1, count)

    def step(inertia, motor, coulomb, static, start, slope, duration):
        wheel = Wheel(inertia, motor, Stribeck(0.0, coulomb, static, 1.0))
        return advance(wheel, 0.0, start, slope, duration)

    slope = (end - start) / duration
    done = jax.jit(jax.vmap(step))(inertia, motor, coulomb, static, start, slope, duration)
    assert np.all(done.resolved)
    # what rounding lets through is the square of a unit in the last place
    assert np.all(np.abs(done.speed) < 1e-22)


def test_no_current_and_no_friction_leave_the_wheel_as_it_is(response):
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=ViscousCoulomb(0.0, 0.0))
    time = np.arange(64.0)
    assert np.all(response(wheel, time, np.zeros(64)) == 0.0)
    assert np.all(response(wheel, time, np.zeros(64), 2.0) == 2.0)
    # without dry friction any torque turns it, from zero and through zero
    np.testing.assert_allclose(
        response(wheel, time, np.sin(time), 0.0, hold="linear"),
        np.concatenate([[0.0], np.cumsum(0.5 * (np.sin(time[1:]) + np.sin(time[:-1])))]),
        atol=1e-13,
    )


def test_a_static_torque_below_zero_does_not_turn_the_clock_back():
    """A fit may try it. The wheel then leaves at once in the sense in which the torque rises."""
    curve = Stribeck.of(viscous=0.0, coulomb=0.1, static=-0.2, stribeck_speed=100.0)
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=curve)
    step = advance(wheel, 0.0, 0.0, 0.3, jnp.array(1.0))
    assert bool(step.resolved)
    # nearly constant friction -0.2 over this range of speeds: 0.2 t + 0.3 t²/2
    assert float(step.speed) == pytest.approx(0.35, rel=1e-4)
