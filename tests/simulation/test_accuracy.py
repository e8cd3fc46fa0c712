"""The closed loop of Carrara and Kuga against a loop in plain Python with located events."""

import numpy as np
import pytest

from gyrostat.control import CurrentMode, DynamicModelCompensator
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import run, simulate
from gyrostat.spacecraft import AirBearingTable, TableSensors
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

PERIOD = 0.1


def closed_loop(table, gains, speed, count, *, compensated):
    """States at the control times: PID, and (18) and (19) on top of it."""
    proportional, integral, derivative = gains
    state, summed = (0.0, 0.0, speed, 0.0, 0.0), 0.0
    states = [state]
    for k in range(count):
        attitude, rate, speed = state[:3]
        summed += PERIOD * attitude
        torque = proportional * attitude + integral * summed + derivative * rate
        if compensated:
            at_rest = speed == 0.0
            torque += (
                np.sign(torque) * table.static if at_rest else table.friction(speed, np.sign(speed))
            )
        state = table.carry(state, torque / table.motor_constant, PERIOD * k, PERIOD)
        states.append(state)
    return np.array(states)


@pytest.mark.parametrize("compensated", [False, True])
def test_the_state_after_400_s_is_that_of_a_located_solution(g2, table_reference, compensated):
    wheel = g2.wheel
    control = CurrentMode(g2.law, wheel.motor_constant)
    if compensated:
        control = DynamicModelCompensator(g2.law, wheel.friction, wheel.motor_constant)
    found = simulate(
        g2.table,
        control,
        TableSensors(),
        start=g2.table.start(speed=g2.speed),
        duration=400.0,
        control_period=PERIOD,
    )
    reference = table_reference(
        g2.inertia, wheel.inertia, wheel.motor_constant, *g2.friction, torque=g2.fan
    )
    states = closed_loop(reference, g2.gains, g2.speed, 4000, compensated=compensated)
    crossing = np.flatnonzero(states[1:, 2] * states[:-1, 2] <= 0.0)
    assert abs(PERIOD * crossing[0] - 230.0) < 3.0
    if not compensated:
        assert np.sum(states[:, 2] == 0.0) > 20
        np.testing.assert_array_equal(found.speed == 0.0, states[:, 2] == 0.0)
    peak = np.rad2deg(np.max(np.abs(states[2250:2900, 0])))
    assert peak < 0.001 if compensated else 1.4 < peak < 1.6
    for name, own in zip(("attitude", "rate", "speed", "wheel_angle"), states.T, strict=False):
        # what the controller has brought to zero is measured by its history
        scale = max(np.abs(own[-1]), 1e-2 * np.max(np.abs(own)))
        error = np.abs(found[name].values - own)
        assert error[-1] < 1e-7 * scale, (name, error[-1] / scale)
        assert np.max(error) < 1e-6 * np.max(np.abs(own)), name


def test_a_closed_loop_has_its_derivatives_through_crossings(g2):
    """Tangents of attitude and speed by friction, inertia and first speed: differences agree."""
    values = np.array([0.8795e-3, 1.5e-3, -2.0, 0.495])

    def ends(values):
        coulomb, inertia, speed, table_inertia = values
        wheel = Wheel(inertia, 0.0228, Stribeck(4.83e-6, coulomb, 0.9055e-3, 0.418879))
        table = AirBearingTable(table_inertia, wheel, external_torque=g2.fan)
        control = DynamicModelCompensator(g2.law, g2.wheel.friction, 0.0228)
        start = table.start(speed=speed)
        key = jax.random.key(0)
        found = run(table, control, TableSensors(), start, key, PERIOD, count=120)
        return jnp.stack([1e3 * found.state.attitude, found.state.speed])

    @jax.jit
    def along(values, direction):
        return jax.jvp(ends, (values,), (direction,))

    # one program for the runs and their tangents
    slopes = np.stack([along(values, one)[1] for one in np.eye(4)], axis=-1)
    nudges = np.array([-2.0, -1.0, 1.0, 2.0]) * 1e-4
    moved = values + nudges[None, :, None] * np.diag(values)[:, None, :]
    ways = np.array([[along(each, 0.0 * each)[0] for each in one] for one in moved])
    assert np.any(ways[0, 0, 1] < 0.0)
    assert ways[0, 0, 1, -1] > 0.5
    stencil = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * 1e-4)
    differences = np.tensordot(ways, stencil, (1, 0)) / values[:, None, None]
    for k, difference in enumerate(differences):
        smooth = np.all(np.sign(ways[k, :, 1]) == np.sign(ways[k, 0, 1]), axis=0)
        assert np.mean(smooth) > 0.95
        scale = np.max(np.abs(slopes[..., k]), axis=1)
        error = np.max(np.abs(difference - slopes[..., k])[:, smooth], axis=1)
        assert np.all(error < 1e-6 * scale), (k, error / scale)
