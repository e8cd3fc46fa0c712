"""Added actuators, sensors and plant changes against momentum balances and runs in pieces."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
import pytest

from gyrostat.codegen.simd import compiler
from gyrostat.control import FieldLimits, Guarded, MeasurementGuard, OutputFeedback, SampleStatus
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import to_body
from gyrostat.estimation import AttitudeFilter
from gyrostat.simulation import simulate
from gyrostat.spacecraft import (
    AddedSensors,
    ChangingPlant,
    DrivenGyrostat,
    FaultySensor,
    Gyrostat,
    Imbalance,
    ImbalancedGyrostat,
    PlantChange,
    RateGyro,
    SensorFault,
    Spacecraft,
    SpacecraftSensor,
    StarTracker,
    TrackerGyroSensors,
)
from gyrostat.wheel import Driver, WheelArray, orthogonal_axes
from gyrostat.wheel.friction import ViscousCoulomb

PERIOD, COUNT = 0.25, 8
WHEELS = WheelArray(
    orthogonal_axes(),
    np.full(3, 2e-5),
    np.full(3, 1e-2),
    np.full(3, 0.1),
    ViscousCoulomb(np.full(3, 1e-6), np.full(3, 1e-5)),
)
CRAFT = Spacecraft(np.diag([0.02, 0.03, 0.04]), WHEELS)
IMBALANCE = Imbalance(np.full(3, 1e-6), np.full(3, 1e-8), 0.05 * np.eye(3))
MOTION = {"attitude": (0.6, 0.0, 0.8, 0.0), "rate": (0.02, -0.01, 0.03), "wheel_speed": 40.0}
NATIVE = pytest.mark.skipif(compiler() is None, reason="needs a C compiler")


class Command(NamedTuple):
    torque: Any
    thrust: Any
    note: Any


class Schedule(eqx.Module):
    """Open-loop commands that grow from sample to sample."""

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, memory, measurement):
        torque = 1e-4 * jnp.array([1.0, -1.0, 0.5])
        return memory + 1.0, Command(torque, 1e-5 * (1.0 + memory), memory)


class Thrust(eqx.Module):
    """Torque along an inertial direction."""

    along: Any

    def __call__(self, value, attitude, time):
        return to_body(attitude, value * self.along)


class Temperature(eqx.Module):
    """A noisy number with a memory."""

    plant: Any
    sigma: float = 0.5
    unit: str = eqx.field(static=True, default="K")

    def start(self, state, period):
        return jnp.zeros(())

    def __call__(self, memory, state, key):
        level = 300.0 + 10.0 * self.plant.rate(state)[0]
        return memory + 1.0, level + memory + self.sigma * jax.random.normal(key)


started = eqx.filter_jit(lambda plant: plant.start(**MOTION))


def fly(plant, sensor=None, controller=None, start=None, **options):
    options = {"duration": PERIOD * COUNT, "control_period": PERIOD, **options}
    start = started(plant) if start is None else start
    return simulate(
        plant, controller or Schedule(), sensor or SpacecraftSensor(plant), start=start, **options
    )


ALONG = np.array([0.1, -0.2, 0.3])


@pytest.mark.parametrize(("delay", "engine"), [(0, "jax"), pytest.param(2, "native", marks=NATIVE)])
def test_the_impulse_of_an_added_actuator_is_the_change_of_total_momentum(
    delay, engine, frictionless
):
    plant = Gyrostat(CRAFT, actuators={"thrust": Thrust(ALONG)})
    sensor = SpacecraftSensor(plant)
    if engine == "jax":  # in this engine, the next test has the friction
        plant = frictionless(plant)
    found = fly(plant, sensor, command_delay=delay, engine=engine)
    given = 1e-5 * np.concatenate([np.zeros(delay), 1.0 + np.arange(COUNT)])[:COUNT]
    impulse = np.concatenate([[0.0], np.cumsum(given) * PERIOD])
    gained = found.momentum.values - found.momentum.values[0]
    np.testing.assert_allclose(gained, impulse[:, None] * ALONG, rtol=0, atol=1e-12)
    # the delay line finds by itself which fields drive actuators
    np.testing.assert_array_equal(found.thrust.values[:COUNT], given)
    np.testing.assert_array_equal(found.note, np.arange(COUNT + 1.0))


def heavier(plant):
    return eqx.tree_at(lambda p: p.spacecraft.inertia, plant, 1.5 * plant.spacecraft.inertia)


def rougher(plant):
    wheels = plant.spacecraft.wheels
    plant = eqx.tree_at(lambda p: p.spacecraft.wheels.inertia, plant, 1.1 * wheels.inertia)
    return eqx.tree_at(
        lambda p: p.spacecraft.wheels.friction.coulomb, plant, 3.0 * wheels.friction.coulomb
    )


PLAIN = Gyrostat(CRAFT, external_torque=np.array([1e-5, 0.0, -2e-5]))


def driven(external_torque):
    """Unbalanced wheels with a current loop, and two actuators."""
    actuators = {"thrust": Thrust(ALONG), "note": Thrust(-1e-6 * ALONG)}
    plain = Gyrostat(CRAFT, external_torque=external_torque, actuators=actuators)
    return DrivenGyrostat(ImbalancedGyrostat(plain, IMBALANCE), Driver(time_constant=0.1), 0.02)


PLANTS = {"plain": PLAIN, "driven": driven(PLAIN.external_torque)}


_stepped = eqx.filter_jit(lambda *given: given[0](*given[1:])[0])


def step(*given):
    # arrays, so that it is compiled once
    return _stepped(*jax.tree.map(lambda leaf: np.asarray(leaf, float), given))


rate_of = eqx.filter_jit(lambda plant, state: plant.rate(state))


def changed(plant, times):
    changes = PlantChange("boom", times[0], heavier), PlantChange("worn", times[1], rougher)
    return ChangingPlant(plant, changes)


@pytest.mark.parametrize(
    ("kind", "engine"),
    [("plain", "jax"), pytest.param("driven", "native", marks=NATIVE)],
)
def test_a_change_inside_a_period_equals_two_runs_pieced_together(kind, engine):
    plant, times = PLANTS[kind], (0.37, 1.1)
    changing = changed(plant, times)
    found = fly(changing, engine=engine)
    state, now, phase = started(plant), 0.0, 0
    plants = [plant, heavier(plant), rougher(heavier(plant))]
    for k in range(COUNT):
        _, command = Schedule()(float(k), None)
        for own, name in zip(state, type(state)._fields, strict=True):
            if own is not None:
                np.testing.assert_allclose(found[name].values[k], own, rtol=1e-11, atol=1e-12)
        rate = found.measured_rate.values[k] - rate_of(plants[phase], state)
        np.testing.assert_allclose(rate, 0.0, atol=2e-11)
        end = (k + 1) * PERIOD
        while phase < 2 and times[phase] < end:
            state = step(plants[phase], state, command, now, times[phase] - now)
            now, phase = times[phase], phase + 1
        state = step(plants[phase], state, command, now, end - now)
        now = end
    np.testing.assert_allclose(found.elapsed, PERIOD * np.arange(COUNT + 1), atol=1e-12)
    assert found.elapsed.attrs["units"] == "s"


def test_without_external_torque_a_change_conserves_momentum_to_the_last_bit():
    found = fly(changed(Gyrostat(CRAFT), (0.6, 1.1)), engine="auto")
    momentum = found.momentum.values
    np.testing.assert_array_equal(momentum, np.broadcast_to(momentum[0], momentum.shape))
    before, after = (np.linalg.norm(found.measured_rate.values[k]) for k in (2, 3))
    assert after < 0.8 * before  # the heavier body turns more slowly
    np.testing.assert_array_equal(found.measured_rate, found.rate)


def test_two_actuators_on_any_plant_add_and_leave_the_wheels_alone():
    # the structure of the changes above, which here come too late: the same compiled program
    plant = changed(driven(np.zeros(3)), (1e3, 2e3))
    found = fly(plant, engine="auto")
    given = (1e-5 * (1.0 + np.arange(COUNT)) - 1e-6 * np.arange(COUNT)) * PERIOD
    gained = found.momentum.values[-1] - found.momentum.values[0]
    np.testing.assert_allclose(gained, np.sum(given) * ALONG, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda plant: None, "event boom: found a result of type NoneType, expected the Gyrostat"),
        (
            lambda plant: eqx.tree_at(lambda p: p.external_torque, plant, jnp.zeros(2)),
            r"event boom: found plant.external_torque of shape \(2,\), expected \(3,\)",
        ),
        (lambda plant: Gyrostat(plant.spacecraft, environment=(Thrust(1.0),)), "another structure"),
        (
            lambda plant: eqx.tree_at(
                lambda p: p.spacecraft.inertia, plant, -plant.spacecraft.inertia
            ),
            "body inertia",
        ),
    ],
)
def test_changes_that_are_none_are_refused(change, message):
    plant = ChangingPlant(PLAIN, (PlantChange("boom", 0.6, change),))
    with pytest.raises(InputError, match=message):
        plant.check()


def test_a_state_of_the_unchanged_plant_is_refused():
    plant = ChangingPlant(PLAIN, (PlantChange("boom", 0.6, heavier),))
    with pytest.raises(InputError, match="elapsed: found none"):
        fly(plant, start=PLAIN.start(**MOTION))


NOISY = SpacecraftSensor(PLAIN, 1e-4, 1e-4)
WARM = AddedSensors(NOISY, {"warmth": Temperature(PLAIN)})


def test_an_added_sensor_leaves_all_other_noise_unchanged(frictionless):
    both = AddedSensors(NOISY, {"warmth": Temperature(PLAIN), "status": Temperature(PLAIN, 0.1)})
    plant = frictionless(PLAIN)
    alone, two = (fly(plant, sensor, seed=3, runs=2, engine="auto") for sensor in (NOISY, both))
    for name in alone.variables:
        np.testing.assert_array_equal(two[name], alone[name])
    assert two.warmth.dims == ("run", "time")
    assert two.warmth.attrs["units"] == "K"
    noise = two.warmth.values - 300.0 - np.arange(COUNT + 1) - 10.0 * two.rate.values[..., 0]
    other = (
        two.measured_status.values - 300.0 - np.arange(COUNT + 1) - 10.0 * two.rate.values[..., 0]
    )
    assert np.unique(noise).size == noise.size
    assert 0.2 < np.std(noise) < 1.0
    assert np.min(np.abs(5.0 * other - noise)) > 1e-6  # draws of its own


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("rate", "sensor rate: found the name of another sensor, expected a name other than att"),
        ("wheel_heat", "sensor wheel_heat: found a name that begins with wheel_"),
    ],
)
def test_a_name_of_another_sensor_is_refused(name, message):
    with pytest.raises(InputError, match=message):
        fly(PLAIN, AddedSensors(NOISY, {name: Temperature(PLAIN)}))


class Quiet(eqx.Module):
    """Commands what is measured, to be seen in the histories."""

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        torque = jnp.full(3, 1e-5)
        return memory, Command(torque, jnp.asarray(1e-3), measurement.warmth)


def test_faults_and_limits_apply_to_added_fields(frictionless):
    faults = (
        SensorFault("warmth", "spike", 0.5, 0.75, 1e3),
        SensorFault("warmth", "dropout", 1.0, 1.25),
    )
    sensor = FaultySensor(WARM, faults)
    memory = sensor.start(PLAIN.start(**MOTION), PERIOD)
    shapes = jax.eval_shape(sensor, memory, PLAIN.start(**MOTION), jax.random.key(0))[1]
    guard = MeasurementGuard.of(shapes, {"warmth": FieldLimits(200.0, 400.0)}, "zero")
    plant = frictionless(Gyrostat(CRAFT, actuators={"thrust": Thrust(ALONG)}))
    found = fly(plant, sensor, Guarded(Quiet(), guard, ("thrust",)))
    expected = np.zeros(COUNT + 1)
    expected[[2, 4]] = SampleStatus.OUT_OF_RANGE, SampleStatus.NOT_FINITE
    np.testing.assert_array_equal(found.sample_status, expected)
    # the safe command is zero for every actuator; other fields keep their last value
    np.testing.assert_array_equal(found.thrust, np.where(expected > 0, 0.0, 1e-3))
    np.testing.assert_array_equal(found.note.values[[2, 4]], found.warmth.values[[1, 3]])


def test_added_fields_pass_an_attitude_filter(frictionless):
    inner = TrackerGyroSensors(SpacecraftSensor(PLAIN), StarTracker(1e-4), RateGyro(1e-5))
    controller = OutputFeedback(AttitudeFilter(1e-4, 1e-5, 1e-7, 1e-3), Quiet())
    sensor = AddedSensors(inner, {"warmth": Temperature(PLAIN)})
    found = fly(frictionless(PLAIN), sensor, controller, engine="auto")
    np.testing.assert_array_equal(found.note, found.warmth)


class Flat(eqx.Module):
    def __call__(self, spacecraft, attitude, time):
        return jnp.zeros(2)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Gyrostat(CRAFT, environment=Flat()), r"found Flat, expected a tuple of torque"),
        (lambda: Gyrostat(CRAFT, environment=(Flat,)), r"found the class Flat, expected torque"),
        (lambda: Gyrostat(CRAFT, environment=(1.0,)), r"found 1.0, expected torque models"),
        (
            lambda: fly(Gyrostat(CRAFT, environment=(Flat(),))),
            r"environment torque Flat: found a torque of shape \(2,\), expected \(3,\)",
        ),
        (
            lambda: fly(Gyrostat(CRAFT, actuators={"thrust": lambda *_: jnp.zeros(2)})),
            r"actuator thrust: found a torque of shape",
        ),
        (
            lambda: fly(Gyrostat(CRAFT, actuators={"rods": Thrust(ALONG)})),
            r"actuator rods: found a command \(Command\) of torque, thrust, note, expected the fie",
        ),
    ],
)
def test_torques_and_actuators_that_cannot_work_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
