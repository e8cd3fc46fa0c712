"""Laws with a reference, flown: no lag at orbit rate and in a slew, whatever the command delay."""

import dataclasses
import functools
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control import (
    AttitudeRegulator,
    AttitudeTargets,
    Guarded,
    MeasurementGuard,
    MomentumRecovery,
    TwoWheelPointing,
    WheelArrayControl,
    WheelFaultDetector,
)
from gyrostat.control.guidance import (
    Condition,
    Fixed,
    Guide,
    Guided,
    Nadir,
    Reference,
    SlewLimits,
    Slews,
    WheelEnvelope,
    reference_at,
    toward,
)
from gyrostat.control.recorded import recorded_with
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import product, to_body, to_inertial
from gyrostat.simulation import Status, simulate
from gyrostat.spacecraft import (
    CircularOrbit,
    Gyrostat,
    Spacecraft,
    SpacecraftMeasurement,
    SpacecraftSensor,
)
from gyrostat.wheel import WheelArray, pyramid_axes

REST = np.array([1.0, 0.0, 0.0, 0.0])
AXES = pyramid_axes(4)
CRAFT = Spacecraft(
    np.array([[0.12, 0.004, 0], [0.004, 0.10, -0.003], [0, -0.003, 0.06]]),
    WheelArray(AXES, np.full(4, 2e-5), np.full(4, 3e-3), np.full(4, 1.5e-2)),
)
PLANT = Gyrostat(CRAFT)
SPEEDS = np.array([200.0, -150.0, 220.0, -180.0])
"""The total momentum is not zero, so that the wheels must turn it with the body."""
NADIR = Nadir.pointing(CircularOrbit.at_altitude(500e3, inclination=1.7, latitude=0.3))
LIMITS = SlewLimits(*np.radians([0.7, 0.05, 0.02]))


class Estimates(NamedTuple):
    """What a wheel array's controller takes for an external torque and for drag, N·m."""

    unknown: Any
    drag: Any


class Watched(eqx.Module):
    """Guided wheel array control whose estimates are recorded with its command."""

    guided: Guided

    def start(self, period):
        return self.guided.start(period)

    def __call__(self, memory, measurement):
        memory, command = self.guided(memory, measurement)
        inner = memory.controller
        estimates = Estimates(inner.unknown.torque, inner.detector.drag)
        return memory, recorded_with("Watched", command, estimates)


class Pass(eqx.Module):
    """Slews relative to nadir."""

    nadir: Nadir
    slews: Slews

    def __call__(self, time):
        return product(self.nadir(time), self.slews(time))


def passing(limits):
    """Nadir for 80 s, then a slew of 47 deg."""
    turned = np.array([[0.92, 0.24, 0.0, 0.3098387]])
    return Pass(NADIR, jax.jit(Slews.to)(REST, np.array([80.0]), turned, limits))


def law_of(name, start, delay):
    if name == "wheel_array":
        return WheelArrayControl(
            CRAFT, AttitudeTargets.hold(REST), detector=WheelFaultDetector(delay=delay)
        )
    if name == "three_axis":
        found = MomentumRecovery.plan(
            CRAFT, np.ones(4, bool), total_momentum=start.momentum, target=REST
        )
        loop = dataclasses.replace(found.law.wheels, delay=delay)
        return eqx.tree_at(lambda f: f.law.wheels, found, loop)
    return AttitudeRegulator(CRAFT, jnp.asarray(REST), 1e-4, 1e-3, 1.0)


def behind(data):
    """Angle to the target, (time,), deg."""
    attitude, target = (
        Rotation.from_quat(each.values, scalar_first=True) for each in (data.attitude, data.target)
    )
    return np.degrees((target.inv() * attitude).magnitude())


@pytest.fixture(scope="module")
def flown(frictionless):
    """Fly a law along a reference; its wheels have no friction, and reach no limit."""
    return functools.partial(fly, frictionless(PLANT))


def fly(plant, name, profile, *, period, delay, duration=170.0):
    motion = jax.jit(lambda: reference_at(profile, 0.0))()
    start = PLANT.start(attitude=motion.attitude, rate=motion.rate, wheel_speed=SPEEDS)
    control = Guided(law_of(name, start, delay), Reference.of(profile), delay)
    if name == "wheel_array":
        control = Watched(control)
    data = simulate(
        plant,
        control,
        SpacecraftSensor(PLANT),
        start=start,
        duration=duration,
        control_period=period,
        command_delay=delay,
    )
    assert data.status == Status.COMPLETE
    return data


@pytest.fixture(scope="module")
def array_flight(flown):
    return flown("wheel_array", passing(LIMITS), period=0.5, delay=2)


def assert_no_lag(data):
    """1e-4 deg at nadir after the transient of the delay, 0.01 deg over the slew."""
    angles, time = behind(data), data.time.values
    assert np.max(angles[(time > 70.0) & (time < 80.0)]) < 1e-4
    assert np.max(angles[time > 80.0]) < 1e-2
    fastest = np.max(np.linalg.norm(data.rate.values, axis=1))
    assert fastest == pytest.approx(np.radians(0.7), rel=0.1)


