"""The electronics of a motor: limits, steps, lag, supply and power."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import AirBearingTable, TableCommand
from gyrostat.wheel import Driver, Wheel
from gyrostat.wheel.friction import ViscousCoulomb

MOTOR = 0.0228
LAG_ERROR = 1e-7
"""Of the impulse of the full current: what steps of a tenth of the time constant leave."""
set_point = jax.jit(Driver.set_point)


def reached(driver, command, speed=0.0):
    driver = jax.tree.map(lambda x: jnp.asarray(x, float), driver)
    return float(set_point(driver, float(command), float(speed), MOTOR))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_current_and_torque_limits_hold_and_the_lower_one_counts(sense):
    assert reached(Driver(), 7.0 * sense) == 7.0 * sense
    assert reached(Driver(current_limit=0.4), 7.0 * sense) == 0.4 * sense
    assert reached(Driver(current_limit=0.4), 0.3 * sense) == 0.3 * sense
    both = Driver(current_limit=0.4, torque_limit=0.5 * MOTOR)
    assert reached(both, 7.0 * sense) == 0.4 * sense
    both = Driver(current_limit=0.4, torque_limit=0.25 * MOTOR)
    assert reached(both, 7.0 * sense) == pytest.approx(0.25 * sense, rel=1e-15)


@given(st.floats(-1.0, 1.0), st.floats(1e-4, 0.3))
def test_commands_are_rounded_to_the_nearest_step(command, quantum):
    found = reached(Driver(current_quantum=quantum), command)
    assert abs(found / quantum - round(found / quantum)) < 1e-9
    assert abs(found - command) <= 0.5 * quantum * (1.0 + 1e-9)


@given(st.integers(1, 40), st.sampled_from([0.1, 0.01, 0.05, 1e-3, 0.3]), st.booleans())
def test_a_limit_that_is_a_whole_number_of_steps_is_reached(steps, quantum, negative):
    """0.3 / 0.1 is 2.9999999999999996 in floating point: still three steps."""
    sense = -1.0 if negative else 1.0
    for limit in (steps * quantum, float(f"{steps * quantum:.6f}")):
        driver = Driver(current_limit=limit, current_quantum=quantum)
        assert reached(driver, 100.0 * sense) == pytest.approx(sense * limit, rel=1e-9)
        assert reached(driver, limit * sense) == pytest.approx(sense * limit, rel=1e-9)
        between = Driver(current_limit=limit + 0.7 * quantum, current_quantum=quantum)
        assert reached(between, 100.0 * sense) == pytest.approx(sense * limit, rel=1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_supply_limits_driving_and_braking_by_the_back_emf(sense):
    """V = R I + k_m w: driving has the back-EMF against it, braking has it to help."""
    volts, ohms = 12.0, 5.0
    driver = Driver(bus_voltage=volts, resistance=ohms)
    for speed in (0.0, 100.0, 300.0, 520.0):
        driving = (volts - MOTOR * speed) / ohms
        braking = (volts + MOTOR * speed) / ohms
        assert reached(driver, 100.0 * sense, speed * sense) == pytest.approx(sense * driving)
        assert reached(driver, -100.0 * sense, speed * sense) == pytest.approx(-sense * braking)
    beyond = 1.1 * volts / MOTOR
    assert reached(driver, sense, sense * beyond) == 0.0
    assert reached(driver, -sense, sense * beyond) == -sense


def test_saturation_is_a_limit_and_not_a_rounding():
    quantised = Driver(current_limit=0.3, current_quantum=0.1)
    for command, flag in ((0.26, False), (0.34, False), (0.351, True), (-2.0, True), (0.0, False)):
        assert bool(quantised.limited(command, reached(quantised, command))) == flag, command
    plain = Driver(current_limit=0.3)
    for command, flag in ((0.3, False), (np.nextafter(0.3, 1.0), True), (-0.31, True)):
        assert bool(plain.limited(command, reached(plain, command))) == flag, command


def test_power_is_heat_and_mechanical_power():
    driver = Driver(resistance=5.0)
    assert driver.power(0.2, 100.0, MOTOR) == pytest.approx(5.0 * 0.04 + MOTOR * 20.0)
    # braking: the back-EMF feeds back more than the winding burns
    assert driver.power(-0.2, 100.0, MOTOR) == pytest.approx(5.0 * 0.04 - MOTOR * 20.0)
    assert driver.power(-0.2, 100.0, MOTOR) < 0.0


def test_limits_that_are_not_there_leave_derivatives_finite():
    """Infinite limits are the default: no derivative may be NaN by infinity times zero."""

    def reach(values):
        limit, quantum, command, speed, motor = values
        driver = Driver(current_limit=limit, current_quantum=quantum)
        return driver.set_point(command, speed, motor)

    slope = jax.jit(jax.jacfwd(reach))(jnp.array([10.0, 0.0, 0.2, 30.0, MOTOR]))
    np.testing.assert_array_equal(slope, [0.0, 0.0, 1.0, 0.0, 0.0])
    slope = jax.jit(jax.jacfwd(lambda motor: Driver(torque_limit=1e-3).set_point(9.0, 0.0, motor)))(
        MOTOR
    )
    assert float(slope) == pytest.approx(-1e-3 / MOTOR**2)


@jax.jit
def turned(tau, current, speed, period):
    """Speed of a wheel with constant friction and a lag, on a table, after one period."""
    wheel = Wheel(1.5e-3, MOTOR, ViscousCoulomb(0.0, 1e-4))
    table = AirBearingTable(0.495, wheel, Driver(time_constant=tau))
    start = table.start(speed=speed)._replace(current=-0.5 * current)
    end, resolved = table(start, TableCommand(current), 0.0, period)
    return end.speed, end.current, resolved


@pytest.mark.parametrize("share", [0.0, 1e-9, 1e-4, 0.01, 0.1, 0.4, 1.0, 3.0, 10.0, 1e3])
@pytest.mark.parametrize("period", [1e-3, 0.1, 5.0])
def test_the_impulse_of_a_lagging_current_is_the_integral_of_its_exponential(share, period):
    tau, current, speed = share * period, 0.1, 30.0
    end, last, resolved = turned(tau, current, speed, period)
    assert bool(resolved)
    lost = tau * -np.expm1(-1.0 / share) if share > 0.0 else 0.0
    expected = MOTOR * current * (period - 1.5 * lost)
    reduced = 0.495 * 1.5e-3 / 0.4965
    # in N·m·s, of what the full current would give; rounding is that of the speed
    impulse = (float(end) - speed) * reduced + 1e-4 * period
    bound = LAG_ERROR * MOTOR * current * period + 1e-14 * reduced * speed
    assert abs(impulse - expected) < bound
    decay = np.exp(-1.0 / share) if share > 0.0 else 0.0
    assert float(last) == pytest.approx(current * (1.0 - 1.5 * decay), rel=1e-12)


@pytest.mark.parametrize("tau", [0.0, 1e-9, 0.03, 0.4, 1e6])
def test_the_mean_of_a_lagging_current_is_that_of_its_samples(tau):
    driver = Driver(time_constant=tau)
    middles = (np.arange(4000) + 0.5) / 4000 * 0.25
    mean = np.mean(np.asarray(driver.current(0.3, -0.1, middles)))
    assert float(driver.mean_current(0.3, -0.1, 0.25)) == pytest.approx(mean, rel=1e-5)
    still = 0.3 if tau else -0.1
    assert float(driver.mean_current(0.3, -0.1, 0.0)) == pytest.approx(still)
