"""Rounded signals: the step is found, and a rounded current has errors that do not average out."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.identification import averaged, identify
from gyrostat.identification.read.quantisation import held_levels, repetitions, rounding_step
from gyrostat.telemetry import Record

INERTIA = 1.5e-3
NAMES = ("motor_constant", "viscous", "coulomb", "static")


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_the_step_of_a_rounded_signal_is_found_from_few_values(kind):
    random = np.random.default_rng(0)
    for _ in range(50):
        levels = np.repeat(random.uniform(-0.15, 0.15, 8), 20)
        rounded = (1e-3 * np.round(levels / 1e-3)).astype(kind).astype(float)
        step = rounding_step(rounded)
        # eight values may share a multiple of the step
        assert step is not None
        assert round(step / 1e-3) == pytest.approx(step / 1e-3, abs=1e-3)
        assert step < 4.5e-3


def test_a_signal_that_is_not_rounded_or_has_few_round_values_has_no_step():
    random = np.random.default_rng(1)
    assert all(rounding_step(random.uniform(-0.15, 0.15, 8)) is None for _ in range(500))
    assert rounding_step(np.array([0.06, -0.15, 0.06, 0.15, -0.06])) is None
    assert rounding_step(np.full(100, 0.123)) is None


def bench(current, speed):
    time = np.arange(len(current), dtype=float)
    return Record("bench", time, np.array(current), np.array(speed), time >= 0.0)


def test_a_held_current_has_one_error_and_a_passing_one_has_independent_errors():
    current = 1e-3 * np.array([*[20] * 5, *[30] * 6, 31, 32, *[33] * 5, 34, *[20] * 5, 20])
    numbers, common, count = held_levels([bench(current, 0.0 * current)], 1e-3)
    assert count == 2
    # the current passes 33 mA, and holds 20 mA twice with the same error
    expected = np.array([*[0] * 5, *[1] * 6, -1, -1, *[-1] * 5, -1, *[0] * 5])
    np.testing.assert_array_equal(numbers[0], expected)
    np.testing.assert_array_equal(common[0], np.where(expected < 0, 1.0, 0.0))


def test_a_speed_that_stays_at_one_value_counts_as_one_sample():
    speed = [0.0, 0.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 2.0, 1.0]
    size = repetitions(bench(np.zeros(10), speed), 1.0)
    np.testing.assert_array_equal(size, [2, 2, 1, 1, 1, 3, 3, 3, 1, 1])


def worst(fit, truth, values, sigma):
    """Largest error of the wheel, in standard deviations."""
    places = {name: fit.names.index(name) for name in NAMES}
    return max(abs(values[k] - truth[name]) / sigma[k] for name, k in places.items())


def test_the_error_of_a_rounded_current_is_in_sigma(record, changed, truth):
    """Steps of 60 to 150 mA, recorded to 1 mA and 0.4 rpm as drives send them."""
    steps, quantum = record("stribeck", seed=13, sigma_rpm=0.3), 0.4 * RPM
    coarse = changed(
        steps,
        current=1e-3 * np.round(steps.current / 1e-3),
        speed=quantum * np.round(steps.speed / quantum),
    )
    wheel = {"motor_constant": 0.0228, **truth["stribeck"]}
    plain = identify(coarse, inertia=INERTIA, white_noise=True)
    assert worst(plain, wheel, plain.values, plain.sigma) > 5.0
    fit = identify(coarse, inertia=INERTIA)
    assert worst(fit, wheel, fit.values, fit.sigma) < 3.0
    assert fit.impossible == ()
    rounding = next(effect for effect in fit.effects if effect.name == "current_rounding")
    assert rounding.probability > 0.999
    # the true errors are known: the largest that was found is one of them
    errors = np.unique(steps.current - coarse.current)
    assert np.min(np.abs(errors - rounding.value)) < 4.0 * rounding.sigma
    stated = identify(coarse, inertia=INERTIA, current_quantum=1e-3)
    np.testing.assert_allclose(stated.values, fit.values, atol=0.05 * fit.sigma.min(), rtol=1e-4)
    ignored = identify(coarse, inertia=INERTIA, current_quantum=0.0)
    assert not any(effect.name == "current_rounding" for effect in ignored.effects)


def test_a_long_rest_without_noise_does_not_make_the_other_samples_more_accurate(
    record, changed, truth
):
    """A pulse counter shows exactly zero for 20 minutes: that is one sample, not 6000."""
    steps, quantum, count = record("stribeck", seed=14, sigma_rpm=2.5, rate=5.0), 5.0 * RPM, 6000
    rest = np.zeros(count)
    counted = changed(
        steps,
        time=np.arange(count + len(steps.time)) / 5.0,
        current=np.append(rest, steps.current),
        speed=np.append(rest, quantum * np.round(steps.speed / quantum)),
        valid=np.append(rest == 0.0, steps.valid),
    )
    fit = identify(counted, inertia=INERTIA)
    wheel = {"motor_constant": 0.0228, **truth["stribeck"]}
    assert fit.impossible == ()
    assert worst(fit, wheel, fit.values, fit.sigma) < 3.0
    assert not any(effect.likely for effect in fit.effects if effect.name == "torque_walk")


@pytest.mark.parametrize("claim", [0.1, 0.5])
def test_a_correction_that_explains_the_record_worse_is_refused(record, monkeypatch, claim):
    """The averages claim a constant torque, fraction of the rms current, that is not there."""
    average = averaged.average

    def astray(*arguments, **options):
        mixture = average(*arguments, **options)
        effects = [replace(e, probability=1.0) for e in mixture.effects]
        wrong = np.zeros_like(mixture.coefficients)
        wrong[0] = claim
        return replace(mixture, coefficients=wrong, effects=tuple(effects))

    monkeypatch.setattr("gyrostat.identification.averaged.average", astray)
    fit = identify(record("stribeck", seed=12, sigma_rpm=1.0, duration=220.0), inertia=INERTIA)
    assert any("does not follow the record" in reason for reason in fit.impossible)


def test_a_step_is_not_negative(record):
    with pytest.raises(InputError, match="current_quantum: found -"):
        identify(record(), inertia=INERTIA, current_quantum=-1e-3)


@pytest.mark.parametrize("first", [0, 5])
def test_a_slow_record_is_cut_where_its_current_steps_between_samples(
    record, changed, truth, first
):
    """Every tenth sample: steps at samples, or half a second before one."""
    steps = record("stribeck", seed=12, sigma_rpm=1.0)
    names = ("time", "current", "speed", "valid")
    slow = changed(steps, **{name: getattr(steps, name)[first::10] for name in names})
    fit = identify(slow, inertia=INERTIA)
    wheel = {"motor_constant": 0.0228, **truth["stribeck"]}
    assert fit.converged
    assert fit.impossible == ()
    assert worst(fit, wheel, fit.values, fit.sigma) < 3.5
    cuts = [warning for warning in fit.warnings if "steps between the samples" in warning]
    assert len(cuts) == (first > 0)
    assert len(fit.records[0].segments) == (10 if first else 1)
