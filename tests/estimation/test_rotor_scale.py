"""Rotor inertias and total momentum from body rate and wheel speeds."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.estimation import RotorScaleFilter
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel import WheelArray

AXES = np.array([[1.0, 0.0], [0.0, 0.8], [0.0, 0.6]])
ROTOR, SCALE, PERIOD = 0.45, np.array([1.04, 0.97]), 0.1
CRAFT = Spacecraft(np.diag([400.0, 500.0, 600.0]), WheelArray(AXES, np.full(2, ROTOR)))
INERTIA = np.asarray(CRAFT.inertia_locked())
MOMENTUM = np.array([0.1, -0.2, 0.05])


def record(count, noise=0.0):
    """A slew: rates that the true rotors give at each attitude and wheel speed."""
    random = np.random.default_rng(3)
    time = PERIOD * np.arange(count)
    attitude = Rotation.from_rotvec(np.outer(0.01 * time, [1.0, 0.5, -0.3]))
    speed = np.stack([3.0 * np.sin(0.05 * time), 2.0 * np.cos(0.04 * time)], axis=1)
    held = (ROTOR * SCALE * speed) @ AXES.T
    rate = np.linalg.solve(INERTIA, (attitude.inv().apply(MOMENTUM) - held).T).T
    return attitude, rate + noise * random.standard_normal(rate.shape), speed


def filtered(own, attitude, rate, speed):
    estimate, step = own.start(), jax.jit(own.__call__)
    for q, w, s in zip(attitude.as_quat(scalar_first=True), rate, speed, strict=True):
        estimate = step(estimate, q, w, s, PERIOD)
    return estimate


def test_exact_measurements_give_the_true_rotors():
    found = filtered(RotorScaleFilter(CRAFT, rate_sigma=1e-9), *record(200))
    np.testing.assert_allclose(found.scale, SCALE, rtol=1e-6)
    np.testing.assert_allclose(found.momentum, MOMENTUM, rtol=1e-6)


def test_a_constant_momentum_is_least_squares_with_the_prior():
    own = RotorScaleFilter(CRAFT, time=1e9, rate_sigma=1e-5)
    attitude, rate, speed = record(60, noise=1e-5)
    found = filtered(own, attitude, rate, speed)
    sigma = np.max(np.diag(INERTIA)) * 1e-5
    rows, right = (
        [np.diag([*(3 * [1.0 / np.sqrt(1e9)]), *(2 * [sigma / 0.05])])],
        [np.array([0.0, 0.0, 0.0, *(2 * [sigma / 0.05])])],
    )
    for matrix, w, s in zip(attitude.as_matrix(), rate, speed, strict=True):
        rows.append(np.hstack([matrix.T, -AXES * (ROTOR * s)]))
        right.append(INERTIA @ w)
    best = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    np.testing.assert_allclose([*found.momentum, *found.scale], best, rtol=1e-7)
    assert np.all(np.abs(found.scale - SCALE) < 4.0 * np.sqrt(np.diag(found.covariance)[3:]))


def test_the_covariance_keeps_its_digits_after_an_unknown_start():
    own = RotorScaleFilter(CRAFT, time=1e9, rate_sigma=1e-5)
    attitude, rate, speed = record(3)
    found = filtered(own, attitude, rate, speed)
    sigma = np.max(np.diag(INERTIA)) * 1e-5
    # the information in units of the noise; its prior is 1e-9 for the momentum
    information = np.diag([*(3 * [1e-9]), *(2 * [(sigma / 0.05) ** 2])])
    for matrix, s in zip(attitude.as_matrix(), speed, strict=True):
        row = np.hstack([matrix.T, -AXES * (ROTOR * s)])
        information = information + row.T @ row
    scale = np.sqrt(np.diag(information))
    exact = sigma**2 * np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    size = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert np.max(np.abs(found.covariance - exact) / size) < 1e-12


def test_wheels_at_rest_tell_nothing_of_their_inertia():
    attitude, rate, speed = record(50)
    found = filtered(RotorScaleFilter(CRAFT), attitude, rate, 0.0 * speed)
    np.testing.assert_array_equal(found.scale, 1.0)
    np.testing.assert_allclose(np.diag(found.covariance)[3:], 0.05**2)


def test_a_filter_without_uncertainty_is_refused():
    with pytest.raises(InputError, match="rotor sigma: found 0"):
        RotorScaleFilter(CRAFT, rotor_sigma=0.0).check()
