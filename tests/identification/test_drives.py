"""Identification of drives in closed loop against drives with known parameters."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from gyrostat.core.errors import InputError
from gyrostat.identification import identify_inverse
from gyrostat.identification.drive.filtered_reference import filtered_reference
from gyrostat.identification.drive.motion import drives as segments_of
from gyrostat.identification.drive.parts import part_of
from gyrostat.identification.drive.regression import covariance, regress
from gyrostat.identification.drive.tracking import tracking
from gyrostat.identification.drive.weak_form import Windows
from gyrostat.telemetry import Record

BENCHMARK = Path(__file__).resolve().parents[2] / "benchmarks" / "drives.py"
NAMES = ("inertia", "viscous", "coulomb")


@pytest.fixture(scope="module")
def drives(module_at):
    """The benchmark, whose drives have an integrator of their own."""
    return module_at(BENCHMARK)


@pytest.fixture(scope="module")
def servo(drives):
    return replace(drives.CASES["cascade"], interval=2e-3, duration=20.0)


@pytest.fixture(scope="module")
def quiet(drives, servo):
    return drives.simulate(replace(servo, disturbance=0.0, quantum=0.0), 0, 40)


@pytest.fixture(scope="module")
def noisy(drives, servo):
    return [drives.simulate(servo, seed) for seed in range(8)]


def held(true):
    return {"motor_constant": true["motor_constant"]}


def test_without_noise_the_result_is_exact(quiet, servo):
    record, true = quiet
    fit = identify_inverse(record, hold=held(true), law=servo.law)
    for name in NAMES:
        assert fit.parameters[name] == pytest.approx(true[name], rel=2e-4)
        output_error = fit.inverse.methods["output_error"].values[name]
        assert output_error == pytest.approx(true[name], rel=0.02)
    bias = servo.offset / true["motor_constant"]
    assert fit.parameters["current_bias"] == pytest.approx(bias, rel=1e-3)
    assert fit.converged
    assert not fit.impossible
    assert fit.inverse.followed > 0.9999


def test_points_of_the_friction_curve_are_on_it(quiet):
    record, true = quiet
    fit = identify_inverse(record, hold=held(true))
    points = fit.friction_points
    curve = true["viscous"] * points.speed + np.sign(points.speed) * true["coulomb"]
    np.testing.assert_allclose(points.torque, curve, rtol=1e-3)
    assert len(points.speed) > 10
    assert np.all((points.when > 0.0) & (points.when < 1.0))


def test_motor_constant_is_found_at_a_known_inertia(quiet, servo):
    record, true = quiet
    fit = identify_inverse(record, inertia=true["inertia"])
    for name in ("motor_constant", "viscous", "coulomb"):
        assert fit.parameters[name] == pytest.approx(true[name], rel=2e-4)
    bias = servo.offset / true["motor_constant"]
    assert fit.parameters["current_bias"] == pytest.approx(bias, rel=1e-3)


def test_instruments_remove_the_bias_of_least_squares(noisy):
    """`benchmarks/drives.py` measures the coverage; here 8 records."""
    errors, biased, scores = [], [], []
    for record, true in noisy:
        fit = identify_inverse(record, hold=held(true))
        assert not fit.impossible
        errors.append(fit.parameters["inertia"] / true["inertia"] - 1.0)
        least = fit.inverse.methods["least_squares"].values["inertia"]
        biased.append(least / true["inertia"] - 1.0)
        scores += [(fit.parameters[n] - true[n]) / fit.sigma[n] for n in NAMES]
        assert fit.sigma["inertia"] < 0.05 * true["inertia"]
    spread = np.std(errors) / np.sqrt(len(errors))
    assert abs(np.mean(errors)) < 4.0 * spread
    assert np.mean(biased) < -4.0 * spread
    assert 0.5 < np.sqrt(np.mean(np.square(scores))) < 1.6


def test_a_wrong_control_law_is_refused(noisy, servo):
    record, true = noisy[0]
    slow = replace(servo.law, kp=servo.law.kp / 100.0)
    fit = identify_inverse(record, hold=held(true), law=slow)
    assert any("the stated control law has only" in reason for reason in fit.impossible)


def test_a_law_that_follows_but_is_not_that_of_the_record_is_warned_of(quiet, servo):
    record, true = quiet
    right = identify_inverse(record, hold=held(true), law=servo.law)
    assert not any("the control law is not that" in warning for warning in right.warnings)
    stiff = replace(servo.law, kp=2.0 * servo.law.kp, kd=2.0 * servo.law.kd)
    fit = identify_inverse(record, hold=held(true), law=stiff)
    assert not fit.impossible
    assert any("the control law is not that of this record" in each for each in fit.warnings)
    assert not fit.inverse.methods["output_error"].converged


@pytest.mark.parametrize("factor", [0.6, 1.5])
def test_gains_of_another_loop_are_warned_of_in_noise(noisy, servo, factor):
    """The motion is nearly the same: the tracking error is not."""
    record, true = noisy[1]
    kp, kd = factor * servo.law.kp, factor * servo.law.kd
    fit = identify_inverse(record, hold=held(true), law=replace(servo.law, kp=kp, kd=kd))
    assert not fit.impossible
    (said,) = [each for each in fit.warnings if "the tracking error is" in each]
    assert float(said.split()[4]) == pytest.approx(factor, rel=0.15)


def test_the_right_law_is_not_warned_of_in_noise(noisy, servo):
    for record, true in noisy:
        fit = identify_inverse(record, hold=held(true), law=servo.law)
        assert not any("the tracking error is" in each for each in fit.warnings)


def test_a_drive_at_its_limit_throughout_shows_no_gains(noisy, servo):
    record, _ = noisy[0]
    (part,) = segments_of(record, "zero-order")
    law = replace(servo.law, saturation=0.5 * float(np.min(np.abs(part.current[1:]))))
    assert tracking(law, [part_of(part, 0.02)], [part.measured]) is None


@pytest.mark.parametrize(("samples", "late"), [(1, "current"), (-1, "speed")])
def test_a_delay_between_current_and_speed_is_warned_of(quiet, samples, late):
    record, true = quiet
    fit = identify_inverse(record, hold=held(true))
    assert not any("is late by" in warning for warning in fit.warnings)
    fit = identify_inverse(
        replace(record, current=np.roll(record.current, samples)), hold=held(true)
    )
    said = [each.split(" is late by ") for each in fit.warnings if " is late by " in each]
    ((what, time),) = said
    assert what == f"the recorded {late}"
    assert float(time.split()[0]) == pytest.approx(2.0, rel=0.02)


def test_a_measured_motion_as_reference_is_refused(quiet):
    record, true = quiet
    angle = np.append(0.0, np.cumsum(record.speed[1:] * np.diff(record.time)))
    with pytest.raises(InputError, match="column reference: found the measured motion"):
        identify_inverse(replace(record, reference=angle), hold=held(true))
    speed = replace(record, reference=None, setpoint=np.nan_to_num(record.speed))
    with pytest.raises(InputError, match="column setpoint: found the measured motion"):
        identify_inverse(speed, hold=held(true))


def test_stribeck_friction_is_linear_at_a_known_speed(quiet):
    record, true = quiet
    hold = {**held(true), "stribeck_speed": 0.05}
    fit = identify_inverse(record, hold=hold, model="stribeck")
    for name in ("inertia", "viscous", "coulomb"):
        assert fit.parameters[name] == pytest.approx(true[name], rel=1e-3)
    assert abs(fit.parameters["static"] - true["coulomb"]) < 4.0 * fit.sigma["static"]


def test_lost_rows_cut_a_record_in_a_closed_loop(noisy):
    """The current of a lost row is not that before it: the inertia was 10 sigma off."""
    record, true = noisy[2]
    kept = np.ones(len(record.time), bool)
    for start in np.random.default_rng(5).integers(100, len(kept) - 100, 30):
        kept[start : start + 8] = False
    names = ("time", "current", "speed", "valid", "reference")
    lost = replace(record, **{name: getattr(record, name)[kept] for name in names})
    assert len(segments_of(lost, "zero-order")) > 20
    fit = identify_inverse(lost, hold=held(true))
    assert not fit.impossible
    for name in NAMES:
        assert abs(fit.parameters[name] - true[name]) < 3.0 * fit.sigma[name]
    uneven = replace(record, time=np.cumsum(np.tile([1.0, 3.0, 1.0], 4000)[: len(record.time)]))
    assert len(segments_of(uneven, "zero-order")) == 1


def test_windows_of_a_short_record_have_six_intervals(noisy):
    record, true = noisy[0]
    columns = half(record, 0)
    short = replace(record, **{name: column[:31] for name, column in columns.items()})
    with pytest.raises(InputError, match=r"windows of 0\.012 s"):
        identify_inverse(short, hold=held(true))


def test_filtered_reference_of_a_segment_starts_at_rest():
    time = 0.01 * np.arange(400)
    reference = 100.0 + 5.0 * (time > 1.0)
    speed = 100.0 + lfilter([0.0, 0.05], [1.0, -0.95], reference - 100.0)
    record = Record("ramp", time, 0.0 * time, speed, time >= 0.0, setpoint=reference)
    (drive,) = segments_of(record, "zero-order")
    predicted = filtered_reference(drive)
    np.testing.assert_allclose(predicted.mean_speed, drive.measured.mean_speed, atol=0.1)


def test_held_out_torque_is_predicted(noisy):
    record, true = noisy[0]
    first, second = (replace(record, **half(record, k)) for k in (0, 1))
    fit = identify_inverse(first, hold=held(true), held_out=[replace(second, name="other")])
    own = fit.inverse.torque_error[first.name]
    assert 0.5 * own < fit.inverse.held_out["other"] < 2.0 * own
    assert any("torque error on held-out other" in line for line in fit.inverse.lines())
    without = replace(second, reference=None)
    same = identify_inverse(first, hold=held(true), held_out=[without])
    assert same.inverse.held_out[second.name] == fit.inverse.held_out["other"]
    reversed_current = replace(second, current=-second.current)
    wrong = identify_inverse(first, hold=held(true), held_out=[reversed_current])
    assert any("the drive, a sign or a unit is not that" in each for each in wrong.warnings)
    assert not any("the drive, a sign" in each for each in same.warnings)
    still = replace(second, speed=0.0 * second.speed)
    with pytest.raises(InputError, match="expected a held-out record in which it does"):
        identify_inverse(first, hold=held(true), held_out=[still])


def half(record, place):
    """Columns of the first or the second half of a record."""
    middle = len(record.time) // 2
    part = slice(place * middle, (place + 1) * middle)
    return {n: getattr(record, n)[part] for n in ("time", "current", "speed", "valid", "reference")}


def test_halves_of_a_record_give_together_what_the_record_gives(noisy):
    record, true = noisy[0]
    whole = identify_inverse(record, hold=held(true))
    halves = [replace(record, name=str(k), **half(record, k)) for k in (0, 1)]
    both = identify_inverse(halves, hold=held(true))
    for name in NAMES:
        assert abs(both.parameters[name] - whole.parameters[name]) < whole.sigma[name]
        assert both.sigma[name] == pytest.approx(whole.sigma[name], rel=0.3)


def test_what_is_missing_is_said(noisy):
    record, true = noisy[0]
    with pytest.raises(InputError, match="found no column reference or setpoint"):
        identify_inverse(replace(record, reference=None), hold=held(true))
    with pytest.raises(InputError, match="found neither --inertia nor --hold motor_constant=VALUE"):
        identify_inverse(record)
    short = replace(record, **{n: v[:60] for n, v in half(record, 0).items()})
    with pytest.raises(InputError, match="in which the drive moves, expected 40 or more"):
        identify_inverse(short, hold=held(true))


def test_a_drive_that_turns_one_way_does_not_tell_friction_from_an_offset(noisy):
    record, true = noisy[0]
    further = 500.0 * (record.time - record.time[0])
    one_way = replace(record, reference=record.reference + further, speed=record.speed + 500.0)
    with pytest.raises(InputError, match="turns one way, expected both: coulomb and an offset"):
        identify_inverse(one_way, hold=held(true))
    known = {**held(true), "current_bias": 0.0}
    assert "current_bias" not in identify_inverse(one_way, hold=known).names


def test_windows_average_and_differentiate():
    """A window has the mean 1 of a constant, and the slope of a straight speed, at any times."""
    time = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, 400))
    windows = Windows.over(time, 12.0)
    middle = 0.5 * (time[1:] + time[:-1])
    size = windows.mean @ np.ones(399)
    np.testing.assert_allclose(size, 1.0, rtol=5e-3)
    np.testing.assert_allclose(windows.slope @ (3.0 + 0.7 * middle), 0.7 * size, rtol=1e-9)
    np.testing.assert_allclose(windows.slope @ np.full(399, 5.0), 0.0, atol=1e-12)


def test_regression_is_that_of_the_normal_equations():
    rng = np.random.default_rng(2)
    instruments = rng.normal(size=(500, 3))
    regressors = instruments @ rng.normal(size=(3, 3)) + 0.1 * rng.normal(size=(500, 3))
    target = regressors @ [1.0, -2.0, 0.5] + rng.normal(size=500)
    solution = regress(instruments, regressors, target)
    expected = np.linalg.solve(instruments.T @ regressors, instruments.T @ target)
    np.testing.assert_allclose(solution, expected, rtol=1e-10)


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_covariance_is_that_of_correlated_errors(memory):
    """Against the exact covariance of an autoregression of first order."""
    rng = np.random.default_rng(3)
    count = 20_000
    rows = np.column_stack([np.ones(count), np.sign(np.sin(np.arange(count) / 40.0))])
    error = np.zeros(count)
    for k, kick in enumerate(rng.normal(size=count)):
        error[k] = memory * error[k - 1] + kick
    lags = np.arange(-300, 301)
    correlation = memory ** np.abs(lags) / (1.0 - memory**2)
    power = [np.convolve(c, correlation, mode="same") for c in rows.T]
    meat = rows.T @ np.column_stack(power)
    bread = np.linalg.inv(rows.T @ rows)
    found = covariance(rows, rows, error, [np.arange(count)])
    exact = bread @ meat @ bread
    np.testing.assert_allclose(np.diag(found), np.diag(exact), rtol=0.2)
