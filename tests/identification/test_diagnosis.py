"""Diagnosis: its parts against dense algebra, and each cause found in a record that has it."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.fit.prediction import Linearisation
from gyrostat.identification.judge.faults import implausible, wrong_units
from gyrostat.identification.read.clipping import clipped_current, without_clipped
from gyrostat.identification.read.signs import lost_sign, signed_current, signed_speed
from gyrostat.identification.read.statistics import chi_square_tail
from gyrostat.identification.uncertainty.diagnosis import diagnose
from gyrostat.identification.uncertainty.effects import Nuisance, _lag
from gyrostat.identification.uncertainty.hypotheses import Segment, grid, whitened
from gyrostat.identification.uncertainty.torque_noise import TorqueNoise
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3


@pytest.mark.parametrize("freedom", [1, 2, 3, 7])
def test_tail_probabilities_are_those_of_the_chi_square(freedom):
    from scipy.stats import chi2

    for deviance in (0.5, 5.0, 20.0):
        exact = chi2.sf(deviance, freedom)
        assert chi_square_tail(deviance, freedom) == pytest.approx(exact, rel=1e-10)


def problem(size, seed=0, count=300):
    """A record with an effect of so many sigmas, one that equals it, and one that is absent."""
    random = np.random.default_rng(seed)
    rows = random.standard_normal((count, 2))
    own = random.standard_normal((count, 1))
    other = random.standard_normal((count, 1))
    effects = [
        Nuisance("absent", "absent", "1", (), (other,)),
        Nuisance("present", "present", "A", (), (own,)),
        Nuisance("twin", "twin", "1", (), (-2.0 * own + rows[:, :1],)),
    ]
    free = own - rows @ np.linalg.lstsq(rows, own, rcond=None)[0]
    residual = random.standard_normal(count) + size / np.linalg.norm(free) * own[:, 0]
    linear = Linearisation(np.zeros(count), rows, np.zeros(count - 1), np.zeros((count - 1, 2)))
    still = np.zeros(count - 1)
    noise = TorqueNoise(still, still, still, 0.0, still, still, 0.0, still)
    segment = Segment(residual, rows, linear, noise, 1.0, np.ones(count))
    levels = grid((0.1,))
    scale = np.ones(2)
    found = whitened([segment], effects, scale, levels)
    prior = (1e-12 * np.eye(2), np.zeros(2))
    findings, scores = diagnose(found, levels, effects, prior, ("a", "b"), scale, stated=True)
    return findings, scores, segment, effects


def test_an_effect_is_found_with_its_twin_and_moves_the_parameters_as_dense_algebra_says():
    findings, _, segment, effects = problem(8.0)
    assert len(findings) == 1
    assert set(findings[0].names) == {"present", "twin"}
    columns = np.column_stack([segment.rows, effects[1].columns[0]])
    dense = np.linalg.lstsq(columns, segment.residual, rcond=None)[0]
    plain = np.linalg.lstsq(segment.rows, segment.residual, rcond=None)[0]
    fall = np.sum((segment.residual - segment.rows @ plain) ** 2)
    fall -= np.sum((segment.residual - columns @ dense) ** 2)
    assert findings[0].significance == pytest.approx(np.sqrt(fall), rel=1e-6)
    assert findings[0].evidence == pytest.approx(fall - np.log(300), rel=1e-6)
    if findings[0].names[0] == "present":
        assert findings[0].value == pytest.approx(dense[2], rel=1e-6)
        moved = list(findings[0].shifts.values())
        np.testing.assert_allclose(moved, dense[:2] - plain, rtol=1e-6)


def test_scores_are_those_of_linear_regression():
    findings, scores, segment, effects = problem(0.0, seed=2)
    assert findings == ()
    for score, effect in zip(scores, effects, strict=True):
        columns = np.column_stack([segment.rows, effect.columns[0]])
        inverse = np.linalg.inv(columns.T @ columns)
        assert score.sigma == pytest.approx(np.sqrt(inverse[2, 2]), rel=1e-6)
        value = (inverse @ columns.T @ segment.residual)[2]
        assert score.significance == pytest.approx(abs(value) / score.sigma, rel=1e-5, abs=1e-6)


def test_false_alarms_keep_to_their_level():
    alarms = sum(bool(problem(0.0, seed=seed)[0]) for seed in range(100, 200))
    assert alarms <= 9  # 4 expected at most


def test_a_current_offset_is_named_and_the_automatic_choice_removes_its_bias(
    record, changed, truth
):
    """Half a milliampere: Coulomb and viscous friction move by several sigma in least squares."""
    steps = record(seed=8, sigma_rpm=2.0)
    offset = changed(steps, current=steps.current - 5e-4)
    fit = identify(offset, inertia=INERTIA)
    assert {"current_offset", "asymmetry"} <= set(fit.findings[0].names)
    assert fit.findings[0].options[0] in ("--free current_bias", "--model directional")
    assert abs(fit.findings[0].significance) > 5.0
    text = next(w for w in fit.warnings if "current offset" in w)
    assert "BIC" in text
    assert "sigma of least squares" in text
    best = identify(offset, inertia=INERTIA, model="auto")
    assert any(c.startswith("current_bias estimated (") for c in best.choices)
    assert best.parameters["current_bias"] == pytest.approx(5e-4, abs=1.5e-4)
    for name in ("motor_constant", "viscous", "coulomb"):
        place = best.names.index(name)
        assert abs(best.values[place] - truth["stribeck"][name]) < 4.0 * best.sigma[place]


def test_a_clean_record_has_no_findings_and_the_simplest_model_is_chosen(record):
    fit = identify(record(), inertia=INERTIA, model="auto")
    assert fit.findings == ()
    assert fit.choices == ("friction model viscous-coulomb",)
    assert fit.to_dict()["diagnosis"] == []


def test_outliers_are_named_and_forgiven(record, changed):
    steps = record(seed=5)
    speed = steps.speed.copy()
    speed[::150] += 60.0 * RPM
    fit = identify(changed(steps, speed=speed), inertia=INERTIA, model="auto")
    assert any(c.startswith("student loss (outliers") for c in fit.choices)


def test_a_speed_without_sign_is_recognised_and_restored(record, changed):
    steps = record(seed=4, sigma_rpm=1.0)
    lost = changed(steps, speed=np.abs(steps.speed))
    finding = lost_sign(lost)
    assert finding is not None
    assert finding.names == ("unsigned_speed",)
    restored = signed_speed(lost)
    far = np.abs(steps.speed) > 5.0
    np.testing.assert_array_equal(np.sign(restored.speed[far]), np.sign(steps.speed[far]))
    assert lost_sign(restored) is None
    assert lost_sign(steps) is None


def test_a_current_without_sign_is_recognised_and_restored(record, changed):
    steps = record(seed=4, sigma_rpm=1.0)
    # a drive in speed mode: the setpoint tells the sense
    lost = changed(steps, current=np.abs(steps.current), setpoint=np.sign(steps.current))
    finding = lost_sign(lost)
    assert finding is not None
    assert finding.names == ("unsigned_current",)
    assert "--unsigned-current" in finding.options[0]
    np.testing.assert_array_equal(signed_current(lost).current, steps.current)
    # without a setpoint the torque tells, but for the moments at which the steps change
    alone = signed_current(changed(steps, current=np.abs(steps.current))).current
    assert np.mean(alone != steps.current) < 0.02


@pytest.mark.parametrize(
    ("factor", "slip"),
    [
        (1.0 / RPM, "rpm read as rad/s"),
        (RPM, "rad/s read as rpm"),
        (0.5 / np.pi, "rev/s read as rad/s"),
        (180.0 / np.pi, "deg/s read as rad/s"),
    ],
)
def test_slips_of_units_are_named(record, changed, factor, slip):
    steps = record()
    fit = identify(changed(steps, speed=factor * steps.speed), inertia=INERTIA, white_noise=True)
    assert fit.findings[0].names == ("units",)
    assert slip in fit.findings[0].titles[0]


@pytest.mark.parametrize(
    ("fields", "slip"),
    [
        ({"time": 1e3}, "ms read as s"),
        ({"time": 1e-3}, "s read as ms"),
        ({"speed": 1e3}, "mrad/s read as rad/s"),
        ({"speed": 1e-3}, "krpm read as rpm"),
    ],
)
def test_thousandfold_slips_of_time_and_speed_are_named(record, truth, fields, slip):
    """A slip scales the motor constant by a power law; only one slip makes all plausible."""
    name, factor = next(iter(fields.items()))
    steps = record()
    wrong = dataclasses.replace(steps, **{name: factor * getattr(steps, name)})
    motor = truth["stribeck"]["motor_constant"] * (factor if name == "speed" else 1.0 / factor)
    known = {"motor_constant": motor, "inertia": INERTIA}
    found = wrong_units(known, ("motor_constant",), [wrong])
    assert found.titles[0].endswith(f"most likely {slip}")


def clipped(steps, level):
    """Record whose current is limited in size, without noise."""
    limit = level * float(np.max(np.abs(steps.current)))
    return dataclasses.replace(steps, current=np.clip(steps.current, -limit, limit))


def test_a_clipped_current_without_noise_is_named_and_cut_out(record):
    steps = record()
    lost = clipped(steps, 0.7)
    finding = clipped_current(lost)
    at = np.abs(lost.current) == np.abs(lost.current).max()
    true = np.abs(steps.current[at]).max() / np.abs(lost.current).max()
    assert finding is not None
    assert finding.names == ("clipped_current",)
    assert finding.value == pytest.approx(true - 1.0, abs=0.05)
    rest = without_clipped(lost)
    assert clipped_current(rest) is None
    inside = at[:-1]
    starts = np.flatnonzero(rest.restart)
    assert not np.any(np.isin(rest.time[starts], steps.time[1:][~inside]))
    assert any("clipped" in note for note in rest.notes)


def test_steps_of_equal_size_are_not_clipped(record, truth):
    """The wheel accelerates as under the recorded current."""
    steps = record()
    assert clipped_current(steps) is None
    lost = clipped(steps, 0.7)
    friction = Stribeck(**{n: truth["stribeck"][n] for n in Stribeck.dimensions()})
    wheel = Wheel(INERTIA, truth["stribeck"]["motor_constant"], friction)
    speed, _ = jax.jit(speed_response)(
        wheel, jnp.asarray(steps.time), jnp.asarray(lost.current), 0.0
    )
    noise = 0.5 * np.random.default_rng(1).standard_normal(len(steps.time))
    equal = dataclasses.replace(lost, speed=np.asarray(speed) + noise)
    assert clipped_current(equal) is None


def test_a_pulse_counter_is_named(record, changed):
    steps = record(sigma_rpm=0.1, duration=220.0)
    step = 2.0 * np.pi / 6.0 / 0.1
    counted = changed(steps, speed=step * np.round(steps.speed / step))
    fit = identify(counted, inertia=INERTIA, white_noise=True)
    assert fit.findings[0].names == ("quantum",)
    assert "with 6 pulses per turn and a gate of 0.1 s" in fit.findings[0].titles[0]


def test_a_gap_across_a_step_is_bridged_as_by_hand(record, changed):
    """Thirty seconds are missing around a step of the current: two segments, fitted as two."""
    steps = record(seed=3)
    keep = (steps.time < 135.0) | (steps.time > 165.0)
    fields = {n: getattr(steps, n)[keep] for n in ("time", "current", "speed", "valid")}
    fit = identify(changed(steps, **fields), inertia=INERTIA, white_noise=True)
    assert fit.converged
    assert "initial_speed_restart_1" in fit.names
    halves = [
        changed(steps, **{n: getattr(steps, n)[part] for n in fields})
        for part in (steps.time < 135.0, steps.time > 165.0)
    ]
    both = identify(halves, inertia=INERTIA, white_noise=True)
    for name in ("motor_constant", "viscous", "coulomb"):
        assert fit.parameters[name] == pytest.approx(both.parameters[name], rel=2e-3)


def test_mean_speeds_over_the_intervals_give_the_same_wheel(record, changed, truth):
    steps = record(seed=3, sigma_rpm=0.0)
    mean = np.append(0.0, 0.5 * (steps.speed[1:] + steps.speed[:-1]))
    random = np.random.default_rng(1)
    speed = mean + 0.05 * random.standard_normal(len(mean))
    speed[0] = np.nan
    averaged = dataclasses.replace(
        changed(steps, speed=speed, valid=np.isfinite(speed)), averaged=True
    )
    fit = identify(averaged, inertia=INERTIA, white_noise=True)
    place = fit.names.index("motor_constant")
    true = truth["stribeck"]["motor_constant"]
    assert abs(fit.values[place] - true) < 4.0 * fit.sigma[place]
    late = identify(
        dataclasses.replace(averaged, averaged=False), inertia=INERTIA, white_noise=True
    )
    assert abs(late.values[place] - true) > 10.0 * late.sigma[place]


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ((None, None, 1501.0, 1.0), "the wheel reaches 1501 rad/s"),
        ((None, None, 0.099, 1.0), "the wheel reaches only 0.099 rad/s"),
        ((None, None, 100.0, 51.0), "the current reaches 51 A"),
        ((None, None, 100.0, 0.9e-3), "the current reaches only 0.0009 A"),
        ((0.1, None, 610.0, 1.0), "k_m times the largest speed is a back-EMF of 61 V"),
    ],
)
def test_each_limit_of_a_plausible_wheel_is_the_documented_one(values, reason):
    (found,) = implausible(*values)
    assert found.startswith(reason)
    inside = {1501.0: 1499.0, 0.099: 0.101, 51.0: 49.0, 0.9e-3: 1.1e-3, 610.0: 590.0}
    assert implausible(*(inside.get(value, value) for value in values)) == []


def test_every_lag_of_a_fast_record_is_near_a_level():
    """From a tenth of the sample interval to 0.1 s, no gap between the levels is above 10 dB."""
    record = SimpleNamespace(time=np.arange(0.0, 1.0, 1e-3))
    motion = SimpleNamespace(speed=np.linspace(0.0, 5.0, len(record.time)))
    levels = np.array(_lag([record], [motion]).scales)
    assert levels[0] <= 1.001e-4
    assert levels[-1] >= 0.1
    assert np.max(levels[1:] / levels[:-1]) < 3.4
