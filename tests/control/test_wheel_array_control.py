"""The controller of a wheel array: its law by hand, and flown through slews and failures."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control import (
    AttitudeTargets,
    MomentumUnloading,
    NullSpaceControl,
    PseudoInverse,
    WheelArrayControl,
    WheelFaultDetector,
    WheelWear,
)
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector
from gyrostat.simulation import Status, simulate
from gyrostat.spacecraft import (
    Gyrostat,
    Spacecraft,
    SpacecraftMeasurement,
    SpacecraftSensor,
    WheelFailures,
)
from gyrostat.wheel import WheelArray, pyramid_axes
from gyrostat.wheel.friction import ViscousCoulomb

AXES = pyramid_axes(4)
WHEELS = WheelArray(
    AXES,
    np.full(4, 2.0e-5),
    np.full(4, 3.0e-3),
    np.full(4, 1.5e-2),
    ViscousCoulomb(np.full(4, 2e-8), np.full(4, 2e-5)),
)
"""A cubesat's: 3 mN·m, 15 mN·m·s."""
CRAFT = Spacecraft(np.array([[0.12, 0.004, 0], [0.004, 0.10, -0.003], [0, -0.003, 0.06]]), WHEELS)
SLEW = np.array([0.5, -0.5, 0.5, 0.5])
"""120 degrees."""
EARLY = AttitudeTargets(jnp.array([0.0, 10.0]), jnp.array([[1.0, 0, 0, 0], SLEW]))
CONTROL = WheelArrayControl(
    CRAFT,
    EARLY,
    # a band without width, so that all flights have one structure
    null_space=NullSpaceControl.plan(AXES, 1.5e-2, bands=[[0.0, 1e-15]]),
    wear=WheelWear(np.ones(4)),
    unloading=MomentumUnloading(np.full(3, 2e-5), 0.02),
    detector=WheelFaultDetector(
        failure_torque=np.full(4, 5e-4), failure_time=3.0, notified=np.full(4, np.inf)
    ),
)
PLAIN = WheelArrayControl(
    CRAFT, AttitudeTargets.hold([1.0, 0, 0, 0]), allocation=PseudoInverse(), torque_time=np.inf
)
command_of = eqx.filter_jit(lambda control, memory, measurement: control(memory, measurement))


def measured(attitude, rate, momentum):
    known = jnp.ones(4, bool)
    return SpacecraftMeasurement(attitude, jnp.asarray(rate), jnp.asarray(momentum) / 2e-5, known)


def felt(attitude, rate, momentum):
    """Torque that the command gives the body, external and gyroscopic ones included, N·m."""
    rate, momentum = np.asarray(rate), np.asarray(momentum)
    _, command = command_of(PLAIN, PLAIN.start(0.1), measured(attitude, rate, momentum))
    total = CRAFT.inertia @ rate + AXES @ (momentum + 2e-5 * AXES.T @ rate)
    return -AXES @ np.asarray(command.torque) - np.cross(rate, total)


def test_a_small_error_gives_the_two_poles():
    """J^-1 torque is -k k_t e - (k + k_t) w, whatever the wheels carry."""
    error, rate = np.array([1e-5, -2e-5, 3e-5]), np.array([2e-6, 1e-6, -3e-6])
    attitude = from_rotation_vector(jnp.asarray(error))
    wanted = -CRAFT.inertia @ (0.4 * 0.1 * error + 0.5 * rate)
    found = felt(attitude, rate, [5e-3, -6e-3, 7e-3, 2e-3])
    assert np.allclose(found, wanted, rtol=1e-3, atol=1e-12)


def test_nothing_is_done_at_rest_at_the_target():
    assert np.allclose(felt(jnp.array([-1.0, 0, 0, 0]), np.zeros(3), [1e-3, 2e-3, 0, 0]), 0.0)


def turned(flight):
    """Rotations from the target to the attitude."""
    target, attitude = (
        Rotation.from_quat(v.values, scalar_first=True) for v in (flight.target, flight.attitude)
    )
    return target.inv() * attitude


def settled(flight, after):
    """Largest error from the target after a time, rad."""
    return float(np.max(turned(flight).magnitude()[flight.time.values >= after]))


PERIOD = 0.5
TIMES = PERIOD * jnp.arange(1001)
ORBIT, AGILE = np.array([0.0, -1.084e-3, 0.0]), np.radians(0.7) * np.array([0.6, 0.0, 0.8])
"""rad/s: a nadir target in a low orbit, and a ground target that passes."""


