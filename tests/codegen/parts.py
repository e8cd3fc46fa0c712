"""One example of every public part of the loop, each as a step from arrays to arrays."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np

from gyrostat import control, estimation, spacecraft
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_tuples import with_fields
from gyrostat.papers.carvalho_fenili import reduced_gyrostat, torque_driven
from gyrostat.papers.endo_sekiguchi_nonaka import setup as endo
from gyrostat.papers.moreira_lopes_kuga import bench_wheel
from gyrostat.wheel import (
    Delayed,
    Driver,
    LowPass,
    PulseTachometer,
    Tachometer,
    Wheel,
    WheelArray,
    WheelTachometer,
    pyramid_axes,
)
from gyrostat.wheel.friction import LuGre, Stribeck, ViscousCoulomb

PERIOD = 0.1
KEY = jax.random.key(0)
FRICTION = Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)
WHEEL = Wheel(1.5e-3, 0.0228, FRICTION)
TABLE = spacecraft.AirBearingTable(0.495, WHEEL)
PID = control.AttitudePID(0.0571, 0.00234, 0.3126)

INERTIA = np.array([[0.12, 0.004, 0.0], [0.004, 0.10, -0.003], [0.0, -0.003, 0.06]])
AXES = pyramid_axes(4)
WHEELS = WheelArray(
    AXES,
    np.full(4, 2e-5),
    np.full(4, 3e-3),
    np.full(4, 1.5e-2),
    ViscousCoulomb(np.full(4, 2e-8), np.full(4, 2e-5)),
)
CRAFT = spacecraft.Spacecraft(INERTIA, WHEELS)
GYROSTAT = spacecraft.Gyrostat(CRAFT)
TARGET = jnp.array([0.8, 0.0, 0.6, 0.0])
SENSED = spacecraft.SpacecraftMeasurement(
    jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.full(3, 0.01), jnp.full(4, 1e-3), jnp.ones(4, bool)
)
THREE = spacecraft.Spacecraft(np.diag([8.0, 12.0, 16.0]), WheelArray(np.eye(3), 0.01, 0.1, 3.0))
MOMENTUM = jnp.array([0.6, -0.8, 0.5])
"""Total momentum for the recoveries, N·m·s."""
SENSED_THREE = spacecraft.SpacecraftMeasurement(
    jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.full(3, 0.01), jnp.full(3, 0.1), jnp.ones(3, bool)
)
TWO = spacecraft.Spacecraft(
    np.diag([400.0, 500.0, 600.0]),
    WheelArray(np.eye(3)[:, :2], 0.45, 0.1, 5.4, ViscousCoulomb(0.0, 1e-3)),
)
SENSED_TWO = spacecraft.SpacecraftMeasurement(
    jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.full(3, 1e-3), jnp.full(2, 0.2), jnp.ones(2, bool)
)
STILL = spacecraft.SinusoidalMomentum(jnp.zeros(3), 1e-3, jnp.zeros(3))


class Sample(NamedTuple):
    state: Any


class Step(NamedTuple):
    """One step of a part: a function of trees of arrays, and the shapes of its arguments."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]


def shapes(make):
    """Shapes of what a function of nothing returns, without computing it."""
    return jax.eval_shape(lambda: jax.tree.map(jnp.asarray, make()))


def plant(part, command, **start):
    """The state one control period later, whether it diverged, and the record."""

    def step(state, command, time, duration):
        after, resolved = part(state, command, time, duration)
        return after, resolved, part.diverged(after), part.record(after, command)

    return Step(step, shapes(lambda: (part.start(**start), command, 0.0, PERIOD)))


def sensor(part, state):
    return Step(part, shapes(lambda: (part.start(state(), PERIOD), state(), KEY)))


def controller(part, measurement):
    return Step(part, shapes(lambda: (part.start(PERIOD), measurement)))


def heavier(craft):
    """The spacecraft with a larger inertia, as an event makes it."""
    return eqx.tree_at(lambda c: c.spacecraft.inertia, craft, 1.1 * craft.spacecraft.inertia)


class WithField(NamedTuple):
    """Measurement with the fields of a magnetometer and a Sun sensor."""

    attitude: Any
    rate: Any
    wheel_speed: Any
    wheel_measured: Any
    magnetometer: Any
    sun_sensor: Any


IN_FIELD = WithField(*SENSED, jnp.array([1e-5, -3e-5, 2e-5]), jnp.array([0.6, 0.0, 0.8]))


class Spin(NamedTuple):
    """Sensor without memory of the sum of the wheel speeds."""

    def __call__(self, state, time, key):
        return jnp.sum(state.wheel_speed) + time


class TrueSpin(NamedTuple):
    """Sensor of the sum of the wheel speeds, without noise."""

    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, jnp.sum(state.wheel_speed)


