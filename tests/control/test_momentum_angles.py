"""Roll, spin and tilt, against the rotations that they stand for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gyrostat.control.underactuated.momentum_angles import momentum_angles, momentum_frame
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp

ANGLE = st.floats(-3.1, 3.1)


def quaternion(rotation):
    return np.roll(rotation.as_quat(), 1)


angles = jax.jit(momentum_angles)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**31), roll=ANGLE, spin=ANGLE, share=st.floats(0.05, 0.95))
def test_angles_are_those_an_attitude_was_made_with(seed, roll, spin, share):
    random = np.random.default_rng(seed)
    goal = Rotation.random(rng=random)
    total = 2.0 * Rotation.random(rng=random).apply([0.0, 0.0, 1.0])
    axis = Rotation.random(rng=random).apply([0.0, 0.0, 1.0])
    body = goal.inv().apply(total)
    across = np.cross(axis, body)
    if np.linalg.norm(across) < 0.1:
        return
    tangent = across / np.linalg.norm(across)
    angle = np.arctan2(np.linalg.norm(across), axis @ body)
    tilt = angle - share * np.pi
    made = (
        goal
        * Rotation.from_rotvec(roll * body / np.linalg.norm(body))
        * Rotation.from_rotvec(tilt * tangent)
        * Rotation.from_rotvec(spin * axis)
    )
    found = angles(quaternion(made), quaternion(goal), total, axis)
    np.testing.assert_allclose(found, (roll, spin, tilt), atol=1e-9)


def test_rates_of_the_angles_add_up_to_the_body_rate():
    random = np.random.default_rng(5)
    total, axis = np.array([0.4, -1.0, 0.7]), np.array([0.0, 0.6, 0.8])

    @jax.jit
    def rates_and_tangent(here, goal, rate):
        turning = rotations.rate_of_quaternion(here, rate)
        rates = jax.jvp(lambda q: momentum_angles(q, goal, total, axis), (here,), (turning,))[1]
        return rates, momentum_frame(axis, rotations.to_body(here, total)).tangent

    for _ in range(10):
        here, goal = (Rotation.random(rng=random) for _ in range(2))
        rate = random.normal(size=3)
        rates, tangent = rates_and_tangent(quaternion(here), quaternion(goal), rate)
        body = here.inv().apply(total)
        along = body / np.linalg.norm(body)
        again = rates.roll * along + rates.spin * axis + rates.tilt * tangent
        np.testing.assert_allclose(again, rate, atol=1e-10)


def test_momentum_along_the_axis_gives_finite_numbers():
    frame = momentum_frame(jnp.array([0.0, 0.0, 1.0]), jnp.array([0.0, 0.0, 2.0]))
    assert all(np.all(np.isfinite(part)) for part in frame)
    assert frame.angle == pytest.approx(0.0, abs=1e-9)