def moving(rate):
    """Targets that turn at a constant rate, one for each sample."""
    return AttitudeTargets(
        TIMES, jax.jit(jax.vmap(lambda t: from_rotation_vector(t * rate)))(TIMES)
    )


@pytest.fixture(scope="module")
def flights():
    """A slew of 120 degrees from 10 s on, alone and through two kinds of failure; moving targets;
    the slew with frictionless wheels, with and without null-space control.

    All of one structure, so that it is compiled once; a batch would compile for twice as long.
    """
    slew = AttitudeTargets(TIMES, jax.jit(jax.vmap(EARLY))(TIMES))
    control = dataclasses.replace(CONTROL, targets=slew)
    follow = [dataclasses.replace(CONTROL, targets=moving(rate)) for rate in (ORBIT, AGILE)]
    none = WheelFailures.none(4)
    plant = Gyrostat(
        CRAFT, none, np.array([2e-6, -1e-6, 1.5e-6]), external_torque_limit=np.full(3, 2e-5)
    )
    told = dataclasses.replace(control.detector, notified=np.array([np.inf, np.inf, 42.0, np.inf]))
    failures = [none, none.torque_lost(0, 40.0), none.seizes(2, 40.0)]
    plants = [eqx.tree_at(lambda p: p.failures, plant, f) for f in [*failures, *4 * [none]]]
    smooth = ViscousCoulomb(np.zeros(4), np.zeros(4))
    plants[5:] = [eqx.tree_at(lambda p: p.spacecraft.wheels.friction, plant, smooth)] * 2
    banded = NullSpaceControl.plan(AXES, 1.5e-2, bands=[[4e-3, 6e-3]], clearance=1e-3)
    still = dataclasses.replace(banded, gain=0.0)
    worn = dataclasses.replace(control, wear=WheelWear(np.array([1.0, 3.0, 1.0, 1.0])))
    controls = [control, control, dataclasses.replace(control, detector=told), *follow]
    controls += [dataclasses.replace(worn, null_space=null) for null in (banded, still)]
    start = plant.start(wheel_speed=[200.0, -200.0, 200.0, -200.0])
    options = {"start": start, "duration": 500.0, "control_period": PERIOD}
    sensor = SpacecraftSensor(plant)
    found = [
        simulate(plant, control, sensor, **options)
        for plant, control in zip(plants, controls, strict=True)
    ]
    assert all(flight.status == Status.COMPLETE for flight in found)
    return found


@pytest.mark.parametrize(("number", "rate", "degrees"), [(3, ORBIT, 0.776), (4, AGILE, 8.75)])
def test_a_moving_target_is_followed_at_the_distance_that_the_documentation_tells(
    flights, number, rate, degrees
):
    """W (1 / k + 1 / k_t) behind, to 1 %, from the time on at which drag and torques are found."""
    flight = flights[number]
    behind = -turned(flight).as_rotvec()[flight.time.values >= 300.0]
    lag = rate * (1.0 / CONTROL.rate_gain + 1.0 / CONTROL.turn_gain)
    assert np.degrees(np.linalg.norm(lag)) == pytest.approx(degrees, rel=2e-3)
    np.testing.assert_allclose(
        behind, np.tile(lag, (len(behind), 1)), atol=0.01 * np.linalg.norm(lag)
    )


def test_a_slew_keeps_its_limits_and_ends_at_rest(flights):
    """In spite of friction and an external torque, which the controller does not know."""
    flight = flights[0]
    rate = np.linalg.norm(flight.rate, axis=1)
    assert np.max(rate) == pytest.approx(0.05, rel=0.02)
    assert np.max(np.abs(flight.torque)) <= 3e-3
    assert settled(flight, 300.0) < 1e-4
    assert settled(flight, 450.0) < 2e-6
    # the shortest way, 120 degrees at 0.05 rad/s, and what speeding up, braking and settling take
    assert settled(flight, 10.0 + 2.0 * np.pi / 3.0 / 0.05 + 60.0) < 1e-2


def test_the_slew_turns_about_one_axis(flights):
    """Away from the error axis the body turns by less than 3 % of its rate."""
    flight = flights[0].isel(time=slice(30, 90))
    axis = np.array([-1.0, 1.0, 1.0]) / np.sqrt(3.0)
    rate = flight.rate.values
    assert np.all(np.linalg.norm(np.cross(rate, axis), axis=1) < 0.03 * (rate @ axis))


