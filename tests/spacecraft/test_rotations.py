"""Rotations against scipy's, and against their own kinematics."""

import inspect
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import EulerAngles

# compiled once: hypothesis calls them some thousand times
rot = SimpleNamespace(
    **{name: jax.jit(f) for name, f in vars(rotations).items() if inspect.isfunction(f)}
)

COMPONENT = st.floats(-1.0, 1.0)
VECTORS = st.tuples(COMPONENT, COMPONENT, COMPONENT).map(np.array)
QUATERNIONS = (
    st.tuples(COMPONENT, COMPONENT, COMPONENT, COMPONENT)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 1e-3)
    .map(lambda q: q / np.linalg.norm(q))
)
ANGLES = st.tuples(st.floats(-3.1, 3.1), st.floats(0.05, 3.09), st.floats(-3.1, 3.1)).map(
    lambda a: EulerAngles(*(jnp.asarray(x) for x in a))
)


def scipys(q):
    return Rotation.from_quat(np.asarray(q), scalar_first=True)


def same_attitude(p, q):
    return abs(abs(np.dot(p, q)) - 1.0) < 1e-14


@given(QUATERNIONS, QUATERNIONS, VECTORS)
def test_product_and_rotation_of_vectors(p, q, v):
    p, q, v = jnp.asarray(p), jnp.asarray(q), jnp.asarray(v)
    together = scipys(p) * scipys(q)
    assert same_attitude(rot.product(p, q), together.as_quat(scalar_first=True))
    np.testing.assert_allclose(rot.to_inertial(q, v), scipys(q).apply(np.array(v)), atol=1e-15)
    np.testing.assert_allclose(rot.to_body(q, v), scipys(q).inv().apply(np.array(v)), atol=1e-15)
    np.testing.assert_allclose(rot.rotation_matrix(q), scipys(q).as_matrix(), atol=1e-15)


@given(QUATERNIONS)
def test_matrices_and_back(q):
    back = rot.from_matrix(rot.rotation_matrix(jnp.asarray(q)))
    assert same_attitude(back, q)
    assert back[0] >= 0.0


@given(QUATERNIONS)
def test_rotation_vectors(q):
    vector = rot.rotation_vector(jnp.asarray(q))
    np.testing.assert_allclose(
        rot.rotation_matrix(rot.from_rotation_vector(vector)), scipys(q).as_matrix(), atol=1e-14
    )
    assert np.linalg.norm(vector) <= np.pi + 1e-14


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.99e-4, 1.01e-4, 1e-3, np.pi])
def test_small_and_large_turns(angle):
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    q = rot.from_rotation_vector(jnp.asarray(angle * axis))
    wanted = Rotation.from_rotvec(angle * axis).as_quat(scalar_first=True)
    np.testing.assert_allclose(q, wanted, rtol=0, atol=1e-16)
    np.testing.assert_allclose(rot.rotation_vector(q), angle * axis, rtol=1e-15, atol=1e-15)
    one = jnp.array([1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(rot.error_angle(q, one), angle, rtol=1e-15, atol=1e-15)


def test_derivatives_at_no_turn_exist():
    jacobian = jax.jit(jax.jacfwd(rot.from_rotation_vector))(jnp.zeros(3))
    np.testing.assert_allclose(jacobian, np.vstack([np.zeros(3), 0.5 * np.eye(3)]), atol=1e-16)
    one = jnp.array([1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(
        jax.jit(jax.jacfwd(rot.rotation_vector))(one)[:, 1:], 2.0 * np.eye(3), atol=1e-15
    )


@given(QUATERNIONS)
def test_mrp(q):
    assume(abs(q[0]) > 1e-9)  # half a turn has two
    mrp = rot.to_mrp(jnp.asarray(q))
    np.testing.assert_allclose(mrp, scipys(q).as_mrp(), atol=1e-14)
    assert same_attitude(rot.from_mrp(mrp), q)


@given(ANGLES)
def test_euler_angles(angles):
    q = rot.from_euler(angles)
    # scipy's lower-case sequence is extrinsic, its upper-case one intrinsic as 3-1-3 is meant
    assert same_attitude(q, Rotation.from_euler("ZXZ", angles).as_quat(scalar_first=True))
    back, valid = rot.to_euler(q)
    assert valid
    np.testing.assert_allclose(back, angles, atol=1e-12)


@pytest.mark.parametrize("theta", [0.0, np.pi])
def test_angles_that_cannot_be_told_apart_say_so(theta):
    q = rot.from_euler(EulerAngles(*jnp.array([0.4, theta, 0.3])))
    angles, valid = rot.to_euler(q)
    assert not valid
    # what is given is the attitude all the same
    assert same_attitude(rot.from_euler(angles), q)
    _, valid = rot.euler_rates(angles, jnp.ones(3))
    assert not valid


@given(QUATERNIONS, VECTORS)
def test_rates_are_those_of_a_turning_body(q, rate):
    q, rate = jnp.asarray(q), jnp.asarray(rate)

    def later(time):
        return rot.product(q, rot.from_rotation_vector(time * rate))

    turning = jax.jvp(later, (0.0,), (1.0,))[1]
    np.testing.assert_allclose(rot.rate_of_quaternion(q, rate), turning, atol=1e-15)
    if q[0] > 0.0:
        moving = jax.jvp(lambda t: rot.to_mrp(later(t)), (0.0,), (1.0,))[1]
        np.testing.assert_allclose(rot.mrp_rate_matrix(rot.to_mrp(q)) @ rate, moving, atol=1e-13)


@given(ANGLES, VECTORS)
def test_euler_rates_are_those_of_a_turning_body(angles, rates):
    rates = EulerAngles(*(jnp.asarray(x) for x in rates))
    q, turning = jax.jvp(rot.from_euler, (angles,), (rates,))
    rate = rot.rate_of_euler(angles, rates)
    np.testing.assert_allclose(rot.rate_of_quaternion(q, rate), turning, atol=1e-15)
    back, valid = rot.euler_rates(angles, rate)
    assert valid
    np.testing.assert_allclose(back, rates, atol=1e-12)


@given(QUATERNIONS, QUATERNIONS)
def test_the_error_turns_the_target_into_the_attitude(q, target):
    turn = rot.error(jnp.asarray(q), jnp.asarray(target))
    assert same_attitude(rot.product(jnp.asarray(target), turn), q)
    wanted = (scipys(target).inv() * scipys(q)).magnitude()
    np.testing.assert_allclose(
        rot.error_angle(jnp.asarray(q), jnp.asarray(target)), wanted, atol=1e-14
    )


@given(VECTORS, VECTORS)
def test_angle_between_directions(a, b):
    angle = rot.angle_between(jnp.asarray(a), jnp.asarray(b))
    np.testing.assert_allclose(
        np.cos(angle) * np.linalg.norm(a) * np.linalg.norm(b), a @ b, atol=1e-15
    )
    np.testing.assert_allclose(rot.cross_matrix(jnp.asarray(a)) @ b, np.cross(a, b), atol=1e-16)
