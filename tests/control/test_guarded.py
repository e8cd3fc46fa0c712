"""A controller behind the validation of its measurements."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrostat.control import (
    EstimatingCompensator,
    FieldLimits,
    Guarded,
    MeasurementGuard,
    SampleStatus,
)
from gyrostat.control.guarded import finite
from gyrostat.control.measurement_guard import REACQUIRE
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import FaultySensor, SensorFault, TableMeasurement

PERIOD = 0.1
GOOD = TableMeasurement(0.01, 0.002, 3.0)
LIMITS = {"rate": FieldLimits(-1.0, 1.0, 0.05), "speed": FieldLimits(-600.0, 600.0)}


@pytest.fixture(scope="module")
def fly(g2):
    """Samples, and the safe command -> commands and the last memory."""
    tuned = EstimatingCompensator.tune(g2.law, g2.wheel, 0.495, 0.5, PERIOD, delay=1)
    known = {}

    def call(samples, on_bad="hold"):
        controller = Guarded(tuned, MeasurementGuard.of(GOOD, LIMITS, on_bad))
        step = known.setdefault(on_bad, jax.jit(lambda m, z: controller(m, z)))
        memory, commands = controller.start(PERIOD), []
        for sample in samples:
            memory, command = step(memory, jax.tree.map(jnp.asarray, sample))
            commands.append(jax.tree.map(np.asarray, command))
        return commands, memory

    return call


def status(commands):
    return [SampleStatus(int(command.sample_status)) for command in commands]


NONE = GOOD._replace(rate=np.nan)


@pytest.mark.parametrize("on_bad", ["hold", "zero"])
@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (GOOD._replace(attitude=np.nan), SampleStatus.NOT_FINITE),
        (GOOD._replace(rate=-np.inf), SampleStatus.NOT_FINITE),
        (GOOD._replace(speed=600.1), SampleStatus.OUT_OF_RANGE),
        (GOOD._replace(rate=0.02), SampleStatus.TOO_FAST),
        (GOOD._replace(attitude=1e300, speed=1e300), SampleStatus.OUT_OF_RANGE),
    ],
)
def test_a_bad_sample_is_as_one_that_never_came(bad, reason, on_bad, fly):
    first, last = [GOOD] * 3, [GOOD] * 2
    commands, memory = fly([*first, bad, bad, *last], on_bad)
    missing, expected = fly([*first, NONE, NONE, *last], on_bad)
    good = SampleStatus.GOOD
    assert status(commands) == [good] * 3 + [reason] * 2 + [good] * 2
    assert [int(c.samples_missed) for c in commands] == [0, 0, 0, 1, 2, 0, 0]
    held = 0.0 if on_bad == "zero" else commands[2].current
    assert commands[3].current == commands[4].current == held
    for ours, theirs in zip(commands, missing, strict=True):
        assert ours[:-2] == theirs[:-2]
    for ours, theirs in zip(jax.tree.leaves(memory), jax.tree.leaves(expected), strict=True):
        np.testing.assert_array_equal(ours, theirs)
        assert np.all(np.isfinite(ours))


def test_a_missing_sample_is_a_prediction_without_correction(fly):
    _, before = fly([GOOD] * 3)
    _, after = fly([GOOD] * 3 + [NONE])
    old, new = before.controller, after.controller
    walked = old.momentum.momentum + PERIOD * old.momentum.torque
    np.testing.assert_allclose(new.momentum.momentum, walked, rtol=1e-15)
    acting = old.under_way[0] + old.rate.torque
    np.testing.assert_allclose(new.rate.rate, old.rate.rate + PERIOD * acting / 0.495, rtol=1e-14)
    assert new.momentum.momentum_variance > old.momentum.momentum_variance
    assert new.law == old.law


def test_a_real_jump_is_accepted_after_a_bounded_number_of_samples(fly):
    jumped = GOOD._replace(rate=0.9)
    commands, _ = fly([GOOD] * 3 + [jumped] * (REACQUIRE + 2))
    late = [SampleStatus.TOO_FAST] * REACQUIRE + [SampleStatus.GOOD] * 2
    assert status(commands)[3:] == late


def test_a_limit_of_the_rate_grows_while_samples_are_missing(fly):
    after = GOOD._replace(rate=0.002 + 0.05 * PERIOD * 2.5)
    commands, _ = fly([GOOD, after])
    assert status(commands)[-1] == SampleStatus.TOO_FAST
    commands, _ = fly([GOOD, NONE, NONE, after])
    assert status(commands)[-1] == SampleStatus.GOOD


class Command(NamedTuple):
    """Of the reciprocal law."""

    torque: float


class Reciprocal:
    """u = 1 / x and its sum: not finite at zero."""

    def start(self, period):
        return jnp.array(0.0)

    def __call__(self, memory, measurement):
        return memory + 1.0 / measurement.rate, Command(1.0 / measurement.rate)


def test_a_command_that_is_not_finite_does_not_leave():
    controller = Guarded(Reciprocal(), MeasurementGuard.of(GOOD))
    memory = controller.start(PERIOD)
    memory, first = controller(memory, GOOD._replace(rate=2.0))
    after, second = controller(memory, GOOD._replace(rate=0.0))
    assert (first.torque, second.torque) == (0.5, 0.5)
    assert int(second.sample_status) == SampleStatus.NOT_COMPUTED
    assert float(after.controller) == float(memory.controller)
    after, third = controller(after, GOOD._replace(rate=4.0))
    assert (float(third.torque), float(after.controller)) == (0.25, 0.75)


class Unset(Reciprocal):
    """Its memory is infinite at the start, for "nothing measured yet"."""

    def start(self, period):
        return jnp.array(jnp.inf)


def test_a_memory_that_the_guard_would_never_keep_is_refused():
    with pytest.raises(InputError, match="Unset: found a memory that is not finite at the start"):
        Guarded(Unset(), MeasurementGuard.of(GOOD)).check_period(PERIOD)


class Flagged(NamedTuple):
    """A measurement whose wheels have flags."""

    rate: float
    wheel_speed: np.ndarray
    wheel_measured: np.ndarray


class Sum:
    """The sum of the measured speeds."""

    def start(self, period):
        return jnp.array(0.0)

    def __call__(self, memory, seen):
        return memory, Command(jnp.sum(jnp.where(seen.wheel_measured, seen.wheel_speed, 0.0)))


def test_a_sensor_with_a_flag_loses_its_own_value_alone():
    seen = Flagged(0.0, np.array([1.0, 2.0, 4.0]), np.array([True, True, True]))
    guard = MeasurementGuard.of(seen, {"wheel_speed": FieldLimits(-10.0, 10.0, 5.0)})
    guarded = Guarded(Sum(), guard)
    controller = jax.jit(lambda memory, seen: guarded(memory, seen))
    # no weak types, so that it is compiled once
    memory, _ = controller(jax.tree.map(np.asarray, guarded.start(PERIOD)), seen)
    broken = seen._replace(wheel_speed=np.array([1.0, np.nan, 11.0]))
    memory, command = controller(memory, broken)
    assert int(command.sample_status) == SampleStatus.PARTIAL
    assert float(command.torque) == 1.0
    np.testing.assert_array_equal(memory.guard.last.wheel_speed, [1.0, 2.0, 4.0])
    np.testing.assert_array_equal(memory.guard.fields_missed["wheel_speed"], [0, 1, 1])
    memory, command = controller(memory, seen)
    assert (int(command.sample_status), float(command.torque)) == (SampleStatus.GOOD, 7.0)
    _, command = controller(memory, broken._replace(rate=np.nan))
    assert int(command.sample_status) == SampleStatus.NOT_FINITE


def test_the_count_of_missed_samples_does_not_overflow():
    seen = Flagged(0.0, np.array([1.0, 2.0, 4.0]), np.array([True, True, True]))
    guard = MeasurementGuard.of(seen, {"wheel_speed": FieldLimits(-10.0, 10.0, 5.0)})
    begun = jax.tree.map(jnp.asarray, guard.start())
    most = jnp.iinfo(begun.samples_missed.dtype).max
    full = jax.tree.map(lambda count: jnp.full_like(count, most), begun.fields_missed)
    begun = begun._replace(samples_missed=jnp.full_like(begun.samples_missed, most))
    after = guard(begun._replace(fields_missed=full), seen._replace(rate=np.nan), PERIOD).missed
    assert int(after.samples_missed) == most
    broken = seen._replace(wheel_speed=np.full(3, np.nan))
    after = guard(begun._replace(fields_missed=full), broken, PERIOD)
    counts = {**after.used.fields_missed, **after.missed.fields_missed}
    assert all(np.all(np.asarray(count) >= 0) for count in counts.values())


@pytest.mark.parametrize(
    ("limits", "on_bad", "told"),
    [
        ({"rates": FieldLimits()}, "hold", "rates"),
        ({"rate": FieldLimits(1.0, -1.0)}, "hold", "lower one first"),
        ({"rate": FieldLimits(np.nan, 1.0)}, "hold", "lower one first"),
        ({"rate": FieldLimits(rate=0.0)}, "hold", "above 0"),
        ({"rate": FieldLimits(rate=-1.0)}, "hold", "above 0"),
        ({"rate": FieldLimits(rate=np.nan)}, "hold", "above 0"),
        ({}, "stop", "hold or zero"),
    ],
)
def test_limits_that_make_no_sense_are_refused(limits, on_bad, told):
    with pytest.raises(InputError, match=told):
        Guarded(Sum(), MeasurementGuard.of(GOOD, limits, on_bad)).check()


def test_sensible_limits_are_allowed():
    limits = {"rate": FieldLimits(-1.0, 1.0, 0.05), "speed": FieldLimits(rate=np.inf)}
    Guarded(Sum(), MeasurementGuard.of(GOOD, limits)).check()


@given(leaves=st.lists(st.sampled_from([0.0, -3.5, 1e100, np.nan, np.inf]), max_size=9))
def test_a_number_that_is_not_finite_is_found_wherever_it_is(leaves):
    tree = {str(k): np.array([1.0, leaf]) for k, leaf in enumerate(leaves)} | {"flag": True}
    assert bool(finite(tree)) == bool(np.all(np.isfinite(leaves)))
    # what is known to be finite is not tested
    assert bool(finite(tree, dict(list(tree.items())[:1]))) == bool(np.all(np.isfinite(leaves[1:])))


class Truth:
    """Measures the state itself."""

    def start(self, state, period):
        return jnp.array(0.0)

    def __call__(self, memory, state, key):
        return memory, Flagged(state, state * np.ones(3), np.ones(3, bool))


def measured(fault, count=8):
    sensor = FaultySensor(Truth(), (fault,))
    sensor.check()
    memory, found = sensor.start(jnp.array(0.0), 0.5), []
    for k in range(count):
        memory, seen = sensor(memory, jnp.array(float(k)), jax.random.key(k))
        found.append(np.asarray(getattr(seen, fault.field)))
    return np.array(found)


def test_faults_of_sensors_hit_their_samples_alone():
    truth = np.arange(8.0)
    lost = measured(SensorFault("rate", "dropout", 1.0, 2.0))
    np.testing.assert_array_equal(lost, np.where((truth >= 2) & (truth < 4), np.nan, truth))
    stuck = measured(SensorFault("rate", "stuck", 1.0, 2.5))
    np.testing.assert_array_equal(stuck, [0, 1, 1, 1, 1, 5, 6, 7])
    hit = measured(SensorFault("wheel_speed", "spike", 1.0, magnitude=9.0, element=1))
    np.testing.assert_array_equal(hit[:, 0], truth)
    np.testing.assert_array_equal(hit[:, 1], truth + 9.0 * (truth >= 2))
    drifted = measured(SensorFault("rate", "drift", 1.0, 3.0, slope=0.2))
    expected = truth + 0.2 * np.array([0, 0, 0.0, 0.5, 1.0, 1.5, 0, 0])
    np.testing.assert_allclose(drifted, expected, rtol=1e-15)
    scaled = measured(SensorFault("wheel_speed", "scale", 1.0, 2.0, factor=-1.5, element=2))
    np.testing.assert_array_equal(scaled[:, 1], truth)
    np.testing.assert_array_equal(scaled[:, 2], [0, 1, -3.0, -4.5, 4, 5, 6, 7])
    some = np.isnan(measured(SensorFault("rate", "dropout", 0.0, share=0.5), 40))
    assert 8 <= some.sum() <= 32


@pytest.mark.parametrize(
    "fault",
    [
        SensorFault("rate", "loss", 0.0),
        SensorFault("rate", "stuck", 2.0, 1.0),
        SensorFault("rate", "dropout", 0.0, share=1.1),
        SensorFault("rate", "spike", 0.0, magnitude=np.inf),
        SensorFault("rate", "drift", 0.0, slope=np.nan),
        SensorFault("rate", "scale", 0.0, factor=np.inf),
    ],
)
def test_faults_that_cannot_happen_are_refused(fault):
    with pytest.raises(InputError):
        fault.check()