def test_wheel_array_control_does_not_lag(array_flight):
    assert_no_lag(array_flight)


@pytest.mark.parametrize(("name", "period", "delay"), [("three_axis", 0.25, 0), ("sdre", 0.5, 1)])
def test_the_other_laws_do_not_lag(flown, name, period, delay):
    assert_no_lag(flown(name, passing(LIMITS), period=period, delay=delay))


def test_the_motion_is_neither_taken_for_drag_nor_for_an_external_torque(array_flight):
    """The wheels alone turn the body: momentum is conserved, and the estimates stay at zero."""
    momentum = array_flight.momentum.values
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (len(momentum), 1)), atol=1e-14)
    assert np.max(np.abs(array_flight.unknown)) < 1e-9
    assert np.max(np.abs(array_flight.drag)) < 1e-9


def test_the_error_of_the_sampled_acceleration_is_as_documented(flown):
    """a T² / 12 where the acceleration rises to a, before the feedback removes it."""
    steep = SlewLimits(np.inf, np.radians(0.5), np.radians(1.0))
    data = flown("three_axis", passing(steep), period=0.25, delay=0)
    angles = behind(data)[data.time.values == 80.75]
    assert angles == pytest.approx(0.5 * 0.25**2 / 12.0, rel=0.3)


class Idle(eqx.Module):
    """Controller that reports its reference and commands nothing."""

    reference: Any = None

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, memory, measurement):
        target = self.reference(memory)
        return memory + 0.5, Report(jnp.zeros(4), target.rate)


class Report(NamedTuple):
    """Command."""

    torque: Any
    wanted: Any


def test_a_missing_sample_does_not_stop_the_clock_of_a_reference():
    reference = Reference.sequence(
        (Fixed(REST), Condition(after=3.0)),
        (Fixed(np.array([0.8, 0.6, 0.0, 0.0])), Condition()),
        limits=LIMITS,
    )
    start = PLANT.start(wheel_speed=SPEEDS)
    good = SpacecraftMeasurement(
        jnp.asarray(REST), jnp.zeros(3), start.wheel_speed, jnp.ones(4, bool)
    )
    guarded = Guarded(Guided(Idle(), reference), MeasurementGuard.of(good))
    step = jax.jit(lambda memory, measurement: guarded(memory, measurement))
    # no weak types, so that it is compiled once
    memory = jax.tree.map(lambda leaf: jnp.asarray(leaf, leaf.dtype), guarded.start(0.5))
    modes = []
    bad = good._replace(rate=good.rate * np.nan)
    for k in range(10):
        memory, command = step(memory, bad if 3 <= k <= 7 else good)
        modes.append((int(memory.controller.mode.number), float(memory.controller.mode.start)))
    assert modes[5:] == [(0, 0.0), (1, 3.0), (1, 3.0), (1, 3.0), (1, 3.0)]
    assert int(command.mode) == 1
    # 1.5 s of the slew about the first axis
    turned = 0.5 * jax.jit(memory.controller.mode.transition.profile.__call__)(1.5)
    assert turned > 1e-5
    np.testing.assert_allclose(command.target, [np.cos(turned), np.sin(turned), 0, 0], atol=1e-14)


def test_a_slew_within_the_wheels_is_followed_to_its_end(flown):
    """The fastest slew with 0.8 of the torque, with momentum held: no wheel reaches its limit.

    The plant has no limits: what is commanded keeps within those of the wheels.
    """
    attitude = NADIR(80.0)
    total = PLANT.start(attitude=NADIR(0.0), wheel_speed=SPEEDS).momentum
    envelope = WheelEnvelope.of(
        CRAFT,
        total_momentum=to_body(attitude, total),
        wheel_momentum=2e-5 * SPEEDS,
    )
    fastest = passing(SlewLimits(envelope=envelope))
    slews = fastest.slews
    data = flown("three_axis", fastest, period=0.25, delay=0)
    steepest = float(slews.profiles.acceleration[0])
    assert np.max(behind(data)) < np.degrees(steepest) * 0.25**2 / 4.0
    assert np.max(np.abs(data.torque.values)) == pytest.approx(0.8 * 3e-3, rel=0.1)
    assert np.max(np.abs(data.wheel_momentum.values)) < 1.5e-2


def test_controllers_that_cannot_follow_are_refused():
    bound = Reference.of(NADIR).bound(Reference.of(NADIR).start())
    guide = Guide.of(bound, bound(0.0), 0.0, 0.1, 0)
    two = Spacecraft(CRAFT.inertia, WheelArray(AXES[:, :2], np.full(2, 2e-5), 3e-3, 1.5e-2))
    with pytest.raises(InputError, match="TwoWheelPointing: found a controller that cannot follow"):
        toward(TwoWheelPointing(two), guide)
    plan = MomentumRecovery.plan(
        CRAFT,
        [True, True, False, False],
        total_momentum=np.asarray(to_inertial(jnp.asarray(REST), jnp.array([3e-3, 1e-3, 2e-3]))),
        target=REST,
    )
    with pytest.raises(InputError, match="expected a fixed target"):
        toward(plan, guide)