def examples():
    """Name -> step of every part."""
    measured = spacecraft.TableMeasurement(0.01, 0.001, -3.0)
    law = control.CurrentMode(PID, 0.0228)
    torque = spacecraft.WheelTorqueCommand(jnp.full(4, 1e-4))
    truth = spacecraft.SpacecraftSensor(GYROSTAT, 1e-4, 1e-5, 1e-6)
    bench = bench_wheel.BenchWheel(WHEEL)
    reduced = reduced_gyrostat.ReducedGyrostat(THREE, jnp.array([True, True, False]), MOMENTUM)
    three = spacecraft.WheelTorqueCommand(jnp.full(3, 0.01))
    reduced_state = reduced_gyrostat.ReducedState(TARGET, jnp.full(3, 0.1))
    array = control.WheelArrayControl(
        CRAFT,
        control.AttitudeTargets(jnp.array([0.0, 10.0]), jnp.stack([TARGET, TARGET])),
        null_space=control.NullSpaceControl.plan(
            AXES, 1.5e-2, bands=[[0.0, 2e-4], [4e-3, 5e-3]], clearance=3e-4
        ),
        wear=control.WheelWear(np.full(4, 1.0), 100.0),
        unloading=control.MomentumUnloading(np.full(3, 2e-5), 0.02),
        detector=control.WheelFaultDetector(failure_torque=np.full(4, 5e-4)),
    )
    limits = (WHEELS.inertia, WHEELS.torque_limit)
    weight, effort = np.diag([50.0, 50.0, 10.0, 10.0, 10.0, 10.0]), np.eye(3)
    euler = control.StateDependentRiccati(control.EulerCube(12.0), weight, effort)
    momentum = bench_wheel.MomentumMeasurement(0.1)
    torque_filter = estimation.FrictionTorqueFilter(1e-3, 1e-3, 0.1)
    scale_filter = estimation.FrictionScaleFilter(WHEEL, 0.5, 1e-4)
    attitude_filter = estimation.AttitudeFilter(1e-4, 1e-5, 1e-7, 1e-3)
    recovery = {"total_momentum": MOMENTUM, "target": TARGET}
    orbit = spacecraft.CircularOrbit.at_altitude(5e5)
    failures = spacecraft.WheelFailures.none(4).with_failure(1, 10.0, seized=True)
    environment = (spacecraft.GravityGradient(orbit), spacecraft.HarmonicTorque(1e-3))
    steps = spacecraft.FrictionSteps(
        np.full(4, 5.0), ViscousCoulomb(np.full(4, 2e-8), np.full(4, 3e-5))
    )
    harsh = spacecraft.Gyrostat(
        CRAFT, failures=failures, environment=environment, friction_steps=steps
    )
    lugre = spacecraft.AirBearingTable(0.495, Wheel(1.5e-3, 0.0228, LuGre(FRICTION, 10.0, 0.01)))
    speeds = spacecraft.WheelSpeedCommand(jnp.full(2, 0.5))
    imbalance = spacecraft.Imbalance(
        np.full(4, 1e-6),
        np.full(4, 1e-7),
        0.1 * AXES,
        spacecraft.WheelHarmonics.single(2.0, 4, force=1e-7, torque=1e-8, axial=1e-7, phase=0.4),
        spacecraft.WheelStructure(*(np.full(4, x) for x in (900.0, 0.02, 400.0, 0.01, 1.8))),
    )
    tuner = control.SafeFrit(
        feedback=jnp.full(2, 0.1),
        reference=control.FirstOrderLags(jnp.full(2, 0.1)),
        forgetting=0.995,
        smoothing=0.1,
        dead_zone=jnp.full(2, 1e-6),
        initial_gain=jnp.full(2, 0.05),
        lowest=jnp.full(2, 0.02),
        highest=jnp.full(2, 0.2),
        largest_covariance=1e12,
    )
    pointing = control.TwoWheelPointing(TWO, tuner=tuner)
    paddled = spacecraft.PaddleGyrostat(spacecraft.Gyrostat(THREE), np.array([np.inf, np.inf, 2.0]))
    estimated = control.OutputFeedback(
        attitude_filter,
        control.WheelArrayControl(
            CRAFT, control.AttitudeTargets.hold(TARGET), allocation=control.PseudoInverse()
        ),
    )
    filtered = control.FrictionFilterFeedForward(estimated, torque_filter, AXES, *limits, 1)
    compensated = control.FrictionFeedForward(filtered, WHEELS.friction, *limits, 1.0)
    estimating = control.EstimatingFeedForward.tune(
        array, CRAFT, speed_sigma=0.1, rate_sigma=3e-5, period=PERIOD, delay=1
    )
    tracked = spacecraft.TrackerGyroMeasurement(
        SENSED.attitude, True, SENSED.rate, SENSED.wheel_speed, SENSED.wheel_measured
    )
    regulator = control.AttitudeRegulator(CRAFT, TARGET)
    one_wheel = control.OneWheelRecovery(
        inertia=THREE.inertia,
        axis=jnp.array([1.0, 0.0, 0.0]),
        allocation=jnp.array([1.0, 0.0, 0.0]),
        total_momentum=MOMENTUM,
        target=TARGET,
        gain=jnp.ones(4),
        damping=1.0,
        following=0.1,
        widest_excess=0.1,
        widest_roll=jnp.array([-1.0, 1.0]),
        torque_limit=THREE.wheels.torque_limit,
        momentum_limit=THREE.wheels.momentum_limit,
        rotor_inertia=THREE.wheels.inertia,
    )
    tuned = control.EstimatingCompensator.tune(PID, WHEEL, 0.495, 0.5, PERIOD, delay=1)

    def wanted(time):
        return jnp.where(time < 100.0, 0.5, -0.3)

    return {
        # plants
        "AirBearingTable": plant(lugre, spacecraft.TableCommand(0.01), speed=-3.0),
        "BenchWheel": plant(bench, bench_wheel.TorqueCommand(0.01)),
        "ChangingPlant": plant(
            spacecraft.ChangingPlant(GYROSTAT, (spacecraft.PlantChange("heavier", 0.03, heavier),)),
            torque,
        ),
        "DrivenGyrostat, ImbalancedGyrostat, Gyrostat": plant(
            spacecraft.DrivenGyrostat(
                spacecraft.ImbalancedGyrostat(harsh, imbalance), Driver(0.05), 5e-3
            ),
            torque,
        ),
        "ReducedGyrostat": Step(
            reduced,
            shapes(lambda: (reduced_state, three, 0.0, PERIOD)),
        ),
        "SpeedDrivenSpacecraft": plant(spacecraft.SpeedDrivenSpacecraft(TWO, STILL), speeds),
        "SpeedLoopSpacecraft, SinusoidalMomentum": plant(
            spacecraft.SpeedLoopSpacecraft(TWO, STILL), speeds
        ),
        "TorqueDrivenBody": plant(
            torque_driven.TorqueDrivenBody(12.0),
            torque_driven.BodyTorqueCommand(jnp.full(3, 0.1)),
            angles=rotations.EulerAngles(0.1, 0.5, 0.2),
            rates=rotations.EulerAngles(0.0, 0.0, 0.0),
        ),
        # sensors
        "TableSensors, Gyro": sensor(
            spacecraft.TableSensors(spacecraft.Gyro(1e-4), Tachometer(0.3)), TABLE.start
        ),
        "TrueTurn, PulseTachometer, LowPass, Delayed": sensor(
            spacecraft.TableSensors(tachometer=Delayed(LowPass(PulseTachometer(64), 1.0), 2)),
            TABLE.start,
        ),
        "MomentumSensor": sensor(bench_wheel.MomentumSensor(1.5e-3, 1e-3), bench.start),
        "TrackerGyroSensors, SpacecraftSensor, StarTracker, RateGyro": sensor(
            spacecraft.TrackerGyroSensors(
                truth, spacecraft.StarTracker(1e-4, 4), spacecraft.RateGyro(1e-5, 1e-7)
            ),
            GYROSTAT.start,
        ),
        "TrackerGyroSensors, DataSheetGyro": sensor(
            spacecraft.TrackerGyroSensors(
                truth,
                spacecraft.StarTracker(1e-4, 4),
                spacecraft.DataSheetGyro(spacecraft.RateGyro(1e-5, 1e-7), 1e-7, 10.0),
            ),
            GYROSTAT.start,
        ),
        "ReducedSensor": sensor(reduced_gyrostat.ReducedSensor(reduced), lambda: reduced_state),
        "EulerSensor": sensor(
            torque_driven.EulerSensor(), lambda: torque_driven.EulerState(*jnp.full(6, 0.1))
        ),
        "AddedSensors": sensor(
            spacecraft.AddedSensors(spacecraft.SpacecraftSensor(GYROSTAT), {"spin": TrueSpin()}),
            GYROSTAT.start,
        ),
        "PaddleAngle": sensor(spacecraft.PaddleAngle(2, 1e-3), paddled.start),
        "PaddleGyrostat": plant(paddled, spacecraft.WheelTorqueCommand(jnp.full(3, 0.01))),
        "Sampled": sensor(spacecraft.Sampled(Spin(), 4.0, 2.0), GYROSTAT.start),
        "FaultySensor, WheelTachometer": sensor(
            spacecraft.FaultySensor(
                spacecraft.SpacecraftSensor(GYROSTAT, tachometer=WheelTachometer(0.1, 64.0, 0.02)),
                tuple(
                    spacecraft.SensorFault("rate", kind, 1.0, magnitude=0.1)
                    for kind in ("dropout", "spike", "stuck")
                ),
            ),
            GYROSTAT.start,
        ),
        # controllers
        "Guarded, MeasurementGuard": controller(
            control.Guarded(
                control.CurrentMode(PID, 0.0228), control.MeasurementGuard.of(measured)
            ),
            measured,
        ),
        "CurrentMode": controller(law, measured),
        "SpeedMode": controller(control.SpeedMode(PID, 1.5e-3, 0.0228), measured),
        "DynamicModelCompensator": controller(
            control.DynamicModelCompensator(PID, FRICTION, 0.0228), measured
        ),
        "EstimatingCompensator": controller(tuned, measured),
        "FrictionTorqueControl": controller(
            control.FrictionTorqueControl(torque_filter, 0.05, wanted), momentum
        ),
        "FrictionScaleControl": controller(
            control.FrictionScaleControl(scale_filter, 0.05, wanted), momentum
        ),
        "ProportionalMomentumControl": controller(
            control.ProportionalMomentumControl(0.05, wanted), momentum
        ),
        "AttitudeRegulator": controller(regulator, SENSED),
        "AttitudeRegulator of constant gain": controller(
            dataclasses.replace(regulator, gain=jnp.ones((3, 6))), SENSED
        ),
        "LinearQuadratic": controller(
            control.LinearQuadratic(jnp.ones((3, 6))), Sample(jnp.full(6, 0.1))
        ),
        "StateDependentRiccati": controller(euler, Sample(jnp.full(6, 0.1))),
        "WheelArrayControl, NullSpaceControl, MomentumUnloading, WheelFaultDetector, "
        "WheelWear, AttitudeTargets, MinimaxAllocation": controller(array, SENSED),
        "FrictionFeedForward, FrictionFilterFeedForward, OutputFeedback, PseudoInverse": (
            controller(compensated, tracked)
        ),
        "EstimatingFeedForward": controller(estimating, SENSED),
        "MomentumRecovery of an external torque": controller(
            dataclasses.replace(
                control.MomentumRecovery.plan(THREE, [True] * 3, **recovery), torque_time=20.0
            ),
            SENSED_THREE,
        ),
        "MomentumRecovery, two wheels": controller(
            control.MomentumRecovery.plan(THREE, [True, True, False], **recovery), SENSED_THREE
        ),
        "MomentumRecovery, three wheels": controller(
            control.MomentumRecovery.plan(THREE, [True] * 3, **recovery), SENSED_THREE
        ),
        "PaddleRecovery": controller(
            control.PaddleRecovery.plan(THREE, paddle=2, angle_limit=2.0, target=TARGET),
            with_fields("Paddle", SENSED_THREE, {"paddle_angle": jnp.asarray(0.3)}, {}),
        ),
        "OneWheelRecovery": controller(one_wheel, SENSED_THREE),
        "ZeroMomentumRecovery": controller(
            control.ZeroMomentumRecovery.plan(THREE, [True, True, False], target=TARGET),
            SENSED_THREE,
        ),
        "ModelErrorCompensator, Integrators, OnlineFrit, OutputZeroing": controller(
            endo.tuned(), SENSED_TWO
        ),
        "TwoWheelPointing, BoresightLaw, SafeFrit, FirstOrderLags, RotorScaleFilter": controller(
            pointing, SENSED_TWO
        ),
        "MomentumAttitudeFilter": controller(
            control.OutputFeedback(
                estimation.MomentumAttitudeFilter(TWO, 5e-5), control.TwoWheelPointing(TWO)
            ),
            spacecraft.TrackerMeasurement(
                SENSED_TWO.attitude, True, SENSED_TWO.wheel_speed, SENSED_TWO.wheel_measured
            ),
        ),
        "WheelSpeedLoops": controller(
            control.WheelSpeedLoops(
                control.TwoWheelPointing(TWO), jnp.full(2, 0.45), jnp.full(2, 0.1)
            ),
            SENSED_TWO,
        ),
        "BCross": controller(control.BCross(CRAFT, 1e-3, 0.1), IN_FIELD),
        "SunPointing": controller(control.SunPointing(CRAFT), IN_FIELD),
        "ThrusterUnloading": controller(
            control.ThrusterUnloading(
                regulator, WHEELS, 0.1, 0.02, begin=1e-3, end=5e-4, impulse=1e-4
            ),
            IN_FIELD,
        ),
        "RodUnloading": controller(control.RodUnloading(regulator, WHEELS, 0.1), IN_FIELD),
        # what controllers are made with
        "rotations.from_matrix": Step(rotations.from_matrix, (jnp.eye(3),)),
        "rotations.to_euler": Step(rotations.to_euler, (TARGET,)),
    }
