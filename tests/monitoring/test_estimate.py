"""Estimator of a window: dense algebra, a closed loop with known truth, and its honesty."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.monitoring.estimate import estimate
from gyrostat.monitoring.moments import Moments, Prior, coefficients, solve
from gyrostat.monitoring.noise import Noise, gram, window_covariance, window_variance
from gyrostat.monitoring.noise_search import USUAL
from gyrostat.monitoring.regression import Rows
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels
from tests.monitoring.closed_loop import NOMINAL, fly

SIGMA = {"motor_constant": 0.005 * 0.027, "viscous": 0.02 * 5e-6, "offset": 1e-9}


def known(sigma=SIGMA):
    return KnownWheels((KnownWheel("a", stribeck_speed=0.5, sigma=dict(sigma), **NOMINAL),))


def dense(time, white, noise):
    apart = np.abs(time[:, None] - time)
    return np.exp(noise.log_ratio - apart / np.exp(noise.log_time)) + np.diag(white)


@pytest.fixture
def random():
    return np.random.default_rng(3)


@pytest.fixture
def blocks(random):
    """Times with gaps, and variances."""
    time = 60.0 * np.cumsum(1.0 + 20.0 * (random.random(200) < 0.1))
    return time, 0.5 + random.random(200)


def test_products_are_those_of_dense_algebra(random, blocks):
    time, white = blocks
    columns, noise = random.standard_normal((200, 5)), Noise(np.log(20.0), np.log(900.0))
    noises = [noise, Noise(np.log(0.5), np.log(100.0))]
    own = random.standard_normal((2, 200))
    products, log_det = gram(columns, time, white, noises, own)
    for each, column, found, log in zip(noises, own, products, log_det, strict=True):
        covariance = dense(time, white, each)
        both = np.column_stack([columns, column])
        np.testing.assert_allclose(found, both.T @ np.linalg.solve(covariance, both), 1e-9)
        assert log == pytest.approx(np.linalg.slogdet(covariance)[1], abs=1e-9)


def test_the_mean_of_the_noise_has_the_covariance_of_a_fine_sum():
    fine = np.arange(5.0, 40000.0, 10.0)
    tau = 1500.0
    at = np.array([100.0, 20000.0, 39000.0])
    by_sum = np.exp(-np.abs(fine[:, None] - at) / tau).mean(axis=0)
    np.testing.assert_allclose(window_covariance(at, 0.0, 40000.0, tau), by_sum, 1e-5)
    both = np.exp(-np.abs(fine[:, None] - fine) / tau).mean()
    assert window_variance(0.0, 40000.0, tau) == pytest.approx(both, rel=1e-4)


def test_without_instruments_the_solution_is_generalised_least_squares(random, blocks):
    time, white = blocks
    value = np.array([0.03, 1e-3, 5e-6, 2e-5])
    columns = np.column_stack(
        [1e-3 * random.standard_normal(200), np.ones(200), 100.0 * random.random(200),
         np.sign(random.standard_normal(200))]
    )  # fmt: skip
    noise = Noise(np.log(20.0), np.log(900.0))
    covariance = 1e-10 * dense(time, white, noise)
    response = columns @ coefficients(value)[0]
    response += np.linalg.cholesky(covariance) @ random.standard_normal(200)
    products = gram(np.column_stack([columns, response]), time, white, [noise])[0][0]
    x, y = slice(0, 4), 4
    same = products[x, x]
    moments = Moments(same, same, same, products[x, y], products[x, y], products[y, y])
    solution = solve(moments, Prior(value, np.zeros(4)), value, 200)
    weight = np.linalg.inv(covariance)
    beta = np.linalg.solve(columns.T @ weight @ columns, columns.T @ weight @ response)
    np.testing.assert_allclose(solution.beta, beta, rtol=1e-6)


def test_the_predicted_mean_is_that_of_the_conditional_distribution(random):
    """The oracle conditions the joint Gaussian of blocks and mean on the blocks."""
    time = 30.0 + 60.0 * np.arange(300)
    noise = Noise(np.log(30.0), np.log(1200.0))
    white, scale = np.ones(300), 1e-8
    slow = scale * np.exp(noise.log_ratio - np.abs(time[:, None] - time) / np.exp(noise.log_time))
    drawn = np.linalg.cholesky(slow + 1e-18 * np.eye(300)) @ random.standard_normal(300)
    motor, coulomb = 0.03, 1e-3
    torque = 1e-3 * random.standard_normal(300)
    response = torque / motor + coulomb / motor + drawn
    response += np.sqrt(scale) * random.standard_normal(300)
    columns = np.column_stack([torque, np.ones(300), np.full(300, 100.0), np.ones(300)])
    columns = np.column_stack([columns, np.zeros((300, 2))])
    # motor and viscous friction known, no offset, no lags
    prior = Prior(np.array([motor, *[0.0] * 5]), np.array([1e16, 0.0, 1e24, *[1e20] * 3]))
    rows = Rows(time, white, response, columns, columns, np.zeros((300, 2)), 0.0, 18000.0)
    found = estimate(rows, prior, np.array([motor, coulomb, *[0.0] * 4]), USUAL)
    total = slow + scale * np.eye(300)
    weights = np.linalg.solve(total, np.ones(300))
    level = weights @ (response - torque / motor) / weights.sum()
    share = np.linalg.solve(total, slow.mean(axis=0))
    mean = motor * (level + share @ (response - torque / motor - level))
    # noise is estimated here and known there
    assert abs(found.mean - mean) < 0.3 * np.sqrt(found.mean_variance)
    assert np.sqrt(found.mean_variance) < 0.5 * np.sqrt(found.covariance[1, 1])


@pytest.fixture(scope="module")
def quiet():
    return [fly(seed, slews=False) for seed in range(6)]


def rows_of(samples, wheels):
    monitor = WheelMonitor(wheels)
    monitor.add(samples)
    table = monitor.windows()
    assert len(table) == 1
    return {name: values[0] for name, values in table.columns.items()}


def test_least_squares_is_trapped_by_the_loop_and_the_monitor_is_not(quiet):
    """In quiet pointing the speed hardly answers the current, because the loop cancels friction."""
    by_least_squares, scores = [], []
    for samples, truth in quiet:
        speed, current = samples.speed[:, 0], samples.drive[:, 0]
        steps = slice(None, None, 60)
        torque = NOMINAL["inertia"] * np.diff(speed[steps]) / 60.0
        mean = np.add.reduceat(current, np.arange(0, current.size, 60))[: torque.size] / 60.0
        columns = np.column_stack([mean, -np.ones(torque.size), -speed[steps][:-1]])
        solution = np.linalg.lstsq(columns, torque, rcond=None)[0]
        by_least_squares.append(solution[1] / truth.mean - 1.0)
        row = rows_of(samples, known())
        assert row["valid"]
        assert row["coulomb_observable"]
        assert row["coulomb_scatter"] < 0.003 * truth.mean
        scores.append((row["coulomb"] - truth.mean) / row["coulomb_sigma"])
    assert np.median(np.abs(by_least_squares)) > 0.5
    assert np.max(np.abs(scores)) < 3.0


def test_quiet_pointing_without_knowledge_says_not_observable(quiet):
    for samples, _ in quiet[:3]:
        row = rows_of(samples, known(sigma={}))
        assert not row["coulomb_observable"]
        assert not row["motor_constant_observable"]
        assert "the speed stays within" in row["coulomb_reason"]
        assert "one sign" in row["offset_reason"]


def test_slews_show_motor_and_friction_without_knowledge():
    scores = []
    for seed in range(6):
        samples, truth = fly(seed, slews=True)
        row = rows_of(samples, known(sigma={"offset": 1e-9}))
        assert row["coulomb_observable"]
        assert row["motor_constant_observable"]
        assert row["motor_constant_sigma"] < 0.01 * truth.motor_constant
        scores += [
            (row["coulomb"] - truth.mean) / row["coulomb_sigma"],
            (row["motor_constant"] - truth.motor_constant) / row["motor_constant_sigma"],
            (row["viscous"] - truth.viscous) / row["viscous_sigma"],
        ]
    assert np.sqrt(np.mean(np.square(scores))) < 1.6
    assert np.max(np.abs(scores)) < 4.0


def test_a_wrong_motor_constant_is_found_and_not_used():
    samples, truth = fly(2, slews=True)
    wheel = KnownWheel(
        "a", stribeck_speed=0.5, sigma=dict(SIGMA), **NOMINAL | {"motor_constant": 0.025}
    )
    row = rows_of(samples, KnownWheels((wheel,)))
    assert row["motor_constant"] == pytest.approx(truth.motor_constant, rel=0.02)
    assert row["coulomb"] == pytest.approx(truth.mean, rel=0.03)


def test_viscous_friction_known_at_20_degrees_does_not_bias_a_warmer_wheel(quiet):
    sigma = SIGMA | {"viscous": 0.01 * 5e-6}
    for samples, truth in quiet[:3]:
        bench = NOMINAL | {"viscous": truth.viscous * 1.06}  # thins by 1.5 % a kelvin
        wheels = KnownWheels((KnownWheel("a", stribeck_speed=0.5, sigma=sigma, **bench),))
        warm = replace(samples, temperature=np.full(samples.speed.shape, 24.0))
        row = rows_of(warm, wheels)
        assert abs(row["coulomb"] - truth.mean) < 3.0 * row["coulomb_sigma"]
        assert abs(row["viscous"] - truth.viscous) < 3.0 * row["viscous_sigma"]
        assert row["viscous_known"] == pytest.approx(4.0 * 0.05 * bench["viscous"], rel=0.01)
        assert row["motor_constant_known"] == pytest.approx(SIGMA["motor_constant"])


def test_a_wrong_motor_constant_is_not_used_however_sure_it_is_stated():
    samples, truth = fly(3, slews=True)
    stated = NOMINAL | {"motor_constant": 0.024}
    given = SIGMA | {"motor_constant": 0.002 * 0.024}
    row = rows_of(samples, KnownWheels((KnownWheel("a", sigma=given, **stated),)))
    assert abs(row["motor_constant"] - truth.motor_constant) < 3.0 * row["motor_constant_sigma"]
    assert abs(row["coulomb"] - truth.mean) < 3.0 * row["coulomb_sigma"]


def test_without_current_nothing_is_observable(quiet):
    monitor = WheelMonitor(known(), drive="none")
    monitor.add(quiet[0][0])
    table = monitor.windows()
    assert not table["coulomb_observable"][0]
    assert "no motor current, electrical power or commanded torque" in table["coulomb_reason"][0]
    assert np.isfinite(table["speed_mean"][0])
