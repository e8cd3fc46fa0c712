"""The rate gyro against the classical coning formula and integrated motions."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import BodyMotion, RateGyro, integrated_rate

KEY, NONE = jax.random.key(0), jnp.zeros(3)
measured = jax.jit(lambda gyro, before, now, period: gyro(before, now, NONE, period, KEY)[0])


def coning(angle, rate, samples):
    """Motions of a body whose z axis goes round a cone once, as two-axis rotation vectors.

    With the rotation vector angle (cos rate t, sin rate t, 0) the body rate is
    rate (-sin(angle) sin rate t, sin(angle) cos rate t, cos(angle) - 1).
    """
    time = np.linspace(0.0, 2.0 * np.pi / rate, samples + 1)
    cosine, sine, zero = np.cos(rate * time), np.sin(rate * time), np.zeros(samples + 1)
    turn = angle * np.stack([cosine, sine, zero], axis=1)
    quaternion = Rotation.from_rotvec(turn).as_quat(scalar_first=True)
    drift = np.full(samples + 1, np.cos(angle) - 1.0)
    body = rate * np.stack([-np.sin(angle) * sine, np.sin(angle) * cosine, drift], axis=1)
    return [
        BodyMotion(jnp.asarray(q), jnp.asarray(w)) for q, w in zip(quaternion, body, strict=True)
    ], time[1]


@pytest.mark.parametrize(("samples", "largest"), [(16, 7e-5), (32, 5e-6)])
def test_a_coning_body_has_the_drift_of_the_classical_formula(samples, largest):
    """In a cycle the integral is the solid angle -2 pi (1 - cos angle), of fourth order."""
    angle, gyro = 0.1, RateGyro()
    motions, period = coning(angle, 0.5, samples)
    total = sum(
        period * np.asarray(measured(gyro, before, now, period))
        for before, now in pairwise(motions)
    )
    solid = -2.0 * np.pi * (1.0 - np.cos(angle))
    np.testing.assert_allclose(total[2], solid, rtol=largest)
    np.testing.assert_allclose(total[:2], 0.0, atol=1e-6)
    # an ideal attitude sees none of it: the body is back where it was
    assert abs(solid) > 0.03


def test_a_unit_that_compensates_for_coning_gives_the_rotation_vector():
    (before, now, *_), period = coning(0.1, 0.5, 16)
    turn = Rotation.from_quat(before.attitude, scalar_first=True).inv()
    turn = turn * Rotation.from_quat(now.attitude, scalar_first=True)
    found = measured(RateGyro(coning_compensation=1.0), before, now, period)
    np.testing.assert_allclose(period * found, turn.as_rotvec(), rtol=1e-12)
    apart = found - measured(RateGyro(), before, now, period)
    half = found - measured(RateGyro(coning_compensation=0.5), before, now, period)
    np.testing.assert_allclose(half, 0.5 * apart, atol=1e-16)
    assert np.max(np.abs(apart)) > 5e-5


def test_the_integral_of_the_rate_of_driven_bodies():
    """Free and driven motions at 0.1 rad/s and up to 0.025 rad/s², to 3e-8 rad in 0.5 s."""
    inertia, random = np.diag([12.0, 8.0, 16.0]), np.random.default_rng(1)
    worst, cone = 0.0, 0.0
    for _ in range(20):
        rate, torque = random.normal(size=3), 0.2 * random.normal(size=3)
        rate *= 0.1 / np.linalg.norm(rate)

        def slope(_, y, torque=torque):
            q, w = y[:4], y[4:7]
            turned = np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)]) / 2.0
            change = np.linalg.solve(inertia, torque - np.cross(w, inertia @ w))
            return np.concatenate([turned, change, w])

        start = np.concatenate([[1.0, 0.0, 0.0, 0.0], rate, np.zeros(3)])
        end = solve_ivp(slope, (0.0, 0.5), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        turn = Rotation.from_quat(end[:4], scalar_first=True).as_rotvec()
        found = integrated_rate(*map(jnp.asarray, (turn, rate, end[4:7])), 0.5)
        worst = max(worst, np.max(np.abs(found - end[7:])))
        cone = max(cone, np.max(np.abs(turn - end[7:])))
    assert worst < 3e-8
    assert cone > 3e-5


def test_scale_factor_misalignment_and_limit():
    axis, period = np.array([0.3, -0.2, 0.5]), 0.25
    still = BodyMotion(jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.asarray(axis))
    turned = Rotation.from_rotvec(period * axis).as_quat(scalar_first=True)
    now = BodyMotion(jnp.asarray(turned), jnp.asarray(axis))
    factor, mounting = np.array([1e-3, -2e-3, 0.0]), np.array([0.01, 0.02, -0.03])
    gyro = RateGyro(scale_factor=factor, misalignment=mounting)
    expected = (1.0 + factor) * Rotation.from_rotvec(mounting).inv().apply(axis)
    np.testing.assert_allclose(measured(gyro, still, now, period), expected, rtol=1e-12)
    cut = measured(RateGyro(rate_limit=jnp.array(0.25)), still, now, period)
    np.testing.assert_allclose(cut, [0.25, -0.2, 0.25], rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"scale_factor": [0.0, -1.0, 0.0]}, "scale factor"),
        ({"misalignment": [np.nan, 0.0, 0.0]}, "misalignment"),
        ({"rate_limit": 0.0}, "rate limit"),
        ({"rate_limit": np.nan}, "rate limit"),
        ({"coning_compensation": 1.5}, "coning compensation"),
    ],
)
def test_a_gyro_of_senseless_numbers_is_refused(values, message):
    with pytest.raises(InputError, match=message):
        RateGyro(**values).check()
