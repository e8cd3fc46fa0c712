"""Factorisations against the plant, derived again from rotation matrices."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gyrostat.control import EulerCube, MRPBody, QuaternionBody
from gyrostat.control.design.factorisations import HALVES, PRINTED
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax

TILTED = Rotation.from_euler("zyx", [0.4, -0.7, 1.1]).as_matrix()
INERTIA = TILTED @ np.diag([8.0, 12.0, 16.0]) @ TILTED.T
RATES = st.floats(-0.5, 0.5)


def vectors(size, numbers=RATES):
    return st.lists(numbers, min_size=size, max_size=size).map(np.array)


APPLY = jax.jit(lambda body, *arguments: body(*arguments))
STEP = 1e-2
# weights of the derivative at the middle of nine points: of a polynomial of degree 8 through them
WEIGHTS = np.linalg.inv(np.vander(np.arange(-4.0, 5.0), increasing=True))[1] / STEP


def derivative(values):
    """Of a smooth function of time at 0, from its values at nine times."""
    return np.tensordot(WEIGHTS, np.asarray(values), axes=1)


def body_rate(matrices):
    """From R' R', for nine rotation matrices."""
    rate = matrices[4].T @ derivative(matrices)
    return np.array([rate[2, 1] - rate[1, 2], rate[0, 2] - rate[2, 0], rate[1, 0] - rate[0, 1]]) / 2


def euler_rates_rate(state, torque):
    """Second derivatives of 3-1-3 angles of a cube of 12 kg m2, from rotation matrices alone.

    The body's acceleration is affine in the angles' second derivatives: those that the torque
    causes are found by solving for them.
    """
    angles = np.array([state[2], np.pi / 2 + state[0], state[4]])
    rates = np.array([state[3], state[1], state[5]])
    times = STEP * np.arange(-8, 9)[:, None]

    def acceleration(second):
        course = angles + rates * times + 0.5 * second * times**2
        matrices = Rotation.from_euler("ZXZ", course).as_matrix()
        return derivative([body_rate(matrices[k : k + 9]) for k in range(9)])

    bare = acceleration(np.zeros(3))
    slope = np.column_stack([acceleration(unit) - bare for unit in np.eye(3)])
    phi, theta, psi = np.linalg.solve(slope, torque / 12.0 - bare)
    return np.array([state[1], theta, state[3], phi, state[5], psi])


@pytest.mark.parametrize("split", [PRINTED, HALVES, (-0.3, 1.7, 0.2, 0.9, 0.4)])
@given(vectors(6), vectors(3))
@settings(max_examples=25)
def test_cube_in_euler_angles(split, state, torque):
    dynamics, inputs = APPLY(EulerCube(12.0, split), state)
    expected = euler_rates_rate(state, torque)
    found = np.asarray(dynamics) @ state + np.asarray(inputs) @ torque
    np.testing.assert_allclose(found, expected, atol=1e-8)
    assert np.all(np.asarray(dynamics)[:, ::2] == 0.0)


def test_the_printed_split_stands_where_the_paper_has_it():
    x = np.array([0.3, 0.1, 0.2, -0.2, 0.5, 0.4])
    dynamics, _ = EulerCube(12.0)(x)
    sine, cosine = np.sin(x[0] + np.pi / 2), np.cos(x[0] + np.pi / 2)
    expected = np.zeros((6, 6))
    expected[[0, 2, 4], [1, 3, 5]] = 1.0
    expected[1, 3] = -x[5] * sine
    expected[3, 3], expected[3, 5] = -x[1] * cosine / sine, x[1] / sine
    expected[5, 1], expected[5, 3] = -x[5] * cosine / sine, x[1] / sine
    np.testing.assert_allclose(dynamics, expected, atol=1e-15)
    other, _ = EulerCube(12.0, HALVES)(x)
    assert np.max(np.abs(other - expected)) > 0.05


COORDINATES = {
    MRPBody: lambda matrix: Rotation.from_matrix(matrix).as_mrp(),
    QuaternionBody: lambda matrix: Rotation.from_matrix(matrix).as_quat(canonical=True)[:3],
}


@pytest.mark.parametrize("kind", [MRPBody, QuaternionBody])
@pytest.mark.parametrize("split", [1.0, 0.0, 0.3])
@given(vectors(3, st.floats(-1.6, 1.6)), vectors(3), vectors(3), vectors(3, st.floats(-3.0, 3.0)))
@settings(max_examples=25)
def test_body_in_error_coordinates(kind, split, turn, rate, torque, momentum):
    start = Rotation.from_rotvec(turn).as_matrix()
    state = np.concatenate([COORDINATES[kind](start), rate])
    dynamics, inputs = APPLY(kind(INERTIA, split), state, momentum)
    # gyroscopic torque: what the momentum, carried round at that rate, changes by in inertial space
    matrices = start @ Rotation.from_rotvec(STEP * np.arange(-4, 5)[:, None] * rate).as_matrix()
    kinematics = derivative([COORDINATES[kind](matrix) for matrix in matrices])
    gyroscopic = start.T @ derivative(matrices @ (INERTIA @ rate + momentum))
    expected = np.concatenate([kinematics, np.linalg.solve(INERTIA, torque - gyroscopic)])
    found = np.asarray(dynamics) @ state + np.asarray(inputs) @ torque
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("kind", [MRPBody, QuaternionBody])
def test_state_counts_from_the_target(kind):
    target, turn = Rotation.from_rotvec([0.3, -2.0, 0.4]), Rotation.from_rotvec([0.2, 0.5, -0.9])
    scalar_first = [part.as_quat(scalar_first=True) for part in (target * turn, target)]
    found = kind(INERTIA).state(scalar_first[0], np.array([0.1, 0.2, 0.3]), scalar_first[1])
    expected = np.concatenate([COORDINATES[kind](turn.as_matrix()), [0.1, 0.2, 0.3]])
    np.testing.assert_allclose(found, expected, atol=1e-14)


def test_refusals():
    with pytest.raises(InputError, match="inertia: found 0"):
        EulerCube(0.0).check()
    with pytest.raises(InputError, match="split: found"):
        EulerCube(1.0, (1.0,)).check()
    with pytest.raises(InputError, match="inertia"):
        MRPBody(np.diag([1.0, 1.0, 3.0])).check()
    with pytest.raises(InputError, match="inertia"):
        QuaternionBody(-np.eye(3)).check()
