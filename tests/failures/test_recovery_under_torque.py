"""Recoveries under a constant external torque."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.failures import Loss, holdable, recover
from gyrostat.failures.momentum_drift import momentum_drift
from gyrostat.spacecraft import Gyrostat, Spacecraft
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

SMOOTH = ViscousCoulomb(np.zeros(3), np.zeros(3))
WHEELS = WheelArray(np.eye(3), np.full(3, 0.01), np.full(3, 0.1), np.full(3, 3.0), SMOOTH)
CRAFT = Spacecraft(np.diag([8.0, 12.0, 16.0]), WHEELS)
TARGET = np.array([1.0, 0.0, 0.0, 0.0])
START = Gyrostat(CRAFT).start(
    attitude=Rotation.from_rotvec([0.5, -0.4, 0.8]).as_quat(scalar_first=True),
    rate=[0.01, -0.02, 0.01],
    wheel_speed=[40.0, -30.0, 60.0],
)


@pytest.mark.parametrize("along", [[0.0, 1.0, 0.0], [0.4, 0.8, -0.3]])
def test_the_drift_is_torque_times_time_over_the_momentum_across(along):
    torque, time = 1e-4 * np.array(along), 600.0
    answer = holdable(CRAFT, START.momentum, failed={1: 0.2}, target=TARGET)
    drift = momentum_drift(CRAFT, START.momentum, {1: 0.2}, answer, torque, time)
    # at rest the torque is fixed in space; feasible momenta have 0.2 N·m·s along y
    then = answer.momentum_in_body + torque * time
    size = np.linalg.norm(then)
    wanted = abs(np.arccos(then[1] / size) - np.arccos(0.2 / size))
    assert drift.angle == pytest.approx(wanted, rel=1e-9)
    first = abs(torque[1]) * time / np.hypot(*answer.momentum_in_body[[0, 2]])
    assert drift.angle == pytest.approx(first, rel=0.1)
    assert drift.momentum == pytest.approx(np.linalg.norm(torque) * time)


def test_a_recovery_follows_the_momentum_that_an_external_torque_changes():
    torque, losses = np.array([4e-5, 8e-5, -6e-5]), {1: Loss("frozen")}
    found = recover(CRAFT, START, losses, target=TARGET, external_torque=torque)
    flight, aim = found.flight, found.plan.answer
    turned = Rotation.from_quat(flight.attitude.values, scalar_first=True)
    # H(t) = H(0) + the integral of R T
    pushed = turned.apply(torque)
    gained = 0.5 * np.sum(pushed[1:] + pushed[:-1], axis=0) * 0.5
    total = flight.momentum.values[-1]
    np.testing.assert_allclose(total - START.momentum, gained, atol=1e-5)
    # tilted about n x b from the first aim to where y has the momentum of the failed wheel
    first = Rotation.from_quat(aim.attitude, scalar_first=True)
    body, held = first.inv().apply(total), aim.wheel_momentum[1]
    axis = np.cross([0.0, 1.0, 0.0], body)
    tilt = np.arccos(held / np.linalg.norm(body)) - np.arccos(body[1] / np.linalg.norm(body))
    feasible = first * Rotation.from_rotvec(-tilt * axis / np.linalg.norm(axis))
    away = np.degrees((turned[-1].inv() * feasible).magnitude())
    assert np.degrees(abs(tilt)) > 1.0
    assert np.degrees(flight.error.values[-1]) == pytest.approx(away, abs=1e-5)
    assert away < 0.05
    assert found.settle is not None
    # the torque turns with the body while it slews, which the prediction neglects
    assert found.drift.angle == pytest.approx(abs(tilt), rel=0.25)


def test_without_external_torque_no_momentum_is_estimated():
    found = recover(CRAFT, START, {1: Loss("frozen")}, target=TARGET)
    assert found.drift is None
    assert found.plan.controller.momentum_time is None
    assert found.to_dict()["external_torque"] is None


def test_an_external_torque_that_is_no_vector_is_refused():
    for torque in ([1e-4, 0.0], [0.0, np.nan, 0.0]):
        with pytest.raises(InputError, match="external torque: found"):
            recover(CRAFT, START, {1: Loss("frozen")}, target=TARGET, external_torque=torque)
