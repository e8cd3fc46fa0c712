"""Recoveries on the full gyrostat, from the failure on."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.failures import Loss, plan_recovery, recover
from gyrostat.spacecraft import Gyrostat, Spacecraft
from gyrostat.wheel import WheelArray

ROTOR = 0.01
WHEELS = WheelArray(np.eye(3), np.full(3, ROTOR), np.full(3, 0.1), np.full(3, 3.0))
CRAFT = Spacecraft(np.diag([8.0, 12.0, 16.0]), WHEELS)
CUBE = Spacecraft(np.diag([12.0, 12.0, 12.0]), WHEELS)
TARGET = np.array([1.0, 0.0, 0.0, 0.0])
START = Gyrostat(CRAFT).start(
    attitude=Rotation.from_rotvec([0.5, -0.4, 0.8]).as_quat(scalar_first=True),
    rate=[0.01, -0.02, 0.01],
    wheel_speed=[40.0, -30.0, 60.0],
)


@pytest.mark.parametrize("kind", ["frozen", "seized", "rundown"])
def test_two_wheels_and_momentum_settle_at_the_nearest_attitude(kind):
    found = recover(CRAFT, START, {1: Loss(kind)}, target=TARGET, duration=600.0)
    assert found.reason == ""
    assert 0.0 < found.settle < 400.0
    flight, answer = found.flight, found.plan.answer
    # at rest there, the failed wheel holds what was declared
    last = flight.isel(time=-1)
    held = last.wheel_momentum.values + ROTOR * last.rate.values
    np.testing.assert_allclose(held[1], answer.wheel_momentum[1], atol=2e-3)
    turned = Rotation.from_quat(last.attitude.values, scalar_first=True)
    nearest = Rotation.from_quat(answer.attitude, scalar_first=True)
    assert np.degrees((turned.inv() * nearest).magnitude()) < 0.05
    # with the momentum of the start
    total = turned.apply(held + np.diag([8.0, 12.0, 16.0]) @ last.rate.values)
    np.testing.assert_allclose(total, START.momentum, rtol=1e-8)
    assert np.max(np.abs(flight.torque.values)) <= 0.1 + 1e-12
    late = flight.time.values >= found.settle
    assert np.all(np.degrees(flight.error.values[late]) < 0.05)


def test_a_wheel_that_runs_down_slowly_decides_the_time():
    """It holds h exp(-t / tau): until the circle of what can be held is where it is aimed at."""
    constant, total = 90.0, np.linalg.norm(START.momentum)
    found = recover(CRAFT, START, {1: Loss("rundown", constant)}, target=TARGET, duration=600.0)
    # at the target nothing is along the axis of the wheel: all of the momentum is across
    held = ROTOR * (float(START.wheel_speed[1]) + float(Gyrostat(CRAFT).rate(START)[1]))
    gone = constant * np.log(abs(held) / (total * np.radians(0.05)))
    assert 100.0 + 15.0 * 16.0 / total < gone
    assert 0.95 * gone < found.settle <= gone + 0.5


def test_without_momentum_the_wheels_sweep():
    still = Gyrostat(CRAFT).start(attitude=START.attitude)
    found = recover(
        CRAFT, still, {2: Loss("seized")}, target=TARGET, duration=200.0, control_period=0.1
    )
    assert type(found.plan.controller).__name__ == "ZeroMomentumRecovery"
    assert found.settle < 105.0
    assert found.plan.answer.angle == 0.0


def test_a_failure_that_leaves_three_directions_is_three_axis_control():
    pyramid = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, 1, 1, 1]]) / np.sqrt(3.0)
    wheels = WheelArray(pyramid, np.full(4, ROTOR), np.full(4, 0.1), np.full(4, 3.0))
    craft = Spacecraft(CRAFT.inertia, wheels)
    start = Gyrostat(craft).start(attitude=START.attitude, wheel_speed=30.0)
    found = recover(craft, start, {3: Loss("rundown")}, target=TARGET)
    assert found.plan.answer.holdable
    assert found.settle < 200.0


def test_what_cannot_be_recovered_says_why():
    nothing = recover(CRAFT, START, dict.fromkeys(range(3), Loss("seized")), target=TARGET)
    assert nothing.flight is None
    assert nothing.settle is None
    assert nothing.reason.startswith("no attitude is feasible")
    assert nothing.to_dict()["settled"] is False
    short = recover(CRAFT, START, {1: Loss("seized")}, target=TARGET, duration=600.0, known=CRAFT)
    assert short.settle is not None


def test_one_wheel_is_enough_where_the_others_hold_momentum():
    """Two motors dead, their wheels still turning; seized, they give it nothing to lean on."""
    losses = {0: Loss("frozen"), 1: Loss("frozen")}
    found = recover(CUBE, START, losses, target=TARGET, duration=1200.0)
    assert type(found.plan.controller).__name__ == "OneWheelRecovery"
    assert found.settle is not None
    seized = recover(CUBE, START, {0: Loss("seized"), 1: Loss("seized")}, target=TARGET)
    assert seized.flight is None
    assert seized.reason.startswith("out of reach for one wheel")


@pytest.mark.parametrize(
    ("losses", "found"),
    [
        ({3: ("seized", 60.0)}, "failed wheel: found 3"),
        ({1: ("gone", 60.0)}, "found 'gone'"),
        ({1: ("rundown", 0.0)}, "time constant of running down: found 0"),
    ],
)
def test_refusals(losses, found):
    with pytest.raises(InputError, match=found):
        recover(CRAFT, START, {k: Loss(*v) for k, v in losses.items()}, target=TARGET)


def test_too_little_momentum_and_a_wheel_that_turns_is_said():
    plan = plan_recovery(CRAFT, [0.0, 0.0, 0.5], failed={2: 0.5}, target=TARGET)
    assert plan.controller is None
    assert "still turns" in plan.reason
