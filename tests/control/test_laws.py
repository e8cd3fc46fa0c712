"""Attitude law, current mode, friction compensation and speed mode, sample by sample."""

from collections import namedtuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gyrostat.control import AttitudePID, CurrentMode, DynamicModelCompensator, SpeedMode
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.friction import DirectionalStribeck, Stribeck, ViscousCoulomb

PERIOD = 0.1
MOTOR = 0.0228
SAMPLES = 40
Measurement = namedtuple("Measurement", ["attitude", "rate", "speed"])


@jax.jit
def outputs(law, attitude, rate):
    """What a law demands at every sample, and its sum there."""

    def tick(memory, now):
        memory, torque = law(memory, Measurement(*now, 0.0))
        return memory, (torque, memory.integral)

    return jax.lax.scan(tick, law.start(PERIOD), (attitude, rate))[1]


def law_of(gains, limit=np.inf, reference=0.0):
    values = (*gains, limit, reference)
    return AttitudePID(*(jnp.asarray(x, float) for x in values))


signal = arrays(float, SAMPLES, elements=st.floats(-1.0, 1.0))
gain = st.floats(0.0, 2.0)


@given(signal, signal, gain, gain, gain, st.floats(-1.0, 1.0))
def test_the_law_sums_rectangles_the_present_sample_included(attitude, rate, p, i, d, reference):
    found, _ = outputs(law_of((p, i, d), reference=reference), attitude, rate)
    error = attitude - reference
    expected = p * error + i * PERIOD * np.cumsum(error) + d * rate
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@given(signal, signal, gain, st.floats(0.01, 2.0), gain, st.floats(0.05, 1.0))
def test_at_its_limit_the_sum_only_moves_back(attitude, rate, p, i, d, limit):
    torque, summed = (np.asarray(x) for x in outputs(law_of((p, i, d), limit), attitude, rate))
    assert np.all(np.abs(torque) <= limit)
    before = np.concatenate([[0.0], summed[:-1]])
    with_sample = before + PERIOD * attitude
    wished = p * attitude + d * rate + i * with_sample
    moved = summed != before
    np.testing.assert_allclose(summed[moved], with_sample[moved], rtol=1e-12, atol=1e-15)
    # beyond the limit it moves towards it, within the limit always
    away = (np.abs(wished) > limit * (1.0 + 1e-9)) & (wished * attitude > 0.0)
    assert not np.any(moved & away)
    free = np.abs(wished) < limit * (1.0 - 1e-9)
    np.testing.assert_allclose(summed[free], with_sample[free], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(torque[free], wished[free], rtol=1e-9, atol=1e-12)


def test_without_winding_up_the_torque_turns_with_the_error():
    attitude = np.concatenate([np.full(30, 1.0), np.full(10, -0.1)])
    gains, rate = (0.1, 1.0, 0.0), np.zeros(SAMPLES)
    limited, _ = outputs(law_of(gains, 0.2), attitude, rate)
    free, _ = outputs(law_of(gains), attitude, rate)
    assert np.all(free[30:] > 1.5)
    # 0.1 N·m of the sum are left at the turn, an error of -0.1 rad takes off 0.01 N·m a sample
    assert limited[29] == pytest.approx(0.2, abs=0.11)
    assert limited[-1] < 0.0


def command(control, attitude=0.01, rate=-0.02, speed=0.0):
    measurement = Measurement(*(jnp.asarray(x, float) for x in (attitude, rate, speed)))
    return control(control.start(PERIOD), measurement)[1]


LAW = AttitudePID(0.0571, 0.00234, 0.3126)


def demanded(attitude, rate):
    return 0.0571 * attitude + 0.00234 * PERIOD * attitude + 0.3126 * rate


@pytest.mark.parametrize("attitude", [0.01, -0.2, 0.0])
def test_current_mode_divides_by_the_motor_constant_and_keeps_its_limit(attitude):
    found = command(CurrentMode(LAW, MOTOR), attitude)
    assert float(found.current) == pytest.approx(demanded(attitude, -0.02) / MOTOR, rel=1e-12)
    assert float(found.friction_current) == 0.0
    limited = command(CurrentMode(LAW, MOTOR, 0.01), attitude)
    assert float(limited.current) == -0.01
    assert float(limited.attitude_current) == float(found.current)


def stribeck(speed, sense, viscous, coulomb, static, scale):
    return viscous * speed + sense * (
        coulomb + (static - coulomb) * np.exp(-((speed / scale) ** 2))
    )


@given(
    st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.one_of(st.just(0.0), st.floats(-300.0, 300.0))
)
def test_compensation_is_that_of_18_and_19(attitude, rate, speed):
    values = (4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)
    torque = demanded(attitude, rate)
    # compiled code takes the smallest numbers for zero
    assume(all(x == 0.0 or abs(x) > 1e-290 for x in (torque, speed)))
    found = command(DynamicModelCompensator(LAW, Stribeck(*values), MOTOR), attitude, rate, speed)
    if speed != 0.0:
        friction = stribeck(speed, np.sign(speed), *values)
    else:
        friction = np.sign(torque) * 0.9055e-3
    assert float(found.friction_current) == pytest.approx(friction / MOTOR, rel=1e-12)
    assert float(found.attitude_current) == pytest.approx(torque / MOTOR, rel=1e-9, abs=1e-15)
    total = float(found.friction_current + found.attitude_current)
    assert float(found.current) == pytest.approx(total, rel=1e-12)


def test_compensation_takes_any_friction_and_its_own_sense():
    uneven = DirectionalStribeck(4e-6, 6e-6, 8e-4, 9.5e-4, 1.1e-3, 1.2e-3, 1.0)
    for speed, friction in (
        (2.0, stribeck(2.0, 1.0, 4e-6, 8e-4, 1.1e-3, 1.0)),
        (-2.0, stribeck(-2.0, -1.0, 6e-6, 9.5e-4, 1.2e-3, 1.0)),
        (0.0, -1.2e-3),
    ):
        found = command(DynamicModelCompensator(LAW, uneven, MOTOR), speed=speed)
        assert float(found.friction_current) == pytest.approx(friction / MOTOR, rel=1e-12)
    plain = ViscousCoulomb(0.0, 1e-3)
    still = command(DynamicModelCompensator(LAW, plain, MOTOR), 0.0, 0.0, 0.0)
    assert float(still.current) == 0.0
    limited = command(DynamicModelCompensator(LAW, plain, MOTOR, 0.02), 0.1, 0.1, 5.0)
    assert float(limited.current) == 0.02


@jax.jit
def speed_loop(control, friction, attitude, start):
    """A rotor under a speed loop: its speeds and the commanded currents."""

    def tick(carry, now):
        memory, speed = carry
        memory, found = control(memory, Measurement(now, jnp.zeros(()), speed))
        after = speed + 0.01 / 1.5e-3 * (MOTOR * found.current - friction)
        return (memory, after), (speed, found.current)

    return jax.lax.scan(tick, (control.start(0.01), start), attitude)[1]


def test_speed_mode_holds_its_speed_against_friction_as_its_poles_say():
    """Critically damped: a sudden torque F moves the speed by -(F/J) t exp(-w_n t)."""
    control = SpeedMode(AttitudePID(0.0, 0.0, 0.0), 1.5e-3, MOTOR, natural_frequency=2.0)
    speed, current = speed_loop(control, 9e-4, np.zeros(1000), 20.0)
    time = 0.01 * np.arange(1000)
    expected = 20.0 - 9e-4 / 1.5e-3 * time * np.exp(-2.0 * time)
    np.testing.assert_allclose(speed, expected, rtol=0.0, atol=0.03 * 9e-4 / 1.5e-3 / 2.0)
    assert float(speed[-1]) == pytest.approx(20.0, abs=1e-6)
    assert float(current[-1]) == pytest.approx(9e-4 / MOTOR, rel=1e-4)


def test_speed_mode_gives_the_table_the_demanded_torque():
    """A constant demand is a ramp of the wheel: acceleration times inertia, friction or not."""
    control = SpeedMode(AttitudePID(0.5, 0.0, 0.0), 1.5e-3, MOTOR, natural_frequency=2.0)
    speed, current = speed_loop(control, 9e-4, np.full(1000, 2e-3), -3.0)
    slope = np.diff(speed[-100:]) / 0.01
    np.testing.assert_allclose(slope, 1e-3 / 1.5e-3, rtol=1e-5)
    np.testing.assert_allclose(current[-100:], 1.9e-3 / MOTOR, rtol=1e-5)
    limited = SpeedMode(AttitudePID(0.5, 0.0, 0.0), 1.5e-3, MOTOR, current_limit=0.05)
    _, current = speed_loop(limited, 9e-4, np.full(1000, 2e-3), -3.0)
    assert float(jnp.max(jnp.abs(current))) == 0.05


def test_designed_gains_place_two_poles_at_the_frequency_and_one_at_a_fifth_of_it():
    """J s³ + K_d s² + K_p s + K_i: the double integrator under the law, by NumPy's roots."""
    law = AttitudePID.design(0.5, 0.3)
    poles = np.roots([0.5, law.derivative, law.proportional, law.integral])
    # a double root is known to the square root of the rounding error
    np.testing.assert_allclose(np.sort(poles.real), [-0.3, -0.3, -0.06], rtol=1e-6)
