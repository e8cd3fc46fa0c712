"""Laws with a reference, flown: no lag at orbit rate and in a slew, whatever the command delay."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest

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
    Guided,
    Nadir,
    Reference,
    SlewLimits,
    Slews,
    WheelEnvelope,
    reference_at,
    toward,
)
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error_angle, to_inertial
from gyrostat.simulation import Status, simulate
from gyrostat.spacecraft import CircularOrbit, Gyrostat, Spacecraft, SpacecraftSensor
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
LIMITS = SlewLimits(np.radians(0.7), np.radians(0.05), np.radians(0.02))
SLEW = Slews.to(REST, [5.0], [[0.6, 0.48, 0.0, 0.64]], LIMITS)


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
    regulator = AttitudeRegulator(CRAFT, jnp.asarray(REST), 1e-4, 1e-3, 1.0)
    return regulator.linear() if name == "lqr" else regulator


def behind(data):
    """Angle to the target, (time,), deg."""
    return np.degrees(
        jax.jit(jax.vmap(error_angle))(
            jnp.asarray(data.attitude.values), jnp.asarray(data.target.values)
        )
    )


def flown(name, profile, *, duration, period, delay):
    motion = reference_at(profile, 0.0)
    start = PLANT.start(attitude=motion.attitude, rate=motion.rate, wheel_speed=SPEEDS)
    control = Guided(law_of(name, start, delay), Reference.of(profile), delay)
    data = simulate(
        PLANT,
        control,
        SpacecraftSensor(PLANT),
        start=start,
        duration=duration,
        control_period=period,
        command_delay=delay,
    )
    assert data.status == Status.COMPLETE
    return data


@pytest.mark.parametrize(
    ("name", "period", "delay"),
    [
        ("wheel_array", 0.5, 0),
        ("wheel_array", 0.1, 2),
        ("three_axis", 0.5, 1),
        ("lqr", 0.5, 2),
        ("sdre", 0.25, 0),
    ],
)
def test_no_law_lags_at_orbit_rate_and_in_a_slew(name, period, delay):
    """1e-4 deg at nadir after the transient of the delay; 0.01 deg over the whole slew."""
    data = flown(name, NADIR, duration=120.0, period=period, delay=delay)
    late = data.time.values > (80.0 if delay else 0.0)
    assert np.max(behind(data)[late]) < 1e-4
    slew = flown(name, SLEW, duration=170.0, period=period, delay=delay)
    assert np.max(np.linalg.norm(slew.rate.values, axis=1)) == pytest.approx(
        np.radians(0.7), rel=1e-3
    )
    assert np.max(behind(slew)) < 1e-2


def test_the_motion_is_neither_taken_for_drag_nor_for_an_external_torque():
    """The wheels alone turn the body: momentum is conserved, and the estimates stay at zero."""
    data = flown("wheel_array", SLEW, duration=170.0, period=0.5, delay=0)
    momentum = data.momentum.values
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (len(momentum), 1)), atol=1e-14)
    control = Guided(law_of("wheel_array", None, 0), Reference.of(SLEW))
    memory = control.start(0.5)
    step = jax.jit(lambda memory, row: control(memory, row)[0])
    for k in range(80):
        row = SpacecraftSensor(PLANT)(
            (),
            PLANT.start(data.attitude.values[k], data.rate.values[k], data.wheel_speed.values[k]),
            jax.random.key(0),
        )[1]
        memory = step(memory, row)
    inner = memory.controller
    assert np.max(np.abs(inner.unknown)) < 1e-9
    assert np.max(np.abs(inner.detector.drag)) < 1e-9


def test_the_error_of_the_sampled_acceleration_is_as_documented():
    """a T² / 12 where the acceleration rises to a, in a turn too short for the feedback."""
    abrupt = Slews.to(
        REST,
        [4.0],
        [[0.98, 0.0, 0.0, np.sqrt(1.0 - 0.98**2)]],
        SlewLimits(np.inf, np.radians(0.5), np.radians(1.0)),
    )
    data = flown("wheel_array", abrupt, duration=6.0, period=0.5, delay=0)
    assert behind(data)[10] == pytest.approx(0.5 * 0.25 / 12.0, rel=0.2)


def test_a_missing_sample_does_not_stop_the_clock_of_a_reference():
    reference = Reference.sequence(
        (Fixed(REST), Condition(after=3.0)), (NADIR, Condition()), limits=LIMITS
    )
    start = PLANT.start(wheel_speed=SPEEDS)
    sensor = SpacecraftSensor(PLANT)
    good = sensor((), start, jax.random.key(0))[1]
    guarded = Guarded(Guided(law_of("wheel_array", start, 0), reference), MeasurementGuard.of(good))
    step = jax.jit(lambda memory, measurement: guarded(memory, measurement))
    memory, modes = guarded.start(0.5), []
    bad = good._replace(rate=good.rate * np.nan)
    for k in range(10):
        memory, command = step(memory, bad if 3 <= k <= 7 else good)
        modes.append((int(memory.controller.mode.number), float(memory.controller.mode.start)))
    assert modes[5:] == [(0, 0.0), (1, 3.0), (1, 3.0), (1, 3.0), (1, 3.0)]
    assert int(command.mode) == 1
    target = reference.at(memory.controller.mode, 4.5).attitude
    np.testing.assert_allclose(command.target, target, atol=1e-14)


def test_a_slew_within_the_wheels_is_followed_to_its_end():
    """The fastest slew with 0.8 of the torque, with momentum held: no wheel reaches its limit."""
    start = PLANT.start(wheel_speed=SPEEDS)
    envelope = WheelEnvelope.of(CRAFT, total_momentum=start.momentum, wheel_momentum=2e-5 * SPEEDS)
    fastest = Slews.to(REST, [5.0], [[0.6, 0.48, 0.0, 0.64]], SlewLimits(envelope=envelope))
    data = flown("three_axis", fastest, duration=60.0, period=0.25, delay=0)
    assert np.max(behind(data)) < 0.02
    assert np.max(np.abs(data.torque.values)) == pytest.approx(0.8 * 3e-3, rel=0.03)


def test_controllers_that_cannot_follow_are_refused():
    guide = Guided(law_of("lqr", None, 0), Reference.of(NADIR))._guide(
        Reference.of(NADIR).start(), 0.0, 0.1
    )
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
