"""Observer of the total momentum under an external torque."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control.underactuated.recovery.momentum_estimate import MomentumEstimate

STILL = np.array([1.0, 0.0, 0.0, 0.0])
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7])


@pytest.mark.parametrize(("period", "time"), [(0.5, 20.0), (2.0, 5.0)])
def test_both_poles_of_the_observer_are_those_of_its_time_constant(period, time):
    """The map from one error of momentum and torque to the next one, as a matrix."""
    columns = []
    for momentum, torque in ((1.0, 0.0), (0.0, 1.0)):
        before = MomentumEstimate(np.full(3, momentum), np.full(3, torque), period)
        after = before.updated(STILL, np.zeros(3), time)
        columns.append([after.momentum[0], after.torque[0]])
    pole = np.exp(-period / time)
    trace, product = np.trace(columns), np.linalg.det(columns)
    assert trace == pytest.approx(2.0 * pole, rel=1e-12)
    assert product == pytest.approx(pole**2, rel=1e-12)


def test_a_constant_torque_leaves_no_error():
    torque, period = np.array([1e-3, -2e-3, 5e-4]), 0.5
    estimate = MomentumEstimate(np.zeros(3), np.zeros(3), period)
    for number in range(1, 400):
        inertial = number * period * torque
        attitude = np.roll(TURN.as_quat(), 1)  # scalar first
        estimate = estimate.updated(attitude, TURN.inv().apply(inertial), 5.0)
    np.testing.assert_allclose(estimate.momentum, inertial, rtol=1e-9)
    np.testing.assert_allclose(estimate.torque, torque, rtol=1e-9)
