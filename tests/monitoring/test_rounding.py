"""A current rounded to steps without noise has errors that the intervals contain."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtri

from gyrostat.monitoring.blocks import blocks_of
from gyrostat.monitoring.drive_samples import resolution
from gyrostat.monitoring.estimate import _points, all_columns, estimate
from gyrostat.monitoring.moments import MOTOR, Prior
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.rounding import rounding_errors, widened
from gyrostat.monitoring.rows import prior_of, regression_rows
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels
from tests.monitoring.closed_loop import NOMINAL
from tests.monitoring.test_drive_samples import (
    DURATION,
    RPM,
    SHEET,
    short_slews,
    smooth_slews,
    turned,
)
from tests.monitoring.test_instruments import PARAMETERS, scores


@pytest.mark.parametrize(("step", "dither"), [(5e-3, 0.0), (5e-3, 0.2), (1e-3, 0.0)])
@pytest.mark.parametrize("slews", [short_slews, smooth_slews])
def test_a_current_rounded_with_little_noise_biases_nothing(step, dither, slews):
    # short slews with 5 mA: viscous friction was 40 sigma off
    flights = [turned(slews(), seed, step=step, dither=dither) for seed in range(300, 312)]
    values = np.array([scores(each, SHEET, float(DURATION))[:, 0] for each in flights])
    assert np.sqrt(np.mean(values**2, axis=0)) == pytest.approx(0.0, abs=1.7)


@pytest.mark.parametrize("dither", [0.0, 0.2])
@pytest.mark.parametrize("step", [5e-3, 1e-2])
@pytest.mark.parametrize("slews", [short_slews, smooth_slews])
def test_rounding_makes_nothing_known_of_a_bench_less_certain(step, dither, slews):
    # by rounding alone, 17 % of the viscous friction and 23 % of the Coulomb torque
    sigma = np.array([0.005, 0.02])
    found = []
    for seed in range(950, 956):
        samples, truth = turned(slews(), seed, step=step, dither=dither)
        right = np.array([truth.motor_constant, truth.viscous, truth.mean])
        errors = np.random.default_rng(seed).standard_normal(2)
        stated = right[:2] * (1.0 + sigma * errors)
        rotor = KnownWheel(
            "a",
            **{**NOMINAL, "motor_constant": stated[0], "viscous": stated[1]},
            stribeck_speed=0.5,
            sigma=dict(zip(PARAMETERS, sigma * right[:2], strict=False)),
        )
        monitor = WheelMonitor(KnownWheels((rotor,)), window=float(DURATION))
        monitor.add(samples)
        table = monitor.windows()
        told = np.array([table[f"{name}_sigma"][0] for name in PARAMETERS])
        assert np.all(told < np.array([1.03 * 0.005, 1.03 * 0.02, 0.1]) * right)
        assert "viscous" in table["held_as_stated"][0].split(", ")
        found.append([table[name][0] for name in PARAMETERS] - right)
        found[-1] /= told
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(0.0, abs=1.6)


def test_the_resolution_is_found_below_errors_of_arithmetic():
    samples, truth = turned(short_slews(), 300, step=5e-3, dither=0.0)
    tiny = 1e-9 * np.random.default_rng(0).standard_normal(samples.drive.shape)
    values = scores((replace(samples, drive=samples.drive + tiny), truth), SHEET, float(DURATION))
    exact = scores((samples, truth), SHEET, float(DURATION))
    assert values == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3])
def test_rounding_errors_of_two_currents_are_those_of_a_sawtooth_of_any_phase(noise):
    step = 3.0
    levels = np.linspace(10.0, 10.0 + 1.3 * step, 14)
    phase = (np.arange(400)[:, None, None] + 0.5) / 400.0 * step
    dither = noise * step * ndtri((np.arange(801) + 0.5) / 801.0)
    current = levels[:, None] + phase
    error = np.mean(np.round((current + dither) / step) * step - current, axis=-1)
    errors = rounding_errors(*wheel_at(levels, step, noise), step=step)
    # eight terms leave 0.6 % of step² of the variance of a sawtooth without noise
    assert errors @ errors.T == pytest.approx(error.T @ error / 400.0, abs=0.0065 * step**2)
    if noise == 0.3:
        assert np.sum(errors[0] ** 2) == pytest.approx(np.mean(error[:, 0] ** 2), rel=1e-2)


def wheel_at(levels, step, noise):
    """Arguments of `rounding_errors` for known currents and noise of a share of the step."""
    count = levels.size
    scatter = step * np.sqrt(noise**2 + 1.0 / 12.0)
    blocks = SimpleNamespace(step=np.full((count, 1), step), scatter=np.full((count, 1), scatter))
    regressors = np.zeros((count, 6))
    regressors[:, MOTOR] = levels
    rows = SimpleNamespace(time=np.arange(count), regressors=regressors, start=0.0, end=1e6)
    known = np.array([1.0, *np.zeros(5)])
    value = SimpleNamespace(
        value=known, beta=known, noise=Noise(0.0, 1.0), noise_sigma=0.0, white_sigma=1e-3
    )
    return blocks, 0, rows, Prior(known, np.full(6, 1e12)), value


def test_friction_noise_that_wanders_through_the_steps_leaves_less():
    levels, step = np.linspace(10.0, 14.0, 8), 3.0
    arguments = wheel_at(levels, step, 0.0)
    # of a correlation time far below the window; what is found contains what rounding adds, of a
    # few levels up to three times its mean
    calm = np.sqrt(np.sum(rounding_errors(*arguments, step=step)[0] ** 2))
    arguments[-1].noise_sigma = np.sqrt((0.3 * step) ** 2 + 3.0 * calm**2)
    left = np.sum(rounding_errors(*arguments, step=step)[0] ** 2)
    alone = step**2 / (2.0 * np.pi**2) * np.exp(-4.0 * np.pi**2 * 0.3**2)
    assert left == pytest.approx(alone, rel=0.05)


def test_currents_that_all_round_to_one_value_leave_the_viscous_friction_open():
    levels, step = np.full(40, 10.0), 3.0
    blocks, wheel, rows, _, value = wheel_at(levels, step, 0.0)
    rows.regressors[:, 2] = np.linspace(0.0, 1.0, 40)
    value.white_sigma = 0.01
    open_ = Prior(value.beta, np.array([1e12, 0.0, 0.5, 1e12, 1e12, 1e12]))
    errors = rounding_errors(blocks, wheel, rows, open_, value, step=step)
    # what is known, and what a rounded range of 1 tells; with the motor constant, two dimensions
    spread = np.sqrt(2.0 / (0.5 + 12.0 / step**2))
    order = np.arange(1, 9)
    alike = 0.5 + 0.5 * np.sum(np.cos(2.0 * np.pi / step * order * spread) / order**2) / np.sum(
        1.0 / order**2
    )
    assert errors[-1] @ errors[0] == pytest.approx(alike * errors[0] @ errors[0], rel=1e-3)
    sure = Prior(value.beta, np.full(6, 1e12))
    same = rounding_errors(blocks, wheel, rows, sure, value, step=step)
    assert same[-1] == pytest.approx(same[0], abs=1e-5)


def test_enough_noise_leaves_no_error_and_an_estimate_as_it_is():
    levels = np.linspace(10.0, 14.0, 8)
    blocks, wheel, rows, prior, value = wheel_at(levels, 3.0, 0.6)

    def shape():
        step = resolution(blocks, wheel)
        return rounding_errors(blocks, wheel, rows, prior, value, step=step).shape

    value.white_sigma = 0.003
    assert shape() == (8, 8)
    value.white_sigma = 0.3
    assert shape() == (8, 0)
    blocks.step[:] = np.inf  # of a current that does not change
    assert shape() == (8, 0)
    assert widened(rows, value, np.zeros((8, 0))) is value


def test_an_error_of_the_response_moves_an_estimate_as_its_covariance_says():
    samples, _ = turned(smooth_slews(), 7)
    sigma = {"motor_constant": 0.5 * 0.027, "viscous": 5e-6}
    rotor = KnownWheel("a", **NOMINAL, stribeck_speed=0.5, sigma=sigma)
    known = KnownWheels((rotor,), speed_resolution=0.4 * RPM)
    blocks, _ = blocks_of(samples, 60.0, 0.4 * RPM)
    window = (0.0, float(DURATION))
    rows = regression_rows(blocks, known, 0, window, 60.0, power=False, step=resolution(blocks, 0))
    prior = prior_of(rotor, 6, 1.0, np.nan)
    value = estimate(rows, prior, prior.mean.copy(), Noise(3.0, 7.0))
    shape = np.cos(rows.regressors @ value.beta / 1e-3) + rows.time / DURATION

    def solved(size):
        moved = replace(rows, response=rows.response + size * shape)
        points = _points(moved, all_columns(moved), prior, value.value, [value.noise])
        return points.solution, points.mean[0]

    (up, high), (down, low) = solved(1e-6), solved(-1e-6)
    moved = (up.value - down.value)[0] / 2e-6
    middle, mean = solved(0.0)
    value = replace(value, covariance=middle.covariance[0], white_sigma=np.sqrt(middle.scale[0]))
    value = replace(value, value=middle.value[0], beta=middle.beta[0], mean=mean)
    wide = widened(rows, value, shape[:, None])
    change = (high - low) / 2e-6
    added = np.diagonal(wide.covariance - value.covariance)
    assert np.sqrt(added[:3]) == pytest.approx(np.abs(moved[:3]), rel=0.03)
    scatter = wide.scatter - value.scatter
    assert scatter == pytest.approx(wide.covariance - value.covariance, rel=1e-6)
    assert wide.mean_scatter - value.mean_scatter == pytest.approx(change**2, rel=0.06)
    assert np.sqrt(wide.mean_variance - value.mean_variance) == pytest.approx(abs(change), rel=0.03)
    towards = (wide.mean_covariance - value.mean_covariance)[:3]
    assert towards == pytest.approx(moved[:3] * change, rel=0.05)
