"""Recoveries on the full gyrostat, from the failure on."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.failures import Loss, earliest_settling, holdable, plan_recovery, recover
from gyrostat.spacecraft import Gyrostat, Spacecraft
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

ROTOR = 0.01
SMOOTH = ViscousCoulomb(np.zeros(3), np.zeros(3))
"""No friction, given for each wheel as a brake is: flights with and without one share a program."""
WHEELS = WheelArray(np.eye(3), np.full(3, ROTOR), np.full(3, 0.1), np.full(3, 3.0), SMOOTH)
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


def test_a_braked_wheel_stops_and_settling_comes_sooner():
    """Its motor takes 0.02 N·m: 0.3 N·m·s in 15 s."""
    frozen = Loss("frozen", brake_torque=0.02)
    found = recover(CRAFT, START, {1: frozen}, target=TARGET, duration=600.0)
    # the wheel loses its momentum at this rate, and then stays at rest against the body
    rates = found.flight.rate.values
    held = found.flight.wheel_momentum.values[:, 1] + ROTOR * rates[:, 1]
    time = found.flight.time.values
    np.testing.assert_allclose(held[time <= 10.0], held[0] + 0.02 * time[time <= 10.0], atol=1e-9)
    assert np.all(np.abs(found.flight.wheel_speed.values[time >= 20.0, 1]) < 1e-9)
    assert found.earliest[1] < found.settle < 100.0
    # a wheel that keeps turning has another nearest attitude
    other = found.without_brakes
    assert other.plan.answer.angle != pytest.approx(found.plan.answer.angle, abs=1e-3)
    assert other.gains[1].angle == pytest.approx(found.plan.answer.angle)
    assert found.to_dict(("a", "b", "c"))["without_brakes"]["gains"]["b"]["torque"] == 0.1


@pytest.mark.parametrize(
    "loss",
    [
        Loss("rundown", 90.0),
        Loss("frozen", brake_time=8.0),
        Loss("rundown", 90.0, brake_time=8.0, brake_torque=2e-3),
        Loss("frozen", brake_torque=2e-3),
    ],
)
def test_the_earliest_settling_is_when_the_momentum_of_the_wheel_matters_no_more(loss):
    answer = holdable(CRAFT, START.momentum, failed={1: 0.0}, target=TARGET)
    working, error = np.array([True, False, True]), 1e-3
    given = {"momentum": -0.3, "loss": loss, "error": error}
    time = earliest_settling(CRAFT, answer, working, 1, **given)
    # all other momentum is in the plane of the working wheels, x and z
    left = error * np.hypot(*answer.momentum_in_body[[0, 2]])

    def slope(_, momentum):
        own = (loss.kind == "rundown") / loss.time_constant
        return -(own + 1.0 / (loss.brake_time or np.inf)) * momentum - loss.brake_torque

    below = solve_ivp(
        slope, (0.0, 2000.0), [0.3], events=lambda _, h: h[0] - left, rtol=1e-10, atol=1e-13
    )
    assert time == pytest.approx(below.t_events[0][0], rel=1e-6)


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
        ({1: ("rundown", 60.0, 0.0)}, "time constant of the brake: found 0"),
        ({1: ("frozen", 60.0, None, -1.0)}, "brake torque: found -1, expected a finite value"),
        ({1: ("seized", 60.0, 8.0)}, "brake: found a seized wheel"),
    ],
)
def test_refusals(losses, found):
    with pytest.raises(InputError, match=found):
        recover(CRAFT, START, {k: Loss(*v) for k, v in losses.items()}, target=TARGET)


def test_too_little_momentum_and_a_wheel_that_turns_is_said():
    plan = plan_recovery(CRAFT, [0.0, 0.0, 0.5], failed={2: 0.5}, target=TARGET)
    assert plan.controller is None
    assert "still turns" in plan.reason
