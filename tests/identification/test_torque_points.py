"""Measured points of the friction curve."""

from dataclasses import replace

import numpy as np

from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.torque_points import torque_points, torque_regression


def test_measured_points_lie_on_the_true_curve_of_both_directions(record, truth):
    """No friction model takes part: they scatter about the truth by their own errors."""
    fit = identify(record(), inertia=1.5e-3, speed_sigma=5.0 * RPM, white_noise=True)
    points = torque_points(fit)
    assert points is not None
    assert points.speed.min() < -20.0
    assert points.speed.max() > 20.0
    true = truth["stribeck"]
    curve = true["viscous"] * points.speed + true["coulomb"] * np.sign(points.speed)
    # the points rest on the estimated motor constant
    motor = fit.sigma[fit.names.index("motor_constant")] * 0.15
    z = (points.torque - curve) / np.hypot(points.sigma, motor)
    assert np.sqrt(np.mean(z**2)) < 1.8
    assert np.max(np.abs(z)) < 4.5


def test_the_regression_on_torque_agrees_with_the_fit_and_with_the_truth(record, truth):
    fit = identify(record(), inertia=1.5e-3, speed_sigma=5.0 * RPM, white_noise=True)
    rows = torque_regression(fit)
    assert [row.name for row in rows] == ["motor_constant", "viscous", "coulomb"]
    for row in rows:
        assert abs(row.value - truth["stribeck"][row.name]) < 4.0 * row.sigma
        assert abs(row.disagreement) < 4.0


def test_a_mirrored_record_has_mirrored_points(record):
    """Speed and current of the other sign: the same friction, but for the bins at the ends.

    The largest speed is the edge of a bin, which belongs to one side.
    """
    points = []
    for sign in (1.0, -1.0):
        given = record()
        given = replace(given, speed=sign * given.speed, current=sign * given.current)
        fit = identify(given, inertia=1.5e-3, speed_sigma=5.0 * RPM, white_noise=True)
        points.append(torque_points(fit))
    inner = slice(1, -1)
    np.testing.assert_allclose(points[1].speed[inner], -points[0].speed[::-1][inner], rtol=1e-9)
    np.testing.assert_allclose(points[1].torque[inner], -points[0].torque[::-1][inner], rtol=1e-4)
