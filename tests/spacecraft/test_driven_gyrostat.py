"""Wheels behind their drivers: momentum by the closed form of the lag, the order of the step."""

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import DrivenGyrostat, Gyrostat, Spacecraft, WheelTorqueCommand
from gyrostat.wheel import Driver, WheelArray, pyramid_axes

AXES = pyramid_axes(4)
ROTORS = np.full(4, 2e-5)
INERTIA = np.diag([0.10, 0.12, 0.06])
CRAFT = Spacecraft(INERTIA, WheelArray(AXES, ROTORS, torque_limit=1e-3))
CONSTANT = np.array([5e-3, 4e-3, 5e-3, 6e-3])
LAG = np.array([0.05, 0.4, 0.0, 0.02])
DRIVER = Driver(time_constant=LAG)
SPEED = np.array([300.0, -200.0, 410.0, -150.0])
TORQUES = np.array([[8e-4, -5e-4, 3e-4, 2e-4], [-6e-4, 9e-4, 3e-4, 1e-4], [0.0, 2e-3, 0.0, 0.0]])
PERIOD = 0.25


@pytest.fixture(scope="module")
def fly(frictionless):
    """States at the control times, by the number of steps in each period."""
    plant = DrivenGyrostat(frictionless(Gyrostat(CRAFT)), DRIVER, CONSTANT)

    @eqx.filter_jit
    def flown(count):
        def period(state, torque):
            def step(state, _):
                command = WheelTorqueCommand(torque)
                return plant(state, command, 0.0, PERIOD / count)[0], None

            state = jax.lax.scan(step, state, length=count)[0]
            return state, state

        start = plant.start(rate=[0.01, -0.02, 0.015], wheel_speed=SPEED)
        return jax.lax.scan(period, start, jnp.asarray(TORQUES))[1]

    return {count: jax.tree.map(np.array, flown(count)) for count in (1, 2, 4)}


def currents():
    """Set points, and currents at the control times, wheel by wheel."""
    targets = np.clip(TORQUES, -1e-3, 1e-3) / CONSTANT
    now, found = np.zeros(4), []
    for target in targets:
        decay = np.exp(-PERIOD / np.where(LAG > 0.0, LAG, 1e-9))
        now = target + (now - target) * decay
        found.append(now)
    return targets, np.array(found)


def test_currents_follow_their_lag(fly):
    for flown in fly.values():
        np.testing.assert_allclose(flown.motor_current, currents()[1], rtol=1e-12, atol=1e-15)


def test_attitude_converges_with_the_step_to_that_of_newton_and_euler(fly):
    """The lag integrated by another hand; half the step leaves a quarter of the error."""
    rate = np.array([0.01, -0.02, 0.015])
    locked = INERTIA + AXES @ np.diag(ROTORS) @ AXES.T
    total = locked @ rate + AXES @ (ROTORS * SPEED)
    own = ROTORS * (SPEED + AXES.T @ rate)
    targets, _ = currents()

    def slope(torque, time, y):
        attitude, own, current = y[:4], y[4:8], y[8:]
        w, v = attitude[0], attitude[1:]
        body = total + 2.0 * np.cross(v, np.cross(v, total) - w * total)
        rate = np.linalg.solve(INERTIA, body - AXES @ own)
        lag = np.where(LAG > 0.0, LAG, 1.0)
        change = np.where(LAG > 0.0, (torque - current) / lag, 0.0)
        now = np.where(LAG > 0.0, current, torque)
        turn = [-v @ rate, *(w * rate + np.cross(v, rate))]
        return np.array([*(0.5 * np.array(turn)), *(CONSTANT * now), *change])

    y = np.array([1.0, 0.0, 0.0, 0.0, *own, *np.zeros(4)])
    for torque in targets:
        found = solve_ivp(
            lambda t, y, u=torque: slope(u, t, y), (0, PERIOD), y, "DOP853", rtol=1e-12, atol=1e-14
        )
        y = found.y[:, -1]
    errors = []
    for flown in fly.values():
        errors.append(np.linalg.norm(flown.attitude[-1] - y[:4]))
        # momentum in space does not depend on when it came
        rate = np.linalg.solve(INERTIA, np.array(flown_body(flown)) - AXES @ y[4:8])
        speed = y[4:8] / ROTORS - AXES.T @ rate
        np.testing.assert_allclose(flown.wheel_speed[-1], speed, rtol=1e-6)
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(order > 1.8), errors


def flown_body(flown):
    """Total momentum in body axes at the end."""
    w, *v = flown.attitude[-1]
    total = flown.momentum[-1]
    return total + 2.0 * np.cross(v, np.cross(v, total) - w * total)


def test_limits_of_the_driver_saturate_the_wheel(frictionless):
    driver = Driver(
        current_limit=np.array([0.1, np.inf, np.inf, np.inf]),
        current_quantum=np.array([0.0, 0.02, 0.0, 0.0]),
        bus_voltage=np.array([np.inf, np.inf, 2.1, np.inf]),
        resistance=np.array([0.0, 0.0, 0.5, 0.0]),
    )
    plant = DrivenGyrostat(frictionless(Gyrostat(CRAFT)), driver, 5e-3)
    state = plant.start(wheel_speed=SPEED)
    command = WheelTorqueCommand(np.array([9e-4, 4.4e-4, 5e-4, 5e-4]))
    after, _ = plant(state, command, 0.0, PERIOD)
    # 0.088 A on steps of 0.02 A; (2.1 V - 5 mV·s × 410 rad/s) / 0.5 Ω
    np.testing.assert_allclose(after.motor_current, [0.1, 0.08, 0.1, 0.1], rtol=1e-12)
    command = WheelTorqueCommand(np.array([9e-4, 4.4e-4, 6e-4, 5e-4]))
    record = plant.record(state, command)
    assert record.saturated.tolist() == [True, False, True, False]


@pytest.mark.parametrize(
    ("driver", "constant", "message"),
    [
        (Driver(time_constant=np.ones(2)), 5e-3, "driver time_constant: found 2 values"),
        (Driver(time_constant=-1.0), 5e-3, "driver time_constant: found -1"),
        (Driver(bus_voltage=5.0), 5e-3, "driver resistance: found 0"),
        (Driver(), 0.0, "motor_constant: found 0"),
        (Driver(), np.ones(3), "driver motor_constant: found 3 values"),
    ],
)
def test_a_driver_that_is_none_is_refused(driver, constant, message):
    with pytest.raises(InputError, match=message):
        DrivenGyrostat(Gyrostat(CRAFT), driver, constant).check()


def test_a_state_without_a_current_for_every_wheel_is_refused():
    plant = DrivenGyrostat(Gyrostat(CRAFT), DRIVER, CONSTANT)
    plant.check_state(plant.start())
    with pytest.raises(InputError, match="motor_current"):
        plant.check_state(plant.start()._replace(motor_current=np.zeros(3)))
