"""Regulators of attitude and rate against the Riccati equation of scipy."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from gyrostat.control import AttitudeRegulator, MRPBody
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import from_rotation_vector
from gyrostat.spacecraft import Spacecraft, SpacecraftMeasurement
from gyrostat.wheel import WheelArray, pyramid_axes

AXES = pyramid_axes(4)
INERTIA = np.array([[12.0, 0.4, 0.0], [0.4, 10.0, -0.3], [0.0, -0.3, 8.0]])
CRAFT = Spacecraft(INERTIA, WheelArray(AXES, np.full(4, 0.015)))
STATE_WEIGHT, INPUT_WEIGHT = np.diag([160.0] * 3 + [10.0] * 3), 100.0 * np.eye(3)
REGULATOR = AttitudeRegulator(CRAFT, jnp.array([0.5, 0.5, -0.5, 0.5]), 160.0, 10.0, 100.0)
TURN, RATE = np.array([0.6, -0.3, 0.4]), np.array([0.04, -0.03, 0.02])
WHEELS = np.array([0.5, -0.3, 0.2, 0.4])


def measured():
    """The target, turned; by hand its product with the turn's quaternion."""
    w, x, y, z = np.array([0.5, 0.5, -0.5, 0.5])
    left = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    attitude = left @ np.asarray(from_rotation_vector(jnp.asarray(TURN)))
    return SpacecraftMeasurement(
        *map(jnp.asarray, (attitude, RATE, WHEELS / 0.015, np.ones(4, bool)))
    )


def state():
    angle = np.linalg.norm(TURN)
    return np.concatenate([TURN / angle * np.tan(angle / 4.0), RATE])


def demanded(dynamics, input):
    """The torque on the body that the law asks for."""
    cost = solve_continuous_are(dynamics, input, STATE_WEIGHT, INPUT_WEIGHT)
    return -np.linalg.solve(INPUT_WEIGHT, input.T @ cost @ state())


def given(regulator):
    _, command = eqx.filter_jit(regulator)((), measured())
    assert bool(command.valid)
    torque = np.asarray(command.torque)
    # of all torques of four wheels that do it, the one with no part in the null space
    np.testing.assert_allclose(np.linalg.pinv(AXES) @ AXES @ torque, torque, rtol=1e-9)
    return -AXES @ torque


def test_the_linear_law_is_that_of_the_double_integrator_at_rest():
    dynamics, input = np.zeros((6, 6)), np.zeros((6, 3))
    dynamics[:3, 3:], input[3:] = np.eye(3) / 4.0, np.linalg.inv(INERTIA)
    np.testing.assert_allclose(
        given(eqx.filter_jit(AttitudeRegulator.linear)(REGULATOR)),
        demanded(dynamics, input),
        rtol=1e-9,
    )


def test_the_other_law_is_that_of_the_state_and_of_the_wheels_momentum():
    held = AXES @ (WHEELS + 0.015 * AXES.T @ RATE)
    dynamics, input = map(np.asarray, MRPBody(INERTIA)(jnp.asarray(state()), jnp.asarray(held)))
    # Euler's equation with the wheels' momentum, by hand
    change = np.linalg.solve(INERTIA, -np.cross(RATE, INERTIA @ RATE + held))
    np.testing.assert_allclose((dynamics @ state())[3:], change, rtol=1e-9)
    np.testing.assert_allclose(given(REGULATOR), demanded(dynamics, input), rtol=1e-7)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"attitude_weight": 0.0}, "attitude weight: found 0"),
        ({"rate_weight": np.nan}, "rate weight: found nan"),
        ({"torque_weight": -1.0}, "torque weight: found -1"),
        ({"target": np.ones(4)}, "length"),
        ({"spacecraft": Spacecraft(INERTIA, WheelArray(AXES[:, :2], np.ones(2)))}, "do not span"),
    ],
)
def test_a_regulator_that_cannot_work_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        dataclasses.replace(REGULATOR, **changes).check()