def test_the_wheels_stay_clear_of_zero_and_of_their_limit(flights):
    momentum = np.abs(flights[0].wheel_momentum.values[600:])
    assert np.min(momentum) > 1e-3
    assert np.max(momentum) < 1.4e-2


def test_momentum_is_held_where_the_external_actuator_balances_the_torque(flights):
    """H = T / k in the end, and not the 1e-3 N·m·s that the torque would pile up."""
    flight = flights[0]
    start, end = flight.momentum.values[0], flight.momentum.values[-1]
    assert np.linalg.norm(end) == pytest.approx(np.linalg.norm([1e-4, 5e-5, 7.5e-5]), rel=1e-2)
    assert np.linalg.norm(start) < 1e-9


def test_a_dead_motor_is_found_and_the_others_take_over(flights):
    """While its rotor runs down, until 270 s, the others bear its drag; then it rubs no more.

    They are at zero shortly before, as the sum of all is near zero.
    """
    works, time = flights[1].works.values, flights[1].time.values
    found = time[np.argmin(works[:, 0])]
    assert 40.0 < found < 100.0
    assert np.all(works[:, 1:])
    assert np.all(flights[1].torque.values[time >= found, 0] == 0.0)
    rests = time[np.argmax(flights[1].wheel_speed.values[:, 0] == 0.0)]
    assert rests == pytest.approx(270.0, abs=5.0)
    rubbing = flights[1].isel(time=slice(0, int((rests - 15.0) / 0.5)))
    assert settled(rubbing, 200.0) < 1e-4
    assert settled(flights[1], 400.0) < 1e-4


def test_a_seized_wheel_that_is_told_is_left_out(flights):
    works, time = flights[2].works.values, flights[2].time.values
    assert np.all(works[time < 40.0])
    assert not np.any(works[time >= 42.0, 2])
    assert np.all(works[:, [0, 1, 3]])
    assert settled(flights[2], 400.0) < 1e-4


def test_targets_come_at_their_times():
    for time, expected in ((-1.0, [1.0, 0, 0, 0]), (9.99, [1.0, 0, 0, 0]), (10.0, SLEW)):
        assert np.array_equal(EARLY(time), expected)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"turn_gain": 0.0}, "turn gain"),
        ({"rate_gain": np.nan}, "rate gain"),
        ({"largest_rate": -1.0}, "largest rate"),
        ({"torque_time": 0.0}, "torque time"),
        ({"targets": AttitudeTargets(jnp.zeros(2), jnp.ones((2, 4)) / 2)}, "increasing"),
        ({"targets": AttitudeTargets([], np.zeros((0, 4)))}, "increasing"),
        ({"targets": AttitudeTargets.hold([1.0, 1.0, 0, 0])}, "length"),
        ({"targets": AttitudeTargets(jnp.zeros(1), jnp.ones((2, 4)) / 2)}, "targets: found shape"),
        ({"detector": WheelFaultDetector(notified=np.nan)}, "notified"),
        ({"detector": WheelFaultDetector(failure_torque=0.0)}, "failure torque"),
        ({"unloading": MomentumUnloading(np.ones(3), 0.0)}, "gain of the momentum"),
        ({"spacecraft": Spacecraft(9.0 * np.eye(3), WheelArray(AXES, np.ones(4)))}, "torque_limit"),
    ],
)
def test_a_controller_that_cannot_work_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        dataclasses.replace(PLAIN, **changes).check()


def test_a_period_too_long_for_the_gain_is_refused():
    CONTROL.check_period(1.25)
    with pytest.raises(InputError, match=r"expected 1\.25 s or less"):
        CONTROL.check_period(1.26)


def test_a_body_with_frictionless_wheels_does_not_feel_the_null_space(flights):
    """The slew with bands and wear, and without null-space control: the same to rounding."""
    with_it, without = flights[5], flights[6]
    assert np.max(np.abs(with_it.wheel_speed.values - without.wheel_speed.values)) > 100.0
    assert np.max(np.abs(with_it.attitude.values - without.attitude.values)) < 1e-11
    assert np.max(np.abs(with_it.rate.values - without.rate.values)) < 1e-11
    assert np.max(np.abs(without.rate.values)) > 0.02
